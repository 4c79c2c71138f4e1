# SPDX-License-Identifier: GPL-3.0-or-later
"""Long clips: windows of splines against one spline through all."""

import numpy as np
from scipy.interpolate import BSpline, make_interp_spline

from w2w.core.imu.trajectory import spline_windows


def test_windows_agree_with_one_spline_through_the_whole_clip():
    rng = np.random.default_rng(1)
    frames = rng.standard_normal((400, 5))
    spline = make_interp_spline(np.arange(400) / 60, frames, k=5)
    windows = list(spline_windows(400, 60, 100))
    assert len(windows) > 1
    covered = [np.arange(window.samples.start, window.samples.stop) for window in windows]
    np.testing.assert_array_equal(np.concatenate(covered), np.arange(666))
    for window in windows:
        for order, operator in enumerate(window.operators):
            at = np.arange(window.samples.start, window.samples.stop) / 100
            whole = BSpline(spline.t, spline.c, 5)(at, nu=order)
            local = operator @ np.diff(frames[window.frames], n=order, axis=0)
            np.testing.assert_allclose(local, whole, rtol=0, atol=2e-6 * np.abs(whole).max())
