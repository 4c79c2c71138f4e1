# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated signals of other axes and with noise of their own serve once they are calibrated."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.calibration import turned
from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import WindowSpec
from w2w_studies.validation.calibrated_transfer import (
    AS_SIMULATED,
    DIFFERENCES,
    OTHER_ACTIONS,
    TURNED,
    calibrated_transfer,
    limited,
    with_differences,
)

RATE = 50.0
TURN = Rotation.from_euler("xyz", [20, -130, 70], degrees=True)
SPEC = WindowSpec(length_s=3.0, stride_s=3.0)
AXES = {"nod": (1, 0, 0), "shake": (0, 1, 0), "roll": (0, 0, 1), "still": (0, 0, 0)}


def pair(activity, person, number, rng):
    """Worn in other axes; what is simulated rattles at 15 Hz, which no worn sensor does."""
    time = np.arange(150) / RATE
    wave = np.sin(2 * np.pi * rng.uniform(0.8, 1.2) * time + rng.uniform(0, 6))[:, None]
    gyr = 2 * wave * AXES[activity] + 0.02 * rng.normal(size=(150, 3))
    acc = np.array([0, 0, 9.8]) + wave * np.roll(AXES[activity], 1) + 0.02 * rng.normal(size=(150, 3))
    name = f"{person} {activity} {number}"
    real = ImuRecording(acc[:, None], gyr[:, None], RATE, ("wrist",), activity, person, name)
    rattle = rng.uniform(0.5, 3) * np.sin(2 * np.pi * 15 * time)[:, None] * rng.normal(size=3)
    made = ImuRecording((acc + rattle)[:, None], gyr[:, None], RATE, ("wrist",), activity, person, name)
    return turned(real, TURN), made


@pytest.fixture(scope="module")
def steps():
    rng = np.random.default_rng(0)
    pairs = [pair(a, f"p{p}", n, rng) for a in AXES for p in range(3) for n in range(2)]
    return {step.trained: step for step in calibrated_transfer(pairs, tuple(AXES), SPEC, 4.0)}


@pytest.mark.slow
def test_every_step_is_reported_with_its_interval(steps):
    between = ["and on its soft tissue", "and both sides below 4 Hz"]
    assert list(steps) == [AS_SIMULATED, TURNED, *between, DIFFERENCES, OTHER_ACTIONS]
    for step in steps.values():
        assert step.tested == "real"
        assert step.low <= step.macro_f1 <= step.high
        assert step.confusion.sum() == 24


@pytest.mark.slow
def test_calibration_on_other_people_brings_simulation_to_the_worn_sensor(steps):
    assert steps[AS_SIMULATED].macro_f1 < 0.7
    assert steps["and both sides below 4 Hz"].macro_f1 > 0.9
    assert steps[DIFFERENCES].macro_f1 > 0.9
    assert steps[OTHER_ACTIONS].macro_f1 > 0.9


def test_differences_teach_no_activity():
    """Each simulated window gets differences of any activity: those of one class do not become its own."""
    made, label = np.zeros((40, 1)), np.repeat([0, 1], 20)
    differ = np.repeat([[5.0], [-5.0]], 20, axis=0)
    copies, labels = with_differences(made, label, differ)
    assert len(copies) == len(labels) == 320
    assert abs(copies[labels == 0].mean() - copies[labels == 1].mean()) < 1.5


def test_a_band_takes_out_what_lies_above_it():
    rng = np.random.default_rng(1)
    _, made = pair("still", "p", 0, rng)
    below = limited(made, 4.0)
    assert below.acc.std(axis=0).max() < 0.2 * made.acc.std(axis=0).max()
    assert limited(made, 25.0) is made


def test_one_person_cannot_be_left_out():
    rng = np.random.default_rng(0)
    with pytest.raises(ValueError, match="two at least"):
        calibrated_transfer([pair("nod", "p", n, rng) for n in range(2)], ("nod",), SPEC, 4.0)
