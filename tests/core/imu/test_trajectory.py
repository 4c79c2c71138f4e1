# SPDX-License-Identifier: GPL-3.0-or-later
"""Long clips: windows of splines against one spline through all."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, make_interp_spline
from scipy.sparse import csr_array

from w2w.core.imu.trajectory import (
    DEGREE,
    GENTLE,
    _fit,
    _on_differences,
    _penalty,
    _roughness,
    _smoothed_by_qr,
    spline_windows,
)

pytestmark = pytest.mark.later


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


@pytest.mark.later
@pytest.mark.parametrize("n_frames", [3, 4, 5, 6, 7, 40, 120])
@pytest.mark.parametrize("frames_per_cycle", [1.1, 4, 12, 50, 220])
def test_the_quick_solution_is_as_exact_as_qr(n_frames, frames_per_cycle):
    """To a thousandth of what single precision keeps of the operators."""
    degree, penalty = min(DEGREE, n_frames - 1), _penalty(frames_per_cycle)
    assert penalty < GENTLE
    frames = np.arange(n_frames, dtype=float)
    knots, coefficients = _fit(n_frames, degree, penalty)
    values = BSpline.design_matrix(frames, knots, degree)
    roughness = csr_array(np.sqrt(penalty) * _roughness(knots, degree))
    at = np.linspace(0, n_frames - 1, 2 * n_frames)
    for order in range(min(3, n_frames)):
        quick, exact = (
            _on_differences(BSpline(knots, found, degree)(at, nu=order), order)
            for found in (coefficients, _smoothed_by_qr(values, roughness))
        )
        np.testing.assert_allclose(quick, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_a_band_so_narrow_that_only_a_parabola_passes():
    """Beyond what normal equations can hold; parabolas are what smoothing leaves as they are."""
    frames = np.arange(120.0)
    parabola = 3 - 0.2 * frames + 0.01 * frames**2
    assert _penalty(120 / 0.01) > GENTLE
    (window,) = spline_windows(120, 120, 120, 0.01)
    np.testing.assert_allclose(window.operators[0] @ parabola, parabola, atol=1e-3)
    np.testing.assert_allclose(window.operators[2] @ np.diff(parabola, 2), 0.02 * 120**2, rtol=1e-4)
