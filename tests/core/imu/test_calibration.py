# SPDX-License-Identifier: GPL-3.0-or-later
"""What was done to a sensor is found again: how it sat, its tissue, its noise, when it began."""

import json
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.imu.calibration import calibrate, rest_noise
from w2w.core.imu.presets import preset, read_sensor, write_sensor
from w2w.core.imu.sensor import Triad

from .made_pairs import ACC_NOISE, GYR_NOISE, RATE, TURN, WORN, pair, without_tissue


@pytest.fixture(scope="module")
def found():
    return calibrate([pair(seed=seed, late_s=late) for seed, late in enumerate((0.0, -0.2, -0.13))])


def test_how_the_sensor_sat_is_found(found):
    assert np.degrees((found.turn * TURN.inv()).magnitude()) < 1.5


def test_soft_tissue_is_found(found):
    assert found.tissue.frequency_hz == pytest.approx(WORN.soft_tissue_hz, rel=0.15)
    assert found.tissue.damping == pytest.approx(WORN.soft_tissue_damping, abs=0.11)
    assert found.tissue.gain == pytest.approx(WORN.soft_tissue_gain, abs=0.15)


def test_noise_is_found(found):
    assert found.acc_noise == pytest.approx(ACC_NOISE, rel=0.3)
    assert found.gyr_noise == pytest.approx(GYR_NOISE, rel=0.3)


def test_the_moment_of_the_start_is_found(found):
    assert found.shifts_s == pytest.approx((0.0, -0.2, -0.13), abs=0.021)


@pytest.mark.slow
def test_no_tissue_is_found_where_there_is_none():
    found = calibrate([pair(seed=seed, worn=without_tissue()) for seed in range(3)])
    assert found.tissue is None
    assert np.degrees((found.turn * TURN.inv()).magnitude()) < 0.5


def test_a_calibrated_simulation_is_what_was_worn(found):
    real, made = pair(seed=9)
    left = found.applied(made).acc - real.acc
    assert left.std() < 0.25 * (made.acc - real.acc).std()


def test_the_file_is_a_sensor_that_does_what_was_found(found, tmp_path):
    model = found.sensor(preset("bmi270"), "mine")
    write_sensor(tmp_path / "mine.json", model)
    again = read_sensor(tmp_path / "mine.json")
    assert again == model
    assert again.accelerometer.full_scale == preset("bmi270").accelerometer.full_scale
    assert len(json.loads((tmp_path / "mine.json").read_text())["worn_turn_deg"]) == 3
    _, made = pair(seed=9)
    silent = replace(again, accelerometer=Triad(), gyroscope=Triad(), g_sensitivity=0)
    read = silent.apply(made, 0)
    np.testing.assert_allclose(read.acc, found.applied(made).acc, atol=2e-3)
    np.testing.assert_allclose(read.gyr, found.applied(made).gyr, atol=2e-3)


def test_white_noise_is_measured_through_slow_motion():
    rng, time = np.random.default_rng(0), np.arange(6000) / RATE
    values = 0.05 * rng.normal(size=(6000, 3)) + 3 * np.sin(2 * np.pi * 0.5 * time)[:, None]
    assert rest_noise([values], RATE) == pytest.approx(0.05 / np.sqrt(RATE / 2), rel=0.3)


def test_what_is_too_short_is_said_by_name():
    with pytest.raises(ValueError, match=r"0 is too short: 0\.6 s, with shifts up to 0\.5 s"):
        calibrate([pair(seconds=0.6)])
    with pytest.raises(ValueError, match="nothing to calibrate with"):
        calibrate([])
