# SPDX-License-Identifier: GPL-3.0-or-later
"""Another frame rate of the scene changes neither signals nor how fast a clip plays."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.scene.base.actions import bone_curves, key_rate, scene_rate
from w2w.scene.base.body import armature_of
from w2w.scene.motion.source_beside import source_collections
from w2w.ui.steps.baking import to_bake
from w2w.ui.study import signal_cache

from ..rings import by_day
from .made_study import take_through

pytestmark = pytest.mark.usefixtures("blender")

WALK, RUN = (f"bvh/bandai_namco/dataset-1_{activity}_active_001.bvh" for activity in ("walk", "run"))
CHARACTER = "mixamo/Conqster__TheBarMan/Walking.fbx"


@pytest.fixture
def take(shared_data: Path) -> Callable[[str], bpy.types.PropertyGroup]:
    """What imports a real clip into the list of the body."""
    take_through(shared_data, "patches")

    def import_clip(file: str) -> bpy.types.PropertyGroup:
        path = shared_data / file
        bpy.ops.w2w.import_motions(directory=str(path.parent), files=[{"name": path.name}])
        return bpy.context.scene.w2w.body.w2w.clips[-1]

    return import_clip


def bake_all() -> list[str]:
    """Keys of the signals of all clips, baked anew: equal content, equal key."""
    study = bpy.context.scene.w2w.body.w2w
    for clip in study.clips:
        clip.signals, clip.selected = "", True
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    return [clip.signals for clip in study.clips]


def baked_again() -> ImuRecording:
    """Signals of the only clip, baked anew."""
    bake_all()
    return signal_cache.recording(bpy.context.scene.w2w.body.w2w.clips[0])


def wrist(seconds: float) -> np.ndarray:
    """Where the body's wrist is, so long after the clip began."""
    scene, armature = bpy.context.scene, armature_of(bpy.context.scene.w2w.body)
    frame = 1 + seconds * scene_rate()
    scene.frame_set(int(frame), subframe=frame % 1)
    return np.array(
        armature.evaluated_get(bpy.context.evaluated_depsgraph_get()).pose.bones["left_wrist"].head
    )


def test_signals_are_the_same_to_the_byte_at_another_rate(take) -> None:
    take(WALK), take(CHARACTER)
    first = bake_all()
    bpy.context.scene.render.fps = 60
    assert not to_bake(bpy.context.scene.w2w.body.w2w)
    assert bake_all() == first
    bpy.ops.w2w.preview_clip(index=0)
    assert bake_all() == first


@pytest.mark.slow
def test_a_character_brought_between_two_imports_changes_neither(take, shared_data: Path) -> None:
    bpy.context.scene.render.fps = 60
    take(WALK), take(RUN)
    alone = bake_all()
    bpy.ops.w2w.tick_clips(which="ALL")
    bpy.ops.w2w.remove_clips()
    bpy.context.scene.render.fps = 24
    take(WALK)
    if "fbx_import" in dir(bpy.ops.wm):  # 4.5 and later
        bpy.ops.wm.fbx_import(filepath=str(shared_data / CHARACTER))
        assert scene_rate() != 24  # else the test is blind
    bpy.context.scene.render.fps = 60
    take(RUN)
    assert [key_rate(clip.action) for clip in bpy.context.scene.w2w.body.w2w.clips] == [24, 60]
    assert bake_all() == alone


@pytest.mark.slow
def test_signals_evaluated_by_blender_are_the_same_too(take) -> None:
    clip = take(RUN)
    bpy.context.scene.w2w.body.modifiers.new("Smooth", "SMOOTH")
    first = baked_again()
    assert clip.bake_path.startswith("general")
    bpy.context.scene.render.fps = 60
    second = baked_again()
    assert scene_rate() == 60
    np.testing.assert_array_equal(second.acc, first.acc)
    np.testing.assert_array_equal(second.gyr, first.gyr)


@pytest.mark.slow
def test_a_clip_edited_by_hand_keeps_its_signals(take) -> None:
    clip = take(WALK)
    armature = armature_of(bpy.context.scene.w2w.body)
    for curve in bone_curves(armature, clip.action)["left_elbow"].values():
        curve.keyframe_points.insert(20.7, curve.evaluate(20.7))
    first = baked_again()
    bpy.context.scene.render.fps = 60
    bpy.ops.w2w.preview_clip(index=0)
    second = baked_again()
    assert first.rate == second.rate
    assert np.abs(second.acc - first.acc).max() < 0.02


@pytest.mark.parametrize("rate", by_day([60], [12, 60]))
def test_a_preview_plays_in_real_time_and_so_does_what_stands_beside(take, rate: int) -> None:
    take(WALK)
    bpy.ops.w2w.show_source()
    (beside,) = source_collections()
    strips = [
        strip
        for item in beside.objects
        if item.animation_data
        for track in item.animation_data.nla_tracks
        for strip in track.strips
    ]
    before = [wrist(seconds) for seconds in (0.5, 1, 2)], [strip.scale for strip in strips]
    assert before[1]
    bpy.context.scene.render.fps = rate
    bpy.ops.w2w.preview_clip(index=0)
    np.testing.assert_allclose([wrist(seconds) for seconds in (0.5, 1, 2)], before[0], atol=1e-5)
    np.testing.assert_allclose(
        [strip.scale for strip in strips], np.multiply(before[1], rate / 24), rtol=1e-5
    )
    assert bpy.context.scene.frame_preview_end == round(1 + 145 / 30 * rate)


@pytest.mark.slow
def test_keys_moved_apart_still_slow_a_clip_down(take) -> None:
    """That is the user's own wish, not a rate of the scene."""
    clip = take(WALK)
    first = baked_again()
    for curve in bone_curves(armature_of(bpy.context.scene.w2w.body), clip.action).values():
        for channel in curve.values():
            for point in channel.keyframe_points:
                point.co[0] = 1 + 2 * (point.co[0] - 1)
    second = baked_again()
    assert second.acc.shape[0] == pytest.approx(2 * first.acc.shape[0], abs=2)


@pytest.mark.slow
def test_a_long_clip_is_read_at_its_own_frames(take) -> None:
    """Late keys are rounded to whole parts of a frame; they lie no less evenly for that."""
    clip = take(WALK)
    first = baked_again()
    for curve in bone_curves(armature_of(bpy.context.scene.w2w.body), clip.action).values():
        for channel in curve.values():
            for point in channel.keyframe_points:
                point.co[0] += 2.0**17 + 1 / 3
    second = baked_again()
    np.testing.assert_array_equal(second.acc, first.acc)
