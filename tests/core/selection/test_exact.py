# SPDX-License-Identifier: GPL-3.0-or-later
"""Branch and bound finds what trying every set finds."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from w2w.core.selection.exact import FacilityLocation, best_small_set

MAPS = arrays(
    np.float64,
    st.tuples(st.integers(2, 9), st.integers(1, 5)),
    elements=st.integers(0, 20).map(lambda n: n / 20),
)


def mean_max(value, places):
    return value[list(places)].max(axis=0).mean()


@settings(max_examples=150)
@given(value=MAPS, size=st.integers(1, 5), data=st.data())
def test_as_good_as_every_set_tried(value, size, data):
    places = st.integers(0, len(value) - 1)
    required = [sorted(group) for group in data.draw(st.lists(st.sets(places, min_size=1), max_size=3))]
    met = [
        s
        for k in range(1, size + 1)
        for s in combinations(range(len(value)), k)
        if all(set(group) & set(s) for group in required)
    ]
    found = best_small_set(value, size, [np.array(group) for group in required])
    best = max((mean_max(value, s) for s in met), default=None)
    if found is None:
        assert best is None
        return
    assert tuple(sorted(set(found))) in met
    assert mean_max(value, found) == pytest.approx(best)
    assert best_small_set(value, size, [np.array(g) for g in required], best) is not None
    assert best_small_set(value, size, [np.array(g) for g in required], best + 1e-6) is None


def test_as_good_as_the_integer_programme():
    rng = np.random.default_rng(4)
    value = 1 / (1 + np.exp(-rng.normal(size=(80, 3)) @ rng.normal(size=(3, 12))))
    for size in (2, 3, 4):
        exact = FacilityLocation(value, np.ones(80), [], size, 60.0).best()
        found = best_small_set(value, size)
        assert exact.proven
        assert mean_max(value, found) == pytest.approx(mean_max(value, exact.patches), abs=2e-6)
