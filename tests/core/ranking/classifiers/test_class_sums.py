# SPDX-License-Identifier: GPL-3.0-or-later
"""Sums and means by class, against loops over the rows."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.ranking.classifiers.discriminant import averaging, summing


@pytest.mark.later
@given(st.lists(st.integers(0, 4), max_size=30), st.integers(1, 6), st.integers(0, 2**32 - 1))
def test_rows_are_added_up_and_averaged_group_by_group(groups, width, seed):
    """A group may have no rows: its sum and its mean are 0."""
    rows = np.random.default_rng(seed).normal(size=(len(groups), width)).astype(np.float32)
    group = np.array(groups, dtype=int)
    sums, means = summing(group, 5) @ rows, averaging(group, 5) @ rows
    assert sums.shape == means.shape == (5, width)
    assert sums.dtype == means.dtype == np.float32
    for number in range(5):
        own = rows[group == number]
        np.testing.assert_allclose(sums[number], own.sum(axis=0), atol=1e-5)
        np.testing.assert_allclose(means[number], own.mean(axis=0) if len(own) else 0, atol=1e-5)
