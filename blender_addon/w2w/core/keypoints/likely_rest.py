# SPDX-License-Identifier: GPL-3.0-or-later
"""The likely rest pose of a skeleton whose file has none: by its own motion, and that of a known rig."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import JOINT_INDEX, JOINT_NAMES, Body, template
from ..motion.skinning import joint_transforms
from ..motion.source import SourceMotion, unscaled_rotations
from ..retargeting.bone_maps import BoneMap, plain_name
from ..retargeting.repair import flat_footed
from ..retargeting.retarget import matched_joints
from .fit import fit_keypoints
from .joint_sets import JOINT_SETS, JointSet

LIMBS = ("hip", "knee", "shoulder", "elbow")

RESTS: dict[str, dict[str, list[float]]] = template("rest_poses.json")
"""T-poses of rigs whose files may lack it: bone -> turn against a rest pose in which all bones lie along x,
as a rotation vector in degrees, z up and facing -y."""

NEAR = 30.0
"""Degrees by which limbs of a known rest pose may differ from those by the motion, which finds them to 25."""


def likely_rest(clips: Sequence[SourceMotion], body: Body, maps: Sequence[BoneMap] = ()) -> np.ndarray | None:
    """Rest matrices (B, 4, 4) of a skeleton in the body's T-pose, by clips of it; None if they show none.

    The joints' positions show how the body's are turned in each frame: by their directions, and the twist of
    limbs by the planes that they bend in. A bone's turn against its joint is the same in all frames, that of
    the rest pose: its mean is taken. The T-pose of a known rig is taken if its limbs are near that. Raises
    UnusableMotion if the skeleton cannot be matched.
    """
    rig, matched = matched_joints(clips[0], maps)
    joints = _joint_set(matched)
    bones = [matched[JOINT_INDEX[name]] for name in joints.joints]
    against, scales = [], []
    for clip in clips:
        with suppress(ValueError):
            fitted = fit_keypoints(clip.matrices[:, bones][..., :3, 3], clip.rate, joints, body)
            if not fitted.exchanged:
                turns = joint_transforms(body, fitted.floating)[0][:, list(matched)].swapaxes(-1, -2)
                against.append(turns @ unscaled_rotations(clip.matrices[:, list(matched.values())]))
                scales.append(fitted.scale)
    if not against:
        return None
    rest, turned = clips[0].rest.copy(), np.concatenate(against)
    for number, (joint, bone) in enumerate(matched.items()):
        rest[bone, :3, :3] = _mean(turned[:, number])
        rest[bone, :3, 3] = body.joints[joint] / np.mean(scales)
    rest = _of_rig(clips[0], rig, rest, matched)
    feet = np.array([flat_footed(replace(clip, rest=rest), matched) for clip in clips])
    for side in ("left", "right"):
        ankle, toe = (matched.get(JOINT_INDEX[f"{side}_{part}"]) for part in ("ankle", "foot"))
        if ankle is not None and toe is not None:
            rest[[ankle, toe]] = feet[_middle(feet[:, ankle, :3, :3])][[ankle, toe]]
    return rest


def _of_rig(source: SourceMotion, rig: str, likely: np.ndarray, matched: dict[int, int]) -> np.ndarray:
    """The rest pose of a known rig if its limbs are near the likely ones, else the likely one."""
    turns, rest = RESTS.get(rig, {}), likely.copy()
    for bone, name in enumerate(map(plain_name, source.bones)):
        if name in turns:
            rest[bone, :3, :3] = Rotation.from_rotvec(turns[name], degrees=True).as_matrix()
        if (parent := int(source.parents[bone])) >= 0:
            rest[bone][:3, 3] = (rest[parent] @ np.linalg.solve(source.rest[parent], source.rest[bone]))[
                :3, 3
            ]
    limbs = [matched[joint] for joint, name in enumerate(JOINT_NAMES) if name.endswith(LIMBS)]
    against = likely[limbs][:, :3, :3].swapaxes(1, 2) @ rest[limbs][:, :3, :3]
    is_near = bool((Rotation.from_matrix(against).magnitude() < np.radians(NEAR)).all())
    return rest if turns and is_near else likely


def _joint_set(matched: dict[int, int]) -> JointSet:
    """SMPL's joints, those that have a bone."""
    whole = JOINT_SETS["smpl-24"]
    joints = tuple(name for name in whole.joints if JOINT_INDEX[name] in matched)
    landmarks = {mark: of for mark, of in whole.landmarks.items() if set(of) <= set(joints)}
    return JointSet(whole.name, joints, landmarks)


def _middle(turns: np.ndarray) -> int:
    """The number of the rotation (N, 3, 3) that is nearest to the others: some feet never stood flat."""
    return int(np.median(np.einsum("iab,jab->ij", turns, turns), axis=1).argmax())


def _mean(turns: np.ndarray) -> np.ndarray:
    """The rotation (3, 3) nearest to all of some (T, 3, 3)."""
    left, _, right = np.linalg.svd(turns.mean(axis=0))
    return left @ np.diag([1.0, 1.0, np.linalg.det(left @ right)]) @ right
