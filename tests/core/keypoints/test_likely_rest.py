# SPDX-License-Identifier: GPL-3.0-or-later
"""A rest pose that a file lacks: by the motion alone limbs are turned nearly as by the true one."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_NAMES, PARENTS
from w2w.core.keypoints.likely_rest import RESTS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import SourceMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.reading.clips import ITS_OWN, with_likely_rest
from w2w.core.retargeting.bone_maps import bundled_bone_maps, plain_name
from w2w.core.retargeting.retarget import retarget

from ...exercises import exercises

LIMBS = [f"{side}_{part}" for side in ("left", "right") for part in ("hip", "knee", "shoulder", "elbow")]


def apart(body, first, second):
    """Degrees between the world rotations of two motions, median over the frames, by joint."""
    a, b = (joint_transforms(body, motion)[0] for motion in (first, second))
    relative = (a.swapaxes(-1, -2) @ b).reshape(-1, 3, 3)
    angles = np.degrees(Rotation.from_matrix(relative).magnitude()).reshape(len(a), -1)
    return dict(zip(JOINT_NAMES, np.median(angles, axis=0), strict=True))


def rigged(body, motion: Motion, seed: int = 0) -> SourceMotion:
    """The motion on a skeleton of SMPL's names whose bones are turned by chance, its rest pose a frame."""
    turns, places = joint_transforms(body, motion)
    rolls = Rotation.random(len(JOINT_NAMES), random_state=seed).as_matrix()
    matrices = np.zeros((*places.shape[:2], 4, 4))
    matrices[..., :3, :3], matrices[..., :3, 3], matrices[..., 3, 3] = turns @ rolls, 100 * places, 1
    return SourceMotion(JOINT_NAMES, np.array(PARENTS), matrices[0], matrices, motion.rate)


@pytest.mark.parametrize("file", list(exercises(1)))
def test_limbs_are_turned_as_by_the_true_rest_pose(bundled_body, file):
    motion = exercises(1)[file]
    source = replace(rigged(bundled_body, motion), rest_is_known=False)
    found = apart(
        bundled_body, motion, retarget(with_likely_rest(source, bundled_body)[0], bundled_body).motion
    )
    most = {"pelvis": 3, "hip": 4, "knee": 4, "shoulder": 12, "elbow": 25}
    assert all(found[joint] < most[joint.rpartition("_")[2]] for joint in ("pelvis", *LIMBS)), found


def test_a_rest_pose_that_is_known_stays(bundled_body):
    source = rigged(bundled_body, next(iter(exercises(1).values())))
    assert with_likely_rest(source, bundled_body)[0] is source


def test_soma_with_a_flat_rest_pose_moves_as_with_the_true_one(shared_cases, bundled_body):
    flat, truth = (read_bvh(shared_cases / f"soma_flat_rest{name}.bvh") for name in ("", "_truth"))
    assert (flat.rest_is_known, truth.rest_is_known) == (False, True)
    expected = retarget(truth, bundled_body).motion
    before = apart(bundled_body, expected, retarget(flat, bundled_body).motion)
    found = apart(
        bundled_body, expected, retarget(with_likely_rest(flat, bundled_body)[0], bundled_body).motion
    )
    assert before["left_shoulder"] > 33
    assert max(found.values()) < 1


SOMA = {
    joint: names[0] for bone_map in bundled_bone_maps() if bone_map.name == "SOMA"
    for joint, names in bone_map.joints.items()
}  # fmt: skip


@pytest.mark.parametrize("is_soma_s", [True, False])
def test_the_t_pose_of_a_rig_is_taken_only_where_the_motion_speaks_for_it(bundled_body, is_soma_s):
    """Bones of SOMA's names, turned as in its flat rest pose, or by chance."""
    motion = exercises(1)[next(iter(exercises(1)))]
    source = replace(rigged(bundled_body, motion), bones=tuple(SOMA[name] for name in JOINT_NAMES))
    turns, _ = joint_transforms(bundled_body, motion)
    own = [
        Rotation.from_rotvec(RESTS["SOMA"].get(plain_name(bone), [0, 0, 0]), degrees=True)
        for bone in source.bones
    ]
    if is_soma_s:
        source.matrices[..., :3, :3] = turns @ np.array([turn.as_matrix() for turn in own])
    source = replace(source, rest=source.matrices[0], rest_is_known=False)
    found, origin = with_likely_rest(source, bundled_body)
    assert origin == ITS_OWN
    against = found.rest[:22, :3, :3].swapaxes(1, 2) @ [turn.as_matrix() for turn in own[:22]]
    angles = np.degrees(Rotation.from_matrix(against).magnitude())
    body = [number for number, name in enumerate(JOINT_NAMES[:22]) if name.endswith(("collar", "wrist"))]
    assert (angles[body] < 1).all() if is_soma_s else (angles[body] > 15).all()
