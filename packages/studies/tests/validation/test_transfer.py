# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities learned by sensors of one kind and named by those of another, mounted another way round."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.calibration import turned
from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import WindowSpec
from w2w_studies.validation.correlation import magnitude_correlation
from w2w_studies.validation.transfer import transfer

RATE = 50.0
TURN = Rotation.from_euler("xyz", [20, -130, 70], degrees=True)
SPEC = WindowSpec(length_s=3.0, stride_s=3.0)
AXES = {"nod": (1, 0, 0), "shake": (0, 1, 0), "roll": (0, 0, 1)}
"""Activities that differ only by the axis of the turn."""


def clip(activity, person, number, rng):
    time = np.arange(150) / RATE
    wave = np.sin(2 * np.pi * rng.uniform(0.8, 1.2) * time + rng.uniform(0, 6))[:, None]
    gyr = 2 * wave * AXES[activity] + 0.02 * rng.normal(size=(150, 3))
    acc = np.array([0, 0, 9.8]) + wave * np.roll(AXES[activity], 1) + 0.02 * rng.normal(size=(150, 3))
    return ImuRecording(
        acc[:, None], gyr[:, None], RATE, ("wrist",), activity, person, f"{person} {activity} {number}"
    )


@pytest.fixture
def pairs():
    rng = np.random.default_rng(0)
    made = [clip(a, f"p{p}", n, rng) for a in AXES for p in range(3) for n in range(3)]
    return [(turned(one, TURN), one) for one in made]


def test_activities_carry_over_between_the_sides(pairs):
    ways = transfer(pairs, tuple(AXES), SPEC)
    assert [(t.trained, t.tested) for t in ways] == [
        ("real", "real"), ("real", "simulated"), ("simulated", "real"), ("simulated", "simulated"),
    ]  # fmt: skip
    for way in ways:
        assert way.macro_f1 > 0.95
        assert way.low <= way.macro_f1 <= way.high
        assert way.confusion.sum() == len(pairs)


def test_simulated_signals_of_other_activities_do_not_carry_over(pairs):
    names = list(AXES)
    wrong = [
        (real, pairs[(number + 9) % len(pairs)][1]) for number, (real, _) in enumerate(pairs)
    ]  # nod is shown as shake, shake as roll, roll as nod
    ways = {(t.trained, t.tested): t.macro_f1 for t in transfer(wrong, names, SPEC)}
    assert ways["real", "real"] > 0.95
    assert ways["simulated", "real"] < 0.7


def test_one_person_cannot_be_left_out(pairs):
    with pytest.raises(ValueError, match="two at least"):
        transfer([pair for pair in pairs if pair[0].subject == "p0"], tuple(AXES), SPEC)


@pytest.mark.parametrize("lag", [-10, 0, 7])
def test_magnitudes_correlate_whatever_the_axes_and_the_lag_is_found(lag):
    rng = np.random.default_rng(1)
    path = np.cumsum(rng.normal(size=(400, 3)), axis=0) + [0, 0, 30]
    first, second = path[50 : 50 + 300], TURN.apply(path[50 + lag : 350 + lag]) * 2
    found = magnitude_correlation(first, second, RATE, 5.0, 0.5)
    assert found.best_lag > 0.99
    assert found.lag_s == pytest.approx(lag / RATE)
    assert found.amplitude == pytest.approx(2, rel=0.3)
    assert (found.zero_lag > 0.99) == (lag == 0)


def test_a_few_samples_are_not_compared():
    with pytest.raises(ValueError, match="too few"):
        magnitude_correlation(np.ones((30, 3)), np.ones((30, 3)), RATE, 5.0, 0.5)
