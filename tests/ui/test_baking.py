# SPDX-License-Identifier: GPL-3.0-or-later
"""Signals baked by the panel are those of core, known by their settings, and whole or not there."""

from __future__ import annotations

import json
import threading
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import simulate
from w2w.scene import bake
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of, body_of
from w2w.scene.base.patches import patch_empties
from w2w.ui.jobs import jobs, preferences
from w2w.ui.steps import baking
from w2w.ui.steps.baking import bake_steps
from w2w.ui.study import signal_cache, state
from w2w.ui.study.state import (
    BAKED,
    STALE,
    bake_settings,
    config_of,
    patches_of,
    rank_settings,
    state_of,
    utility_of,
)

from ..drifting import WithDrift
from ..sensor_steps import assert_same_to_one_step
from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def test_baked_signals_are_those_of_core(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    clip = body.w2w.clips[4]
    motion = read_action(armature_of(body), clip.action)
    expected = simulate(body_of(body), patches_of(body), motion, config_of(body.w2w))
    assert_same_to_one_step(signal_cache.recording(clip), expected, config_of(body.w2w).sensor_model())


@pytest.mark.parametrize("pose", ["patch_matrices", "triangle_frames"])
def test_no_clip_is_posed_in_a_turn_of_the_window(
    library: Path, monkeypatch: pytest.MonkeyPatch, pose: str
) -> None:
    body, threads, work = make_study(library, "motions patches"), [], getattr(bake, pose)
    if pose == "triangle_frames":
        monkeypatch.setattr(bake, "why_not_fast", lambda *_: "asked for")

    def watched(*given: object) -> object:
        threads.append(threading.current_thread() is threading.main_thread())
        return work(*given)

    monkeypatch.setattr(bake, pose, watched)
    for _ in bake_steps(body, range(2)):
        pass
    assert threads == [False] * 2


def test_another_sensor_makes_signals_stale_and_the_old_one_brings_them_back(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    study = body.w2w
    study.sensor = "watch"
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {STALE}
    study.sensor = "bmi270"
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {BAKED}


def test_undo_of_a_bake_and_a_file_saved_before_it_find_their_signals(library: Path, tmp_path: Path) -> None:
    body, saved = make_study(library, "motions patches signals"), tmp_path / "before.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(saved), copy=True)
    body.w2w.sensor = "watch"
    bpy.ops.ed.undo_push(message="Sensor")
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Bake Signals")
    watch = [clip.signals for clip in body.w2w.clips]
    bpy.ops.ed.undo()
    clips = bpy.context.scene.w2w.body.w2w.clips
    assert all(signal_cache.has(clip) and clip.signals not in watch for clip in clips)
    bpy.ops.ed.redo()
    clips = bpy.context.scene.w2w.body.w2w.clips
    assert all(signal_cache.has(clip) and clip.signals in watch for clip in clips)
    bpy.ops.wm.open_mainfile(filepath=str(saved))
    clips = bpy.context.scene.w2w.body.w2w.clips
    assert all(signal_cache.has(clip) and clip.signals not in watch for clip in clips)


def test_a_new_parameter_makes_signals_stale_with_no_more_than_its_declaration(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = make_study(library, "motions patches signals")
    study, ranked = body.w2w, rank_settings(body.w2w)

    def states() -> set[str]:
        return {state_of(clip, bake_settings(study)) for clip in study.clips}

    study.parameters = json.dumps(StudyConfig().as_dict())
    assert states() == {BAKED}
    monkeypatch.setattr(state, "StudyConfig", WithDrift)
    study.parameters = json.dumps(WithDrift(drift=2.0).as_dict())
    assert states() == {STALE}
    assert rank_settings(study) != ranked
    drifting = bake_settings(study)
    study.parameters = json.dumps(WithDrift(drift=2.0, target=0.8, folds=3, title="other").as_dict())
    assert bake_settings(study) == drifting


@pytest.mark.slow
def test_a_fault_of_ours_at_one_clip_costs_that_clip_alone(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    describe = baking.describe

    def faulty(recording: ImuRecording, config: StudyConfig) -> tuple[np.ndarray, np.ndarray]:
        if recording.clip == "kicking_kicking_1":
            raise IndexError("out of bounds")
        return describe(recording, config)

    monkeypatch.setattr(baking, "describe", faulty)
    body = make_study(library, "motions patches")
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    failed = [clip.name for clip in body.w2w.clips if not clip.signals]
    assert failed == ["kicking_kicking_1"]
    assert jobs.message.text.endswith(
        "Not baked: kicking_kicking_1 (W2W failed on it, please report this: IndexError: out of bounds)"
    )


@pytest.mark.slow
def test_ranking_bakes_again_what_the_cache_has_lost(library: Path) -> None:
    body = make_study(library)
    expected = utility_of(body.w2w).f1.copy()
    foreign = preferences.cache_folder() / "signals" / "a run's own.npz"
    foreign.write_bytes(b"")
    bpy.ops.w2w.clear_cache()
    assert [path for path in preferences.cache_folder().rglob("*") if path.is_file()] == [foreign]
    signal_cache._recordings.clear()
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    np.testing.assert_array_equal(utility_of(body.w2w).f1, expected)


def test_a_cancelled_bake_leaves_the_clips_as_they_were(library: Path) -> None:
    body = make_study(library, "motions patches")
    steps = bake_steps(body, range(len(body.w2w.clips)))
    while not body.w2w.clips[2].signals:
        next(steps)
    steps.close()
    assert not any(clip.signals or clip.baked_as for clip in body.w2w.clips)


def test_an_evaluated_bake_is_cancelled_between_frames(library: Path) -> None:
    body = make_study(library, "motions patches")
    body.modifiers.new("Smooth", "SMOOTH")
    bpy.context.scene.frame_set(5)
    steps = bake_steps(body, [0, 1])
    told = [next(steps) for _ in range(40)]
    assert sum("evaluated by Blender" in step.text for step in told) > 30
    assert [step.fraction for step in told] == sorted(step.fraction for step in told)
    steps.close()
    assert not any(clip.signals for clip in body.w2w.clips)
    assert bpy.context.scene.frame_current == 5
    assert patch_empties(body.w2w.patch_collection)[0].name in bpy.context.view_layer.objects
