# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows: their number, their overlap, and recordings shorter than one."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.imu.recording import ImuRecording
from w2w.core.windows.windows import TooShortError, WindowSpec, cut_windows


def recording(n_frames, rate=50.0, n_sensors=2):
    time = np.arange(n_frames, dtype=np.float32)
    acc = time[:, None, None] + np.arange(3) * 1000 + np.arange(n_sensors)[:, None] * 10000
    return ImuRecording(acc, -acc - 1, rate, clip="walk")


def test_windows_hold_the_samples_they_should():
    windows, is_test, _ = cut_windows(recording(260), WindowSpec(length_s=2.0, stride_s=1.0))
    assert windows.shape == (4, 2, 100, 6)
    assert windows.dtype == np.float32
    np.testing.assert_array_equal(windows[3, 1, :, 2], 10000 + 2000 + np.arange(150, 250))
    np.testing.assert_array_equal(windows[3, 1, :, 5], -windows[3, 1, :, 2] - 1)
    np.testing.assert_array_equal(is_test, [True, False, True, False])


@given(
    n_frames=st.integers(30, 400),
    length=st.floats(0.5, 4.0),
    stride=st.floats(0.1, 1.0),
    rate=st.sampled_from([25.0, 50.0, 100.0]),
)
def test_test_windows_never_overlap_and_one_always_exists(n_frames, length, stride, rate):
    spec = WindowSpec(length_s=length, stride_s=stride * length, shortest_s=0.01)
    windows, is_test, _ = cut_windows(recording(n_frames, rate, 1), spec)
    assert windows.shape[2] == spec.samples(rate)
    assert is_test[0]
    if n_frames >= spec.samples(rate):
        first = windows[is_test, 0, 0, 0]
        assert (np.diff(first) >= spec.samples(rate)).all()


def test_short_recording_is_played_back_and_forth():
    short = recording(30, n_sensors=1)
    windows, is_test, _ = cut_windows(short, WindowSpec())
    assert windows.shape == (1, 1, 100, 6)
    assert is_test.all()
    forth_and_back = np.concatenate(
        [np.arange(30), np.arange(30)[::-1], np.arange(30), np.arange(29, 19, -1)]
    )
    sign = np.repeat([1, -1, 1, -1], [30, 30, 30, 10])
    np.testing.assert_array_equal(windows[0, 0, :, 0], short.acc[forth_and_back, 0, 0])
    np.testing.assert_array_equal(windows[0, 0, :, 4], sign * short.gyr[forth_and_back, 0, 1])


def test_reversal_of_time_is_what_a_body_turning_back_would_give():
    """A rotation by theta(t) about z, played backwards: rate changes sign, centripetal force stays."""
    rate, time = 100.0, np.arange(60) / 100.0
    spin = 1.0 + time**2
    gyr = np.zeros((60, 1, 3))
    acc = np.zeros((60, 1, 3))
    gyr[:, 0, 2] = spin
    acc[:, 0, 0] = -0.3 * spin**2
    acc[:, 0, 1] = 0.3 * 2 * time
    one = ImuRecording(acc, gyr, rate, clip="spin")
    windows, *_ = cut_windows(one, WindowSpec(length_s=1.2, stride_s=1.2))
    back = windows[0, 0, 60:]
    angle_acceleration = np.gradient(back[:, 5], 1 / rate)
    np.testing.assert_allclose(back[:, 0], -0.3 * back[:, 5] ** 2, rtol=1e-5)
    np.testing.assert_allclose(back[1:-1, 1], 0.3 * angle_acceleration[1:-1], atol=1e-4)


def test_cycle_repeats():
    windows, *_ = cut_windows(recording(30, n_sensors=1), WindowSpec(short="cycle"))
    np.testing.assert_array_equal(windows[0, 0, :, 0], np.arange(100) % 30)


def test_short_gaps_are_bridged_by_straight_lines():
    whole = recording(100)
    holed = recording(100)
    holed.acc[40:45, 1] = np.nan
    holed.gyr[60, 0, 2] = np.nan
    windows, *_ = cut_windows(holed, WindowSpec())
    np.testing.assert_allclose(windows, cut_windows(whole, WindowSpec()).signals, rtol=1e-6)


@pytest.mark.parametrize(("start", "stop"), [(120, 126), (0, 1), (399, 400)])
def test_windows_with_a_long_gap_or_a_ragged_end_are_left_out_for_all_sensors(start, stop):
    holed = recording(400)
    holed.acc[start:stop, 1] = np.nan
    windows, is_test, _ = cut_windows(holed, WindowSpec())
    starts = [s for s in range(0, 301, 50) if stop <= s or s + 100 <= start]
    np.testing.assert_array_equal(windows[:, 0, 0, 0], starts)
    assert np.isfinite(windows).all()
    assert is_test[0]
    assert (np.diff(np.array(starts)[is_test]) >= 100).all()


def test_a_recording_full_of_holes_is_refused():
    holed = recording(300)
    holed.gyr[50::60] = np.nan
    holed.gyr[51::60] = np.nan
    with pytest.raises(
        TooShortError, match="'walk' has no 2 s without a gap of lost samples longer than 0 s"
    ):
        cut_windows(holed, WindowSpec(longest_gap_s=0))


def test_a_sensor_without_a_single_sample_is_refused():
    holed = recording(400)
    acc = holed.acc.copy()
    acc[:, 1] = np.nan
    with pytest.raises(TooShortError, match="without a gap"):
        cut_windows(ImuRecording(acc, holed.gyr, 50.0, activity="walk", clip="walk"), WindowSpec())


def test_too_short_says_which_clip_and_by_how_much():
    with pytest.raises(TooShortError, match=r"'walk' lasts 0\.40 s, shorter than the 0\.5 s"):
        cut_windows(recording(20), WindowSpec())
    with pytest.raises(TooShortError, match=r"shorter than the 2 s"):
        cut_windows(recording(90), WindowSpec(short="refuse"))


@pytest.mark.parametrize(
    ("parameter", "value"),
    [
        ("length_s", 0.0),
        ("length_s", np.nan),
        ("stride_s", 0.0),
        ("stride_s", 3.0),
        ("short", "pad"),
        ("shortest_s", 0.0),
        ("longest_gap_s", -1.0),
    ],
)
def test_wrong_parameters_are_named(parameter, value):
    with pytest.raises(ValueError, match=parameter):
        WindowSpec(**{parameter: value})


def test_a_clip_that_would_be_repeated_for_minutes_is_refused():
    short, long = recording(100), recording(600)  # 2 s and 12 s
    with pytest.raises(TooShortError, match=r"'walk' lasts 2\.00 s, shorter than the 12 s a window needs"):
        cut_windows(short, WindowSpec.of_length(600.0))
    assert cut_windows(long, WindowSpec.of_length(600.0)).signals.shape == (1, 2, 30000, 6)
    assert cut_windows(short, WindowSpec.of_length(100.0)).signals.shape == (1, 2, 5000, 6)
