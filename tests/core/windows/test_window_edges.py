# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows, folds and features to the last sample, clip and line of the spectrum."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.folds import grouped_folds
from w2w.core.windows.features import BAND_EDGES_HZ, CHANNELS, feature_names, window_features
from w2w.core.windows.windows import TooShortError, WindowSpec, cut_windows


def counted(n_samples, rate=50.0):
    """One sensor whose first channel holds the sample's number."""
    acc = np.zeros((n_samples, 1, 3), np.float32)
    acc[:, 0, 0] = np.arange(n_samples)
    return ImuRecording(acc, np.zeros_like(acc), rate, clip="count")


@pytest.mark.parametrize(
    ("n_samples", "starts"), [(100, [0]), (149, [0]), (150, [0, 50]), (249, [0, 50, 100])]
)
def test_the_last_whole_window_is_cut_and_no_part_of_one(n_samples, starts):
    windows, *_ = cut_windows(counted(n_samples), WindowSpec(length_s=2.0, stride_s=1.0))
    np.testing.assert_array_equal(windows[:, 0, 0, 0], starts)
    np.testing.assert_array_equal(windows[:, 0, -1, 0], np.array(starts) + 99)


def test_lengths_strides_and_gaps_are_rounded_to_the_nearest_sample():
    """0.35 s at 52 Hz is 18.2 samples, 0.3 s 15.6 and 0.05 s 2.6."""
    spec = WindowSpec(length_s=0.35, stride_s=0.3, longest_gap_s=0.05)
    assert (spec.samples(52.0), spec.stride(52.0)) == (18, 16)
    assert WindowSpec(length_s=0.3, stride_s=0.3).samples(52.0) == 16
    whole = WindowSpec(length_s=1.0, stride_s=1.0, longest_gap_s=0.05)
    holed = counted(52, rate=52.0)
    holed.acc[20:23] = np.nan
    np.testing.assert_allclose(cut_windows(holed, whole).signals[0, 0, :, 0], np.arange(52), rtol=1e-6)
    holed.acc[20:24] = np.nan
    with pytest.raises(TooShortError):
        cut_windows(holed, whole)


def test_a_recording_just_as_long_as_the_shortest_is_taken():
    assert cut_windows(counted(25), WindowSpec(shortest_s=0.5)).signals.shape == (1, 1, 100, 6)
    with pytest.raises(TooShortError):
        cut_windows(counted(24), WindowSpec(shortest_s=0.5))


def test_folds_hold_equal_shares_of_windows_where_clips_differ_in_length():
    """The longest clips are dealt first, and each next to the fold with least: Graham's rule."""
    length = np.array([40, 30, 20, 10, 10, 10])
    clip = np.repeat(np.arange(6), length)
    for seed in range(10):
        fold = grouped_folds(np.full(len(clip), "walk"), clip, 3, seed)
        assert sorted(np.bincount(fold, minlength=3).tolist()) == [40, 40, 40]


def test_folds_of_several_activities_have_alike_many_windows():
    """Two activities with two clips each over three folds: the short clips do not pile up in one fold."""
    activity = np.repeat(["bow", "walk"], [6, 60])
    clip = np.repeat(np.arange(5), [3, 3, 20, 20, 20])
    for seed in range(10):
        fold = grouped_folds(activity, clip, 3, seed)
        assert np.bincount(fold[activity == "walk"], minlength=3).tolist() == [20, 20, 20]
        assert sorted(np.bincount(fold[activity == "bow"], minlength=3).tolist()) == [0, 3, 3]


def test_clips_of_different_activities_do_not_share_a_fold_while_one_is_empty():
    activity, clip = np.repeat(["bow", "walk"], [6, 6]), np.repeat(np.arange(4), 3)
    for seed in range(10):
        assert np.bincount(grouped_folds(activity, clip, 4, seed), minlength=4).tolist() == [3, 3, 3, 3]


