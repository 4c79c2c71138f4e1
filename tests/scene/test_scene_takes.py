# SPDX-License-Identifier: GPL-3.0-or-later
"""The actions and NLA strips of real armatures in the scene are found, and read as their files are."""

import bpy
import numpy as np
import pytest

from w2w.core.motion.source import UnusableMotion, unscaled_rotations
from w2w.scene.base.actions import show_action
from w2w.scene.base.steps import without_pauses
from w2w.scene.motion.scene_takes import _posed_by_more, read_scene_take, scene_takes
from w2w.scene.motion.takes import import_file, read_clip

pytestmark = pytest.mark.usefixtures("empty_file")

CLIPS = "mixamo/M3-org__CharacterStudio"


def imported(path, name):
    """An armature that Blender's own importer brought, its action under another name."""
    before = set(bpy.data.objects)
    import_file(path)
    (armature,) = (item for item in set(bpy.data.objects) - before if item.type == "ARMATURE")
    armature.animation_data.action.name = name
    return armature


def read(take):
    """Run a reading through."""
    return without_pauses(read_scene_take(take))


@pytest.fixture
def two_actions(shared_data):
    """A Mixamo armature that squats, and an action for walking that came with another and stayed."""
    armature = imported(shared_data / CLIPS / "AirSquat.fbx", "Air Squat")
    other = imported(shared_data / CLIPS / "Walking.fbx", "Walking")
    other.animation_data.action.use_fake_user = True
    bpy.data.objects.remove(other)
    return armature


def state_of(armature):
    """All that reading must leave as it was."""
    scene, data = bpy.context.scene, armature.animation_data
    return (
        (scene.frame_current, scene.frame_start, scene.frame_end, scene.render.fps),
        (data.action, data.use_nla, len(data.nla_tracks), armature.hide_get()),
        [tuple(row) for bone in armature.pose.bones for row in bone.matrix_basis],
        sorted(bpy.data.objects.keys()),
    )


def test_all_actions_for_its_bones_are_found_and_read_as_from_their_files(two_actions, shared_data):
    bpy.context.scene.frame_set(7)
    before = state_of(two_actions)
    takes, left_out = scene_takes(two_actions)
    assert [take.name for take in takes] == ["Air Squat", "Walking"]
    assert left_out == []
    for take, file in zip(takes, ("AirSquat.fbx", "Walking.fbx"), strict=True):
        motion, own = read(take), read_clip(shared_data / CLIPS / file)
        assert motion.bones[1:] == own.bones[1:]
        assert motion.rate == pytest.approx(bpy.context.scene.render.fps)
        turned, own_turned = unscaled_rotations(motion.matrices), unscaled_rotations(own.matrices)
        np.testing.assert_allclose(turned[:, 1:], own_turned[:, 1:], atol=1e-3)
    assert state_of(two_actions) == before


def test_a_strip_of_a_part_is_a_clip_of_its_own_and_the_action_is_not_another(two_actions):
    walking = bpy.data.actions["Walking"]
    track = two_actions.animation_data.nla_tracks.new()
    strip = track.strips.new("Right step", 40, walking)
    strip.name = "Right step"  # Blender 4.2 calls new strips by their action
    strip.action_frame_start, strip.action_frame_end = 5, 17
    strip.scale = 2.0
    track.mute = True
    copy = two_actions.animation_data.nla_tracks.new().strips.new("The same", 200, walking)
    copy.name = "The same"
    copy.action_frame_start, copy.action_frame_end, copy.scale = 5, 17, 2.0
    takes, left_out = scene_takes(two_actions)
    assert [take.name for take in takes] == ["Air Squat", "Right step"]
    np.testing.assert_allclose(takes[1].frames, np.arange(5, 17.1, 0.5))
    assert left_out == [("The same", "it plays the same as 'Right step'")]
    part, whole = read(takes[1]), read(scene_takes_of(two_actions, walking))
    np.testing.assert_allclose(part.matrices[::2], whole.matrices[5 - first_frame(walking) :][:13], atol=1e-5)


def scene_takes_of(armature, action):
    """The whole action: its strips are taken away first."""
    for track in list(armature.animation_data.nla_tracks):
        armature.animation_data.nla_tracks.remove(track)
    return next(take for take in scene_takes(armature)[0] if take.take.action == action)


def first_frame(action):
    return round(action.frame_range[0])


def test_repeats_and_reversal_of_a_strip_are_played(two_actions):
    walking = bpy.data.actions["Walking"]
    strip = two_actions.animation_data.nla_tracks.new().strips.new("To and fro", 1, walking)
    strip.action_frame_start, strip.action_frame_end, strip.repeat = 5, 9, 2
    (_, take), _ = scene_takes(two_actions)
    assert take.frames.tolist() == [5, 6, 7, 8, 5, 6, 7, 8, 9]
    strip.use_reverse = True
    (_, take), _ = scene_takes(two_actions)
    assert take.frames.tolist() == [9, 8, 7, 6, 9, 8, 7, 6, 5]


