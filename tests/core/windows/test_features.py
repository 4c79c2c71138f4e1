# SPDX-License-Identifier: GPL-3.0-or-later
"""Features of signals whose statistics and spectra are known."""

import numpy as np
import pytest
from scipy.stats import kurtosis, skew
from threadpoolctl import threadpool_limits

from w2w.core.windows.features import BAND_EDGES_HZ, FLOOR, feature_names, sum_rows, window_features

RATE = 50.0


def column(name, rate=RATE, samples=100):
    return feature_names(samples, rate).index(name)


def mean_square(log_power):
    """Undo the logarithm of a band's mean square, in units squared."""
    return np.exp(2.5 * (log_power - 2))


def test_a_sine_has_its_power_in_its_band_and_its_statistics():
    time = np.arange(100) / RATE
    windows = np.zeros((1, 1, 100, 6), dtype=np.float32)
    windows[0, 0, :, 0] = 9.0 + 3.0 * np.sin(2 * np.pi * 2.0 * time)
    features = window_features(windows, RATE)[0, 0]
    assert features[column("acc x mean")] == pytest.approx(np.arcsinh(9.0 / 4), abs=1e-4)
    assert features[column("acc x highest")] == pytest.approx(np.arcsinh(3.0 / 4), rel=5e-3)
    assert features[column("acc x crossings")] == pytest.approx(np.log1p(4 / 4) - 1, abs=0.05)
    assert features[column("acc x slope")] == pytest.approx(np.log(4 * 2.0 * 3.0 / 4 / 10) / 1.5, abs=0.01)
    bands = [name for name in feature_names(100, RATE) if name.startswith("acc x log power")]
    power = mean_square(features[[column(name) for name in bands]])
    assert bands[int(power.argmax())] == "acc x log power 1.8-2.4 Hz"
    assert power.sum() == pytest.approx(4.5 / 4**2, rel=0.02)


def test_statistics_equal_scipy():
    rng = np.random.default_rng(0)
    windows = rng.gamma(2.0, 3.0, size=(3, 2, 100, 6)).astype(np.float32)
    features = window_features(windows, RATE)
    for channel, name in enumerate(("acc x", "acc y", "acc z", "gyr x", "gyr y", "gyr z")):
        signal = windows[..., channel].astype(np.float64)
        unit = 4.0 if name.startswith("acc") else 1.0
        for statistic, expected in {
            "mean": np.arcsinh(signal.mean(axis=2) / unit),
            "lowest": np.arcsinh((signal.min(axis=2) - signal.mean(axis=2)) / unit),
            "std": np.log(signal.std(axis=2) / unit) / 1.5,
            "skewness": np.arcsinh(skew(signal, axis=2)),
            "kurtosis": 2 * np.log1p(kurtosis(signal, axis=2, fisher=False)) - 3,
        }.items():
            found = features[..., column(f"{name} {statistic}")]
            np.testing.assert_allclose(found, expected, rtol=2e-3, atol=2e-3)
    correlation = np.corrcoef(windows[1, 1, :, 1], windows[1, 1, :, 5])[0, 1]
    assert features[1, 1, column("acc y * gyr z")] == pytest.approx(2 * correlation, abs=1e-3)


def test_power_adds_up_to_the_variance_whatever_length_and_rate():
    rng = np.random.default_rng(1)
    for samples, rate in ((100, 50.0), (125, 25.0), (60, 30.0), (400, 200.0)):
        signal = rng.normal(size=(1, 200, samples, 6)).astype(np.float32)
        features = window_features(signal, rate)[0]
        names = feature_names(samples, rate)
        assert features.shape == (200, len(names))
        bands = [k for k, name in enumerate(names) if name.startswith("gyr y log power")]
        frequencies = np.arange(1, samples // 2 + 1) * rate / samples
        in_bands = ((frequencies >= BAND_EDGES_HZ[0]) & (frequencies < BAND_EDGES_HZ[-1])).sum()
        expected = in_bands * 2 / samples
        assert mean_square(features[:, bands]).sum(axis=1).mean() == pytest.approx(expected, rel=0.05)


@pytest.mark.parametrize("count", [1, 2, 4, 8, 9, 10, 20, 129, 130, 300])
def test_rows_are_summed_as_numpy_reduces_them(count):
    rows = np.random.default_rng(count).normal(size=(count, 50)).astype(np.float32)
    np.testing.assert_array_equal(sum_rows(rows), np.add.reduceat(rows, [0], axis=0)[0])


def test_strided_and_contiguous_windows_give_the_same_features():
    rng = np.random.default_rng(2)
    signal = rng.normal(size=(260, 3, 6)).astype(np.float32)
    views = np.lib.stride_tricks.sliding_window_view(signal, 100, axis=0)[::50]
    strided = np.moveaxis(views, 3, 2)
    np.testing.assert_array_equal(
        window_features(strided, RATE), window_features(np.ascontiguousarray(strided), RATE)
    )


def test_features_of_a_sensor_do_not_depend_on_the_others():
    windows = np.random.default_rng(3).normal(size=(2, 5, 100, 6)).astype(np.float32)
    together, alone = window_features(windows, RATE), window_features(windows[:, 2:3], RATE)
    np.testing.assert_allclose(together[:, 2:3], alone, rtol=1e-4, atol=1e-4)


def test_a_sensor_at_rest_has_finite_features():
    still = np.zeros((1, 1, 100, 6), dtype=np.float32)
    still[..., 2] = 9.81
    assert np.isfinite(window_features(still, RATE)).all()


def test_no_windows_give_no_features_of_the_right_width():
    features = window_features(np.zeros((0, 4, 100, 6), dtype=np.float32), RATE)
    assert features.shape == (0, 4, len(feature_names(100, RATE)))


def test_features_are_the_same_whatever_threads_there_are():
    """A product as large as this is split over two threads, which rounds otherwise."""
    windows = np.random.default_rng(4).normal(size=(2, 64, 200, 6)).astype(np.float32)
    found = []
    for threads in (1, 2):
        with threadpool_limits(threads):
            found.append(window_features(windows, 100.0))
    np.testing.assert_array_equal(*found)


def test_a_channel_that_stands_still_is_at_the_floor_and_correlates_with_none():
    windows = np.zeros((1, 1, 100, 6), dtype=np.float32)
    windows[..., 0] = np.random.default_rng(2).normal(size=100)
    windows[..., 1] = 9.81
    features = window_features(windows, RATE)[0, 0]
    assert features[column("acc y std")] == pytest.approx(np.log(FLOOR) / 1.5, rel=1e-4)
    assert features[column("acc x * acc y")] == pytest.approx(0, abs=1e-3)
