# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions of poselib: the skeleton and rotations of its npy files, local or global, and damaged ones."""

from collections import OrderedDict

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_NAMES, PARENTS
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import SourceMotion, UnusableMotion
from w2w.core.readers.poselib import read_poselib
from w2w.core.reading.formats import read_motion
from w2w.core.retargeting.retarget import retarget

NAMES = [
    "Pelvis", "L_Hip", "R_Hip", "Torso", "L_Knee", "R_Knee", "Spine", "L_Ankle", "R_Ankle", "Chest", "L_Toe",
    "R_Toe", "Neck", "L_Thorax", "R_Thorax", "Head", "L_Shoulder", "R_Shoulder", "L_Elbow", "R_Elbow",
    "L_Wrist", "R_Wrist", "L_Hand", "R_Hand",
]  # fmt: skip
"""Names of PHC's SMPL humanoid, in SMPL's order."""


def tensor(values):
    return {"arr": np.asarray(values, dtype=np.float32), "context": {"dtype": "float32"}}


@pytest.fixture(scope="module")
def walk():
    return next(iter(demo_motions(1).values()))


def skeleton_motion(body, motion, is_local):
    """What poselib's `SkeletonMotion.to_file` pickles, z up in metres."""
    turns, _ = joint_transforms(body, motion)
    rotations = motion.rotations if is_local else turns
    quaternions = Rotation.from_matrix(rotations.reshape(-1, 3, 3)).as_quat().reshape(*rotations.shape[:2], 4)
    offsets = [body.joints[k] - (body.joints[p] if p >= 0 else 0) for k, p in enumerate(PARENTS)]
    tree = OrderedDict(node_names=NAMES, parent_indices=tensor(PARENTS), local_translation=tensor(offsets))
    return OrderedDict(
        rotation=tensor(quaternions),
        root_translation=tensor(motion.pelvis),
        global_velocity=tensor(np.zeros((len(turns), 24, 3))),
        global_angular_velocity=tensor(np.zeros((len(turns), 24, 3))),
        skeleton_tree=tree,
        is_local=is_local,
        fps=np.array(motion.rate),
        __name__="SkeletonMotion",
    )


@pytest.mark.parametrize("is_local", [True, False])
def test_joints_are_where_the_body_s_are(tmp_path, bundled_body, walk, is_local):
    np.save(tmp_path / "a.npy", np.array(skeleton_motion(bundled_body, walk, is_local)))
    source = read_motion(tmp_path / "a.npy")
    assert isinstance(source, SourceMotion)
    _, truth = joint_transforms(bundled_body, walk)
    assert np.abs(source.matrices[..., :3, 3] - truth).max() < 0.005
    assert (source.rate, source.up) == (walk.rate, "z")
    assert read_motion(tmp_path / "a.npy").rate == walk.rate
    found = retarget(source, bundled_body)
    assert [found.bones[name] for name in JOINT_NAMES[:22]] == NAMES[:22]
    _, ours = joint_transforms(bundled_body, found.motion)
    assert np.abs(ours - truth).max() < 0.005


def test_other_npy_files_are_left_to_others(tmp_path):
    np.save(tmp_path / "a.npy", np.zeros((9, 24, 3)))
    assert read_poselib(tmp_path / "a.npy") is None
    np.save(tmp_path / "a.npy", np.array({"motion": np.zeros(3)}))
    assert read_poselib(tmp_path / "a.npy") is None


@pytest.mark.parametrize(
    ("key", "value", "reason"),
    [
        ("rotation", tensor(np.zeros((9, 24, 3))), "cannot be used"),
        ("rotation", tensor(np.zeros((0, 24, 4))), "cannot be used"),
        ("root_translation", tensor(np.zeros((3, 3))), "cannot be used"),
        ("skeleton_tree", {}, "'node_names'"),
        ("skeleton_tree", None, "cannot be used"),
        ("fps", np.array(0.0), "frames a second"),
    ],
)
def test_damaged_files_are_refused(tmp_path, bundled_body, walk, key, value, reason):
    np.save(tmp_path / "a.npy", np.array(skeleton_motion(bundled_body, walk, True) | {key: value}))
    with pytest.raises(UnusableMotion, match=reason):
        read_poselib(tmp_path / "a.npy")
