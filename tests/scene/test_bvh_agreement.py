# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W reads a BVH as Blender's importer does, to within what Blender's single precision leaves."""

import bpy
import numpy as np
import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.bvh import as_it_stands, read_bvh
from w2w.core.readers.bvh_text import read_bvh_text
from w2w.core.reading.guard import quiet_output
from w2w.scene.motion.takes import find_takes, imported, read_clip, read_take

from ..made_bvh import MadeJoint, bvh_text, draw_joints, draw_values

FILES = [
    "bvh/bandai_namco/dataset-1_walk_active_001.bvh",
    "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh",
    "bvh/cmu_DragonForged/007_12.bvh",
    "bvh/cmu_JonathanAlderson/06_04.bvh",
    "bvh/pybvh/bvh_test3.bvh",
]

GIMBAL = 0.01
"""Blender keeps Euler angles in single precision: near their pole a turn is off by up to this (radians)."""


def through_blender(path):
    """What a file's first take is by Blender's importer, whether it moves or not."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with quiet_output(), imported(path) as objects:
        (armature,) = objects
        (take,) = find_takes(armature, bpy.data.actions)
        return read_take(take)


def assert_alike(ours, theirs, size):
    """The armature aside: bones, tree and rate, where each bone is and how it has turned since its rest."""
    assert ours.bones == theirs.bones[1:]
    np.testing.assert_array_equal(ours.parents, theirs.parents[1:] - 1)
    assert ours.rate == pytest.approx(theirs.rate, rel=1e-6)
    assert ours.n_frames == theirs.n_frames
    np.testing.assert_allclose(ours.rest[:, :3, 3], theirs.rest[1:, :3, 3], atol=1e-5 * size)
    turned, true = (
        motion.matrices[:, first:, :3, :3] @ motion.rest[first:, :3, :3].swapaxes(1, 2)
        for motion, first in ((ours, 0), (theirs, 1))
    )
    away = np.abs(turned - true).max(axis=(2, 3))
    apart = np.abs(ours.matrices[..., :3, 3] - theirs.matrices[:, 1:, :3, 3]).max(axis=2) / size
    assert max(away.max(), apart.max()) < GIMBAL
    assert max(np.median(away), np.median(apart)) < 2e-5
    assert np.mean(away < 5e-4) > 0.99


@pytest.mark.parametrize("file", FILES)
def test_real_files(shared_data, file):
    ours = as_it_stands(read_bvh_text(shared_data / file), "")
    assert_alike(ours, through_blender(shared_data / file), np.ptp(ours.rest[:, :3, 3], axis=0).max())


@pytest.mark.parametrize("seed", range(6))
def test_any_order_of_rotations_and_joints_that_travel(tmp_path, seed):
    rng = np.random.default_rng(seed)
    joints = draw_joints(rng, 10, whole=True)
    (tmp_path / "a.bvh").write_text(bvh_text(joints, draw_values(rng, joints, 12), 1 / 24))
    ours = as_it_stands(read_bvh_text(tmp_path / "a.bvh"), "")
    assert_alike(ours, through_blender(tmp_path / "a.bvh"), 50.0)


def test_what_blender_takes_for_damage_is_read_and_said_where_it_matters(tmp_path):
    """A knee of one axis: its motion can be used, its armature not be shown."""
    hips = ("Xposition", "Yposition", "Zposition", "Zrotation", "Xrotation", "Yrotation")
    joints = [MadeJoint(-1, (0, 0, 0), hips), MadeJoint(0, (0, -4, 0), ("Xrotation",))]
    (tmp_path / "a.bvh").write_text(bvh_text(joints, draw_values(np.random.default_rng(0), joints, 9)))
    assert read_bvh(tmp_path / "a.bvh").n_frames == 9
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with pytest.raises(UnusableMotion, match="its armature cannot be shown: Blender's own importer"):
        read_clip(tmp_path / "a.bvh")
    assert not bpy.data.objects