def sine(frequency, samples=200, rate=50.0, channel=0, size=1.0):
    windows = np.zeros((1, 1, samples, 6), dtype=np.float32)
    windows[0, 0, :, channel] = size * np.sin(2 * np.pi * frequency * np.arange(samples) / rate + 0.3)
    return windows


def band_power(windows, channel, rate=50.0):
    """Mean square by band, in the channel's own unit."""
    names = feature_names(windows.shape[2], rate)
    features = window_features(windows, rate)[0, 0]
    columns = [i for i, name in enumerate(names) if name.startswith(f"{channel} log power")]
    return np.exp(2.5 * (features[columns] - 2)) - 0.0025**2


def test_a_sine_on_a_line_falls_on_three_lines_and_no_other():
    """1 : 4 : 1, as a periodic Hann window has it; of 1.75, 2 and 2.25 Hz the first is in the band below."""
    power = band_power(sine(2.0, channel=3), "gyr x")
    band = BAND_EDGES_HZ.tolist().index(1.8)
    np.testing.assert_allclose(power[[band - 1, band]], [0.5 / 6, 0.5 * 5 / 6], rtol=1e-4)
    assert np.delete(power, [band - 1, band]).max() < 1e-7


def test_a_sine_between_two_lines_leaks_no_further_than_a_taper_lets_it():
    """Without one, a thousandth of its power would lie above 5.5 Hz."""
    power = band_power(sine(2.125, channel=3), "gyr x")
    band = BAND_EDGES_HZ.tolist().index(1.8)
    assert power[band] / power.sum() > 0.95
    assert power[-4:].sum() / power.sum() < 2e-6
    assert power.sum() == pytest.approx(0.5, rel=0.02)


def test_a_line_on_an_edge_belongs_to_the_band_above():
    """7.5 Hz on the dot: as much above the edge as the line and its upper neighbour hold, 5 of 6."""
    power = band_power(sine(7.5, channel=4), "gyr y")
    upper = BAND_EDGES_HZ.tolist().index(7.5)
    assert power[upper] / power.sum() == pytest.approx(5 / 6, rel=0.01)
    assert power[upper - 1] / power.sum() == pytest.approx(1 / 6, rel=0.02)


def test_magnitudes_are_lengths_in_units_of_their_own():
    """|acc| over 4 m/s2 and |gyr| over 1 rad/s, of vectors of known length."""
    windows = np.zeros((1, 1, 50, 6), dtype=np.float32)
    windows[..., :3], windows[..., 3:] = (2, 3, 6), (1, 2, 2)
    features = dict(zip(feature_names(50, 50.0), window_features(windows, 50.0)[0, 0], strict=True))
    expected = dict(zip(CHANNELS, (2 / 4, 3 / 4, 6 / 4, 1, 2, 2, 7 / 4, 3), strict=True))
    for channel, value in expected.items():
        assert features[f"{channel} mean"] == pytest.approx(np.arcsinh(value), rel=1e-5)


@pytest.mark.parametrize("samples", [100, 250])
def test_crossings_are_those_of_the_mean_per_second(samples):
    """A sine of 3 Hz crosses its mean six times a second, however small beside its offset.

    Two spikes a second cross theirs four times.
    """
    t = np.arange(samples) / 50.0
    windows = np.zeros((1, 1, samples, 6), dtype=np.float32)
    windows[0, 0, :, 0] = 9.81 + 0.02 * np.sin(2 * np.pi * 3 * t + 0.1)
    windows[0, 0, :, 1] = np.where(np.arange(samples) % 25 == 5, 10.0, 0.0)
    windows[0, 0, :, 2] = np.sin(2 * np.pi * 3 * t + 0.1)
    features = dict(zip(feature_names(samples, 50.0), window_features(windows, 50.0)[0, 0], strict=True))
    for axis, crossings in (("x", 6.0), ("y", 4.0), ("z", 6.0)):
        found = (np.exp(features[f"acc {axis} crossings"] + 1) - 1) * 4
        assert found == pytest.approx(crossings, abs=0.6)
