# SPDX-License-Identifier: GPL-3.0-or-later
"""Features by MiniRocket's kernels, against their definition and for what they must not know."""

import numpy as np
import pytest

from w2w.core.ranking.features import CHANNELS, UNIT
from w2w.core.ranking.kernels import RAISED, TAPS, kernel_features, kernels


def windows_of(shape, seed=0):
    return np.random.default_rng(seed).normal(size=(*shape, 6)).cumsum(axis=2).astype(np.float32)


def by_definition(window, seed):
    """Window (samples, 6) of one sensor, weight by weight in double precision."""
    window = window.astype(np.float64)
    norms = [np.linalg.norm(window[:, part], axis=1) for part in (slice(3), slice(3, 6))]
    channels = np.column_stack([window, *norms]) / UNIT
    channels -= channels.mean(axis=0)
    shares = []
    for dilation, of_dilation in kernels(len(window), seed).items():
        reach = TAPS // 2 * dilation
        for kernel in of_dilation:
            weights = np.full(TAPS, -1.0)
            weights[list(kernel.raised)] = 2
            signal = channels[:, kernel.channel]
            padded = np.concatenate([np.zeros(reach), signal, np.zeros(reach)])
            ends = range(len(signal))
            output = np.array(
                [weights @ padded[first : first + TAPS * dilation : dilation] for first in ends]
            )
            if not kernel.padded:
                output = output[reach : len(signal) - reach]
            shares.append((output > kernel.threshold * signal.std()).mean())
    return shares


@pytest.mark.parametrize("samples", [100, 125, 12, 5])
def test_features_are_the_shares_of_time_above_the_threshold(samples):
    windows = windows_of((2, 3, samples))
    features = kernel_features(windows, seed=4)
    assert features.dtype == np.float32
    for window, of_sensors in zip(windows, features, strict=True):
        for sensor in range(3):
            wanted = by_definition(window[sensor], seed=4)
            far = np.abs(of_sensors[sensor] - wanted) > 1e-5
            assert far.mean() < 0.02  # single precision may tip a sample that lies at the threshold
            np.testing.assert_allclose(
                of_sensors[sensor], wanted, atol=1.5 / (samples - 8 * (samples > 8)) + 1e-5
            )


def test_every_choice_of_three_raised_weights_is_a_kernel_at_each_dilation():
    of_dilation = kernels(100, seed=0)
    assert list(of_dilation) == [1, 2, 5, 12]
    assert all(sorted(kernel.raised for kernel in found) == sorted(RAISED) for found in of_dilation.values())
    assert len(RAISED) == 84
    drawn = {kernel.channel for found in of_dilation.values() for kernel in found}
    assert drawn == set(range(len(CHANNELS)))


def test_the_seed_draws_the_channels_and_nothing_else_does():
    windows = windows_of((2, 2, 100))
    np.testing.assert_array_equal(kernel_features(windows, 1), kernel_features(windows, 1))
    assert (kernel_features(windows, 1) != kernel_features(windows, 2)).any()


def test_a_window_is_described_alike_whatever_stands_beside_it():
    """So nothing of a test window can be in what is trained on."""
    windows = windows_of((5, 4, 100))
    whole = kernel_features(windows)
    np.testing.assert_array_equal(whole[2:3], kernel_features(windows[2:3]))
    np.testing.assert_allclose(whole[:, 1:2], kernel_features(windows[:, 1:2]), atol=0.02)


def test_gravity_alone_gives_no_pattern():
    windows = windows_of((1, 1, 100))
    tilted = windows.copy()
    tilted[..., :3] += np.array([3.0, -5.0, 7.0], dtype=np.float32)
    mine = [kernel.channel < 6 for found in kernels(100, 0).values() for kernel in found]  # not of magnitudes
    np.testing.assert_allclose(
        kernel_features(windows)[..., mine], kernel_features(tilted)[..., mine], atol=0.025
    )


def test_a_sensor_at_rest_has_finite_features_and_no_windows_give_none():
    assert np.isfinite(kernel_features(np.zeros((1, 2, 100, 6), np.float32))).all()
    assert kernel_features(np.zeros((0, 2, 100, 6), np.float32)).shape == (0, 2, 336)
