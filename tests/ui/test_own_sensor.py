# SPDX-License-Identifier: GPL-3.0-or-later
"""A part of one's own, and bands in the panel give the numbers that `w2w run` gives."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.imu.presets import preset, read_sensor
from w2w.core.imu.synthesis import Synthesis
from w2w.core.study.config import StudyConfig
from w2w.core.study.signals import simulate
from w2w.headless.study_options import StudyOptions
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of, body_of
from w2w.ui.results import restore
from w2w.ui.study import signal_cache
from w2w.ui.study.sensors import OWN, own_sensor
from w2w.ui.study.state import BAKED, STALE, bake_settings, config_of, patches_of, state_of

from ..sensor_steps import assert_same_to_one_step
from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender")

FIGURES = {
    "acc_range": 4,
    "acc_noise": 700,
    "acc_bias": 35,
    "gyr_noise": 21,
    "gyr_drift": 30,
    "misalignment": 6,
}


def test_the_panels_part_gives_the_numbers_of_the_command_line(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "motions patches")
    study, path = body.w2w, tmp_path / "mine.json"
    study.sensor, study.own_sensor_name = OWN, "my node"
    for name, value in FIGURES.items():
        setattr(study, name, value)
    study.misalignment = 6
    study.band, study.root_band = 14.2, 3
    assert bpy.ops.w2w.save_sensor(filepath=str(path)) == {"FINISHED"}
    asked = StudyOptions(patches=N_PATCHES, sensor=str(path), band=14.2, root_band=3)
    assert config_of(study) == asked.config()
    study.clip_index = 4
    assert bpy.ops.w2w.bake_signals(which="TICKED") == {"FINISHED"}
    clip = study.clips[4]
    motion = read_action(armature_of(body), clip.action)
    expected = simulate(body_of(body), patches_of(body), motion, asked.config())
    baked = signal_cache.recording(clip)
    assert_same_to_one_step(baked, expected, asked.config().sensor_model())
    usual = simulate(body_of(body), patches_of(body), motion, config_of(study).__class__(patches=N_PATCHES))
    assert np.abs(baked.acc - usual.acc).max() > 1


def test_figures_show_the_part_and_change_it(library: Path) -> None:
    study = make_study(library, "").w2w
    assert study.acc_noise == pytest.approx(160)
    study.acc_noise = 90
    study.acc_range = 0
    model = own_sensor(study)
    assert model.accelerometer.noise_density == pytest.approx(90e-6 * 9.80665)
    assert model.accelerometer.full_scale is None
    assert model.gyroscope == preset("bmi270").gyroscope
    study.misalignment = 500
    assert study.misalignment == pytest.approx(90)
    study.own_sensor_name = "bmi270"
    assert study.own_sensor_name == "own part"


def test_another_figure_or_band_makes_signals_stale(library: Path) -> None:
    study = make_study(library, "motions patches signals").w2w
    states = lambda: {state_of(clip, bake_settings(study)) for clip in study.clips}  # noqa: E731
    study.acc_noise = 90
    assert states() == {BAKED}  # another part is chosen
    study.sensor = OWN
    assert states() == {STALE}
    study.sensor = "bmi270"
    assert states() == {BAKED}
    for name, value in (("band", 5), ("root_band", 3)):
        setattr(study, name, value)
        assert states() == {STALE}
        study.property_unset(name)
        assert states() == {BAKED}


def test_a_file_is_read_or_said_to_be_wrong(library: Path, tmp_path: Path) -> None:
    study = make_study(library, "").w2w
    good, bad = tmp_path / "good.json", tmp_path / "bad.json"
    good.write_text('{"name": "node", "like": "watch", "accelerometer": {"full_scale": "16 g"}}')
    bad.write_text('{"accelerometer": {"noise": 3}}')
    assert bpy.ops.w2w.load_sensor(filepath=str(good)) == {"FINISHED"}
    assert study.sensor == OWN
    assert own_sensor(study) == read_sensor(good)
    with pytest.raises(RuntimeError, match=r"'accelerometer\.noise' is no field of a sensor"):
        bpy.ops.w2w.load_sensor(filepath=str(bad))
    with pytest.raises(RuntimeError, match="cannot be read"):
        bpy.ops.w2w.load_sensor(filepath=str(tmp_path / "none.json"))
    assert own_sensor(study) == read_sensor(good)


def test_a_preset_is_a_start(library: Path) -> None:
    study = make_study(library, "").w2w
    assert bpy.ops.w2w.start_sensor(like="xsens mtw awinda") == {"FINISHED"}
    assert study.sensor == OWN
    assert own_sensor(study) == replace(preset("xsens mtw awinda"), name="own part")


def test_a_run_with_a_part_of_its_own_is_opened_with_it(library: Path) -> None:
    study = make_study(library, "").w2w
    model = replace(preset("phone"), name="node", jitter_s=0.002)
    synthesis = Synthesis(rate_hz=80, cutoff_hz=None, convention="paper")
    run = StudyConfig(sensor="node", own_sensor=model, synthesis=synthesis, root_band_hz=3.3)
    study.parameters = json.dumps(run.as_dict())
    restore._set_parameters(study, run)
    found = config_of(study)
    assert (found.sensor_model(), found.synthesis, found.root_band_hz) == (model, synthesis, 3.3)
    study.band = 8
    assert config_of(study).synthesis.cutoff_hz == 8