def test_what_another_armature_plays_is_that_one_s(shared_data):
    squatting = imported(shared_data / CLIPS / "AirSquat.fbx", "Air Squat")
    walking = imported(shared_data / CLIPS / "Walking.fbx", "Walking")
    takes, left_out = scene_takes(squatting)
    assert [take.name for take in takes] == ["Air Squat"]
    assert left_out[0].name == "Walking"
    assert f"'{walking.name}' plays it" in left_out[0].reason


def test_an_action_for_other_bones_is_none_of_its(two_actions, shared_data):
    imported(shared_data / "bvh/bandai_namco/dataset-1_walk_active_001.bvh", "Bandai")
    assert "Bandai" not in [name for group in scene_takes(two_actions) for name in map(name_of, group)]


def name_of(found):
    return found.name


def test_bones_without_a_curve_are_at_rest_whatever_pose_is_shown(two_actions):
    action = bpy.data.actions.new("Nod")
    two_actions.animation_data.action = action
    head = next(bone for bone in two_actions.pose.bones if bone.name.endswith("Head"))
    head.rotation_mode = "XYZ"
    for frame in range(1, 12):
        head.rotation_euler.x = 0.1 * frame
        head.keyframe_insert("rotation_euler", frame=frame)
    arm = next(bone for bone in two_actions.pose.bones if bone.name.endswith("LeftArm"))
    arm.rotation_quaternion = (0.5, 0.5, 0.5, 0.5)
    motion = read(next(take for take in scene_takes(two_actions)[0] if take.name == "Nod"))
    index = motion.bones.index(arm.name)
    np.testing.assert_allclose(motion.matrices[0, index], motion.rest[index], atol=1e-5)
    assert tuple(arm.rotation_quaternion) == (0.5, 0.5, 0.5, 0.5)


def test_a_rig_that_constraints_pose_is_played_and_left_as_it_was(two_actions):
    bones = two_actions.pose.bones
    follower = next(bone for bone in bones if bone.name.endswith("RightArm"))
    leader = next(bone for bone in bones if bone.name.endswith("LeftArm"))
    constraint = follower.constraints.new("COPY_ROTATION")
    constraint.target, constraint.subtarget = two_actions, leader.name
    constraint.target_space = constraint.owner_space = "LOCAL"
    assert _posed_by_more(two_actions)
    leader.location = (0.1, 0.2, 0.3)
    bpy.context.scene.frame_set(7)
    before = state_of(two_actions)
    take = next(take for take in scene_takes(two_actions)[0] if take.name == "Walking")
    motion = read(take)
    show_action(two_actions, take.take.action)
    bpy.context.scene.frame_set(int(take.frames[9]))
    played = np.array(two_actions.matrix_world @ follower.matrix)
    index = motion.bones.index(follower.name)
    turned = unscaled_rotations(np.array([motion.matrices[9, index], played]))
    np.testing.assert_allclose(turned[0], turned[1], atol=1e-4)
    show_action(two_actions, bpy.data.actions["Air Squat"])
    bpy.context.scene.frame_set(7)
    assert state_of(two_actions)[:2] == before[:2]


def test_a_reading_broken_off_puts_everything_back(two_actions):
    follower = two_actions.pose.bones[5]
    follower.constraints.new("LIMIT_ROTATION")
    bpy.context.scene.frame_set(7)
    before = state_of(two_actions)
    steps = read_scene_take(next(take for take in scene_takes(two_actions)[0] if take.name == "Walking"))
    for _ in range(3):
        next(steps)
    assert two_actions.animation_data.action.name == "Walking"
    steps.close()
    assert state_of(two_actions) == before


def test_a_pose_is_no_clip(two_actions):
    action = bpy.data.actions.new("Pose")
    two_actions.animation_data.action = action
    for bone in two_actions.pose.bones:
        bone.keyframe_insert("rotation_quaternion", frame=1)
    take = next(take for take in scene_takes(two_actions)[0] if take.name == "Pose")
    with pytest.raises(UnusableMotion, match="it holds a pose, not a motion: 1 frame in 'Pose'"):
        read(take)


def test_a_switch_that_an_action_animates_is_put_back(two_actions):
    bone = two_actions.pose.bones[5]
    bone.constraints.new("LIMIT_ROTATION")
    bone["ik"] = 0.25
    show_action(two_actions, bpy.data.actions["Walking"])
    for frame, value in ((1, 0.0), (20, 1.0)):
        bone["ik"] = value
        bone.keyframe_insert('["ik"]', frame=frame)
    show_action(two_actions, bpy.data.actions["Air Squat"])
    bone["ik"] = 0.25
    steps = read_scene_take(next(take for take in scene_takes(two_actions)[0] if take.name == "Walking"))
    for _ in range(9):
        next(steps)
    assert bone["ik"] > 0.3
    steps.close()
    assert bone["ik"] == 0.25
