# SPDX-License-Identifier: GPL-3.0-or-later
"""A map compared with itself, with noise, and with its reverse."""

import numpy as np
import pytest

from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w_studies.sweep.sensitivity import compare_maps, resampled_clips

ACTIVITIES = ("bow", "jump", "run", "walk")
STRENGTH = np.array([0.0, 0.5, 1.0, 3.0])


def ranked(strength, noise=0, clips=20):
    """Place n carries the activity as strongly as strength[n]; `noise` draws its own disturbance."""
    rng = np.random.default_rng(0)
    activity = np.repeat(ACTIVITIES, clips * 3)
    clip = np.arange(len(activity)) // 3
    centres = rng.normal(size=(4, 1, 10))[np.searchsorted(ACTIVITIES, activity)]
    features = centres * strength[:, None] + rng.normal(size=(len(clip), len(strength), 10))
    features += 0.05 * np.random.default_rng(noise).normal(size=features.shape)
    everything = np.ones(len(clip), bool)
    return utility_map(
        features.astype(np.float32),
        CrossValidation(activity, clip, None, everything, ACTIVITIES),
        Ridge(alphas=(0.1,)),
        resamples=300,
    )


@pytest.fixture(scope="module")
def usual():
    return ranked(STRENGTH)


def test_nothing_changed_holds_exactly(usual):
    same = compare_maps(usual, usual)
    assert (same.rho, same.low, same.high) == (1.0, 1.0, 1.0)
    assert (same.gain, same.gain_low, same.gain_high) == (0.0, 0.0, 0.0)
    assert same.best_holds
    assert len(same.risen) == len(same.fallen) == 0
    low, high = resampled_clips(usual)
    assert 0.5 < low <= high <= 1.0


def test_a_little_noise_changes_little(usual):
    shift = compare_maps(usual, ranked(STRENGTH, noise=1))
    assert shift.rho > 0.9
    assert shift.low <= shift.rho <= shift.high
    assert shift.gain_low < 0 < shift.gain_high
    assert abs(shift.gain) < 0.02
    assert shift.best_holds


def test_the_reverse_flips_and_says_which(usual):
    shift = compare_maps(usual, ranked(STRENGTH[::-1]))
    assert shift.rho < -0.9
    assert not shift.best_holds
    assert 0 in shift.risen
    assert 3 in shift.fallen
    assert not set(shift.risen) & set(shift.fallen)


def test_a_better_map_gains_for_sure(usual):
    shift = compare_maps(usual, ranked(STRENGTH + 1.0))
    assert 0 < shift.gain_low < shift.gain < shift.gain_high


def test_other_clips_have_no_paired_gain(usual):
    shift = compare_maps(usual, ranked(STRENGTH, clips=10))
    assert np.isnan([shift.gain_low, shift.gain_high]).all()
    assert np.isfinite([shift.rho, shift.low, shift.high]).all()
