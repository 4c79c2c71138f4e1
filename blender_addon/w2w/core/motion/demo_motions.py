# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that come with W2W: four rehabilitation exercises of twelve generated people."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import TEMPLATES
from ..body.skeleton import N_JOINTS
from .motion import Motion

FILE = TEMPLATES / "demo.npz"
CLIPS = 12
"""Clips of each activity: one of each person."""

STEP = 1e-7
"""Pelvis (m) and rotation vectors (rad) are stored in whole steps, each frame by its second difference."""


def demo_motions(clips: int = CLIPS) -> dict[str, Motion]:
    """The first clips of each activity, each under the name of the file it is for."""
    with np.load(FILE, allow_pickle=False) as stored:
        arrays = dict(stored)
    found: dict[str, Motion] = {}
    names = ("files", "activities", "subjects")
    ends = np.cumsum(arrays["frames"])
    for end, frames, *labels in zip(ends, arrays["frames"], *(arrays[name] for name in names), strict=True):
        file, activity, subject = map(str, labels)
        if sum(motion.activity == activity for motion in found.values()) == clips:
            continue
        differences = arrays["differences"][end - frames : end].astype(np.int64)
        values = STEP * np.cumsum(np.cumsum(differences, axis=0), axis=0)
        turns = Rotation.from_rotvec(values[:, 3:].reshape(-1, 3)).as_matrix()
        rotations = turns.reshape(-1, N_JOINTS, 3, 3)
        found[file] = Motion(rotations, values[:, :3], float(arrays["rate"]), activity, subject)
    return found
