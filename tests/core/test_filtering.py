# SPDX-License-Identifier: GPL-3.0-or-later
"""Resampling: values at another rate lie where the line between two samples has them."""

import numpy as np
import pytest

from w2w.core.filtering import count_resampled, sampled


@pytest.mark.parametrize("new_rate", [10.0, 40.0, 70.0, 100.0, 250.0])
def test_a_line_stays_the_same_line_at_any_rate(new_rate):
    line = 3.0 + 0.5 * np.arange(81)  # at 100 Hz
    found = sampled(np.stack([line, -line]), 100.0, new_rate)
    assert found.shape == (2, count_resampled(81, 100.0, new_rate))
    expected = 3.0 + 0.5 * np.arange(found.shape[-1]) * (100.0 / new_rate)
    np.testing.assert_allclose(found, [expected, -expected], rtol=1e-12)


def test_samples_that_meet_are_taken_as_they_are():
    values = np.random.default_rng(0).normal(size=101)
    np.testing.assert_array_equal(sampled(values, 100.0, 25.0), values[::4])


def test_what_lies_above_half_of_the_new_rate_folds_back():
    times = np.arange(1001) / 1000
    fast = np.sin(2 * np.pi * 90 * times)
    slow = np.sin(2 * np.pi * -10 * np.arange(101) / 100)
    np.testing.assert_allclose(sampled(fast, 1000.0, 100.0), slow, atol=1e-9)
