# SPDX-License-Identifier: GPL-3.0-or-later
"""MakeHuman's shape targets brought onto the bundled body: displacements in its T-pose."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np

from w2w.core.body.body import JOINT_INDEX, MIRRORED_JOINTS, Body
from w2w.core.body.shapes import LIMB_STEP, ShapeTargets
from w2w.core.files import write_npz

from . import rig
from .makehuman import AVERAGE, N_BODY_VERTICES, SEXES, Source
from .pipeline import FLIP, Binding, PosedSource

MUSCULAR = 0.7
"""Share of MakeHuman's most muscular body in ours: beyond it thighs and neck cut into themselves."""

LIMBS: dict[str, tuple[tuple[str, str], tuple[str, ...]]] = {
    "arms": (
        ("left_shoulder", "left_wrist"),
        ("arms/measure-upperarm-length", "arms/measure-lowerarm-length"),
    ),
    "legs": (("left_hip", "left_ankle"), ("legs/measure-upperleg-height", "legs/measure-lowerleg-height")),
}
"""Joints that a limb's length is measured between, and the targets that lengthen or shorten it."""


def makehuman_targets(source: Source) -> dict[str, np.ndarray]:
    """Displacements in MakeHuman's A-pose, metres, by the names of `core.shapes`; each (19158, 3)."""
    female, male = (source.person(sex, "young") for sex in SEXES)
    targets = {"male": (male - female) / 2}
    for sex in SEXES:
        young = f"macrodetails/universal-{sex}-young"
        tall = f"macrodetails/height/{sex}-young-{AVERAGE}"
        targets[f"{sex} taller"] = source.target(f"{tall}-maxheight")
        targets[f"{sex} shorter"] = source.target(f"{tall}-minheight")
        targets[f"{sex} heavier"] = source.target(f"{young}-minmuscle-maxweight")
        targets[f"{sex} lighter"] = source.target(f"{young}-minmuscle-minweight")
        targets[f"{sex} muscular"] = MUSCULAR * source.target(f"{young}-maxmuscle-maxweight")
        targets[f"{sex} old"] = source.person(sex, "old") - source.person(sex, "young")
    for limb, (_, names) in LIMBS.items():
        targets[f"longer {limb}"] = sum(source.target(f"{name}-incr") for name in names)
        targets[f"shorter {limb}"] = sum(source.target(f"{name}-decr") for name in names)
    return targets


def make_targets(source: Source, posed: PosedSource, body: Body, binding: Binding) -> ShapeTargets:
    """The shape targets of the bundled body.

    Vertices follow their place on the source, joints the joint cubes; both pass linearly
    into the T-pose, so a target's displacement is the exact difference of two bodies.
    """
    cubes = source.mesh()[2]
    n_half = len(binding.corners)
    vertices, joints = {}, {}
    for name, moved in makehuman_targets(source).items():
        joint_moves = rig.joint_positions(moved, cubes)
        vertex_moves, joint_moves = posed.t_pose.apply(moved[:N_BODY_VERTICES], joint_moves, posed.weights)
        joint_moves = (joint_moves + joint_moves[list(MIRRORED_JOINTS)] * FLIP) / 2
        half = binding.carry(vertex_moves)
        half[body.mirror[:n_half] == np.arange(n_half), 0] = 0
        scale = _limb_scale(name, body.joints, joint_moves)
        vertices[name], joints[name] = half * scale, joint_moves * scale
    return ShapeTargets(
        names=tuple(vertices),
        vertices=np.stack(list(vertices.values())),
        joints=np.stack(list(joints.values())),
        faces_digest=hashlib.sha256(body.faces.tobytes()).hexdigest(),
    )


def save_targets(targets: ShapeTargets, path: Path) -> None:
    """Write what `ShapeTargets.load` reads, whole or not at all."""
    moves = {"vertices": targets.vertices.astype(np.float32), "joints": targets.joints.astype(np.float32)}
    digest = np.array(targets.faces_digest)
    write_npz(path, {"names": np.array(targets.names), **moves, "faces_digest": digest}, compress=True)


def _limb_scale(name: str, joints: np.ndarray, moves: np.ndarray) -> float:
    """Factor that makes a limb's target change its length by `LIMB_STEP`; 1 for other targets."""
    limb = name.split()[-1]
    if limb not in LIMBS:
        return 1.0
    start, end = (JOINT_INDEX[joint] for joint in LIMBS[limb][0])
    along = joints[end] - joints[start]
    gain = along @ (moves[end] - moves[start]) / (along @ along)
    return float(LIMB_STEP / abs(gain))
