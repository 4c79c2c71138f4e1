# SPDX-License-Identifier: GPL-3.0-or-later
"""What an armature of the scene plays becomes clips of the body, and the scene stays as it is."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of
from w2w.scene.motion.takes import import_file
from w2w.ui.jobs import jobs

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

CLIPS = "mixamo/M3-org__CharacterStudio"


@pytest.fixture
def scene_armature(shared_data: Path) -> bpy.types.Object:
    """A body, and a real Mixamo armature with two named actions, one that says nothing, and a strip."""
    bpy.context.scene.render.fps = 30
    bpy.ops.w2w.add_body()
    armatures = []
    for file, name in (("AirSquat", "Air Squat"), ("Walking", "Walking.001"), ("Waving", "mixamo.com")):
        before = set(bpy.data.objects)
        import_file(shared_data / CLIPS / f"{file}.fbx")
        (armature,) = set(bpy.data.objects) - before
        armature.animation_data.action.name = name
        armature.animation_data.action.use_fake_user = True
        armatures.append(armature)
    for other in armatures[1:]:
        bpy.data.objects.remove(other)
    track = armatures[0].animation_data.nla_tracks.new()
    strip = track.strips.new("Second step", 300, bpy.data.actions["Walking.001"])
    strip.name = "Second step"  # Blender 4.2 calls new strips by their action
    strip.action_frame_start += 5
    track.mute = True
    return armatures[0]


def listed() -> dict[str, str]:
    return {clip.name: clip.activity for clip in bpy.context.scene.w2w.body.w2w.clips}


def test_actions_and_strips_become_clips_with_their_names_and_labels(
    scene_armature: bpy.types.Object, shared_data: Path
) -> None:
    before = set(bpy.data.objects), scene_armature.animation_data.action
    assert bpy.ops.w2w.use_scene_animation(armature=scene_armature.name) == {"FINISHED"}
    assert listed() == {"Air Squat": "air_squat", "Second step": "second_step", "mixamo.com": ""}
    assert (set(bpy.data.objects), scene_armature.animation_data.action) == before
    assert "1 without an activity" in jobs.message.text
    body = bpy.context.scene.w2w.body
    taken = read_action(armature_of(body), body.w2w.clips["Air Squat"].action)
    bpy.ops.w2w.import_motions(directory=str(shared_data / CLIPS), files=[{"name": "AirSquat.fbx"}])
    of_file = read_action(armature_of(body), body.w2w.clips[-1].action)
    np.testing.assert_allclose(taken.rotations, of_file.rotations, atol=1e-3)
    np.testing.assert_allclose(taken.pelvis, of_file.pelvis, atol=1e-3)


@pytest.mark.slow
def test_what_is_in_the_list_already_is_not_taken_twice_unless_asked_for(
    scene_armature: bpy.types.Object,
) -> None:
    bpy.ops.w2w.use_scene_animation(armature=scene_armature.name)
    with pytest.raises(RuntimeError, match="in the list already"):
        bpy.ops.w2w.use_scene_animation(armature=scene_armature.name)
    assert len(listed()) == 3
    bpy.ops.w2w.use_scene_animation(armature=scene_armature.name, again=True)
    assert len(listed()) == 6
    assert "'Air Squat' and 2 more was in the list already" in jobs.message.text


def test_one_label_for_all(scene_armature: bpy.types.Object) -> None:
    bpy.ops.w2w.use_scene_animation(armature="*", labelled_by="ONE", activity=" dance ")
    assert set(listed().values()) == {"dance"}
    assert scene_armature.name in bpy.data.objects


def test_what_another_armature_plays_is_listed_with_the_reason(
    scene_armature: bpy.types.Object, shared_data: Path
) -> None:
    import_file(shared_data / CLIPS / "Clapping.fbx")
    bpy.ops.w2w.use_scene_animation(armature=scene_armature.name)
    problems = [clip.problem for clip in bpy.context.scene.w2w.body.w2w.clips if clip.problem]
    assert len(problems) == 1
    assert "choose that armature" in problems[0]
    assert "1 left out" in jobs.message.text


def test_without_an_armature_of_ones_own_it_waits() -> None:
    bpy.ops.w2w.add_body()
    assert not bpy.ops.w2w.use_scene_animation.poll()
