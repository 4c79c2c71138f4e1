# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions of NVIDIA's poselib (ASE, PHC, ProtoMotions): an npy with a named skeleton and its rotations."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from ..motion.source import (
    SourceMotion,
    UnusableMotion,
    reading,
    refuse_few_frames,
    refuse_pose,
    refuse_too_long,
    size_and_head,
    usable_rate,
)
from ..pickles import read_npy_object
from ..wording import clean, restated


def read_poselib(path: Path, rate: float | None = None) -> SourceMotion | None:
    """Read a SkeletonMotion that poselib saved; None if the file holds something else.

    `rate` goes before the file's own. Raises UnusableMotion if it is damaged.
    """
    size_and_head(path)
    with reading(ValueError, MemoryError):
        content = read_npy_object(path)
    if not (isinstance(content, dict) and "skeleton_tree" in content):
        return None
    damaged = "it is damaged: its skeleton or rotations cannot be used:"
    with restated(damaged, (KeyError, TypeError, ValueError, IndexError, AttributeError), UnusableMotion):
        tree, is_local = content["skeleton_tree"], bool(content["is_local"])
        names = tuple(clean(str(name)) for name in tree["node_names"])
        parents = _array(tree["parent_indices"]).astype(int)
        offsets, quaternions = _array(tree["local_translation"]), _array(content["rotation"])
        root = _array(content["root_translation"])
        claimed = float(np.ravel(content["fps"])[0])
        local = Rotation.from_quat(quaternions.reshape(-1, 4)).as_matrix()
        local = local.reshape(len(root), len(names), 3, 3)
        fits = (
            offsets.shape == (len(names), 3) and root.shape == (len(local), 3) and len(parents) == len(names)
        )
        if not fits or (parents >= np.arange(len(parents))).any():
            raise ValueError("its arrays do not fit each other")
    rate = usable_rate(claimed, rate)
    refuse_few_frames(len(root))
    refuse_too_long(len(root), len(names))
    matrices = np.tile(np.eye(4), (len(root), len(names), 1, 1))
    rest = np.tile(np.eye(4), (len(names), 1, 1))
    for bone, parent in enumerate(parents):
        matrices[:, bone, :3, :3] = local[:, bone]
        matrices[:, bone, :3, 3] = root
        if parent >= 0:
            turned = matrices[:, parent, :3, :3]
            matrices[:, bone, :3, 3] = matrices[:, parent, :3, 3] + turned @ offsets[bone]
            if is_local:
                matrices[:, bone, :3, :3] = turned @ local[:, bone]
            rest[bone, :3, 3] = rest[parent, :3, 3] + offsets[bone]
    motion = SourceMotion(names, parents, rest, matrices, rate, clean(path.stem))
    refuse_pose(motion)
    return motion


def _array(value: Any) -> np.ndarray:
    """An array, which poselib keeps with its type."""
    return np.asarray(value["arr"] if isinstance(value, dict) else value, dtype=np.float64)
