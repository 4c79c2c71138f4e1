# SPDX-License-Identifier: GPL-3.0-or-later
"""Characters on the rigs of other tools carry our map: each vertex finds itself on our body."""

from __future__ import annotations

import bpy
import numpy as np
import pytest

from w2w.core.body.body import JOINT_NAMES, Body
from w2w.core.motion.source import UnusableMotion
from w2w.core.retargeting.bone_maps import best_match, missing_joints
from w2w.scene.body.character import character_meshes, read_character, tie

from ..rings import by_day
from .other_rigs import RIGS, add_rigged, distance_from_itself

pytestmark = pytest.mark.usefixtures("empty_file")

NEAR = 0.03
"""Median distance of a vertex from itself on our body, metres: the surface is laid on it by joints alone."""


@pytest.mark.parametrize("rig", by_day([*RIGS][::2], RIGS))
def test_a_skin_of_ours_finds_itself(rig: str, bundled_body: Body) -> None:
    armature, mesh = add_rigged(bundled_body, RIGS[rig])
    bones = [bone.name for bone in armature.data.bones]
    bone_map, matched = best_match(bones)
    assert not missing_joints(matched), bone_map.name
    assert bone_map.name.split()[0] in rig.replace("VRoid", "VRM")
    of = {bone.name: bone for bone in RIGS[rig]}
    for joint, bone in matched.items():
        assert of[bones[bone]].joint.strip("123") == JOINT_NAMES[joint].strip("123")
        assert of[bones[bone]].shares
    assert character_meshes(armature, bpy.context.scene) == [mesh]
    figure = read_character(armature, [mesh])
    assert tie(figure, [mesh], bundled_body) < 1e-3
    assert np.median(distance_from_itself(bundled_body, mesh)) < NEAR


def test_a_rig_that_is_not_understood_is_told_which_bones_are_missing(bundled_body: Body) -> None:
    bones = [bone for bone in RIGS["Unreal 4"] if bone.joint not in ("left_knee", "left_ankle", "left_foot")]
    armature, mesh = add_rigged(bundled_body, bones)
    with pytest.raises(UnusableMotion, match=r"left[ _]knee.*left[ _]ankle"):
        read_character(armature, [mesh])
