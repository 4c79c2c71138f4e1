# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that come with W2W: those of the demo, at every door."""

from functools import cache
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import N_JOINTS, TEMPLATES
from .motion import Motion

DEMO = TEMPLATES / "demo.npz"
DEMO_CLIPS = 8
"""Clips of each activity: one of each person."""

DEMO_STEP = 1e-7
"""Pelvis (m) and rotation vectors (rad) are stored in whole steps, each frame by its second difference."""


def demo_motions(clips: int = DEMO_CLIPS, stored_in: Path = DEMO) -> dict[str, Motion]:
    """The first clips of each activity, each under the name of the file it is for."""
    with np.load(stored_in, allow_pickle=False) as stored:
        arrays = dict(stored)
    labels = (arrays[name].tolist() for name in ("files", "activities", "subjects", "lifts"))
    parts = np.split(arrays["differences"].astype(np.int64), np.cumsum(arrays["frames"])[:-1])
    motions: dict[str, Motion] = {}
    for file, activity, subject, lift, differences in zip(*labels, parts, strict=True):
        if sum(motion.activity == activity for motion in motions.values()) < clips:
            values = DEMO_STEP * np.cumsum(np.cumsum(differences, axis=0), axis=0)
            turns = Rotation.from_rotvec(values[:, 3:].reshape(-1, 3)).as_matrix()
            rotations = turns.reshape(-1, N_JOINTS, 3, 3)
            pelvis, clip = values[:, :3] + [0, 0, lift], file.removesuffix(".npz")
            motions[file] = Motion(rotations, pelvis, float(arrays["rate"]), activity, subject, clip)
    return motions


def as_example(motion: Motion) -> Motion:
    """The example motion of its clip's name, if it differs by single precision alone, else the motion itself.

    Blender's curves are in single precision: so the panel's answer is, to the last bit, that of a run.
    """
    known = cached_examples().get(f"{motion.clip}.npz")
    if known is None or known.n_frames != motion.n_frames or known.rate != motion.rate:
        return motion
    far = max(np.abs(known.rotations - motion.rotations).max(), np.abs(known.pelvis - motion.pelvis).max())
    return motion if far > SINGLE else known.labelled(motion.activity, motion.subject, motion.clip)


cached_examples = cache(demo_motions)

SINGLE = 1e-5
"""Difference (m, and of matrix elements) that may come from single precision."""
