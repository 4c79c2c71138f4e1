# SPDX-License-Identifier: GPL-3.0-or-later
"""Orientation, magnetometer and barometer asked for in the panel are those of `w2w run --record`."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.imu.formats import read_recording
from w2w.core.imu.recording import FURTHER, ImuRecording
from w2w.core.imu.virtual import NOTHING, FurtherSensors
from w2w.core.study.clip_files import features_file
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import describe, simulate
from w2w.headless.study_options import StudyOptions
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of, body_of
from w2w.ui.jobs import jobs
from w2w.ui.results import restore
from w2w.ui.study import signal_cache
from w2w.ui.study.state import BAKED, STALE, bake_settings, config_of, patches_of, state_of

from ..sensor_steps import assert_same_to_one_step
from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender")


def test_they_are_baked_exported_and_recognised_by_as_on_the_command_line(
    library: Path, tmp_path: Path
) -> None:
    body = make_study(library, "motions patches")
    study = body.w2w
    study.record, study.recognise_by = set(FURTHER), {"barometer"}
    study.magnetic_dip = -64.3
    asked = StudyOptions(
        patches=N_PATCHES, record=",".join(FURTHER), recognise_by="barometer", magnetic_dip=-64.3
    )
    assert config_of(study).further == asked.config().further
    study.clip_index = 4
    assert bpy.ops.w2w.bake_signals(which="TICKED") == {"FINISHED"}
    clip = study.clips[4]
    motion = read_action(armature_of(body), clip.action).labelled(clip.activity, clip.subject, clip.name)
    expected = simulate(body_of(body), patches_of(body), motion, config_of(study))
    baked = signal_cache.recording(clip)
    assert_same_to_one_step(baked, expected, config_of(study).sensor_model())
    np.testing.assert_allclose(baked.magnetometer, expected.magnetometer, atol=1e-2)
    np.testing.assert_allclose(baked.barometer, expected.barometer, atol=0.1)
    np.testing.assert_allclose(baked.orientation, expected.orientation, atol=1e-4)
    features = np.load(features_file(*signal_cache.place_of(clip)))["features"]
    assert features.shape[2] == describe(expected, config_of(study))[0].shape[2]
    bpy.ops.w2w.select_patch(patch=3)
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "csv"), kind="csv") == {"FINISHED"}
    (saved,) = (tmp_path / "csv").iterdir()
    np.testing.assert_array_equal(read_recording(saved).barometer, baked.barometer[:, [3]])
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "xsens"), kind="xsens") == {"FINISHED"}
    assert jobs.message.text.endswith("without magnetometer and barometer, which xsens files do not hold")
    assert bpy.ops.w2w.export_signals(directory=str(tmp_path / "all"), which="ALL") == {"FINISHED"}
    (whole,) = (tmp_path / "all").iterdir()
    np.testing.assert_array_equal(ImuRecording.load(whole).magnetometer, baked.magnetometer)


def test_another_choice_makes_signals_stale(library: Path) -> None:
    study = make_study(library, "motions patches signals").w2w
    states = lambda: {state_of(clip, bake_settings(study)) for clip in study.clips}  # noqa: E731
    assert config_of(study).further == NOTHING
    study.recognise_by = {"barometer"}
    assert states() == {BAKED}  # nothing is recorded that could be recognised by
    assert config_of(study).further == NOTHING
    study.record = {"orientation"}
    assert states() == {STALE}
    assert config_of(study).further == FurtherSensors(("orientation",))
    study.record = set()
    assert states() == {BAKED}


def test_where_they_come_to_nothing_the_study_still_works(library: Path) -> None:
    study = make_study(library, "").w2w
    study.record, study.recognise_by = {"barometer"}, {"barometer"}
    study.classifier = "multi3net"
    assert config_of(study).further == FurtherSensors(("barometer",))
    study.classifier = "ridge"
    assert config_of(study).further == FurtherSensors(("barometer",), ("barometer",))
    study.parameters = json.dumps(StudyConfig(garments=("tshirt",)).as_dict())
    assert config_of(study).further == NOTHING


def test_a_run_that_recorded_them_is_opened_with_them(library: Path) -> None:
    study = make_study(library, "").w2w
    further = FurtherSensors(("barometer", "orientation"), ("barometer",), -12.3, 45.6, altitude_m=300.0)
    run = StudyConfig(further=further)
    study.parameters = json.dumps(run.as_dict())
    assert config_of(study).further == further  # as in a file saved before the panel showed them
    restore._set_parameters(study, run)
    assert (study.record, study.recognise_by) == ({"barometer", "orientation"}, {"barometer"})
    assert config_of(study).further == further
    study.record = {"barometer", "magnetometer"}
    assert config_of(study).further == replace(further, record=("magnetometer", "barometer"))


def test_a_tick_adds_a_sensor_and_lets_the_others_be(library: Path) -> None:
    study = make_study(library, "motions").w2w
    for index in range(len(FURTHER)):
        study.recorded[index] = True
    study.recorded[1] = False
    study.recognised_by = [False, True, True]
    assert list(study.recorded) == [True, False, True]
    assert study.record == {"orientation", "barometer"}
    assert config_of(study).further.features == ("barometer",)
