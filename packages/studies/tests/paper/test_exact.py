# SPDX-License-Identifier: GPL-3.0-or-later
"""The integer programme finds what trying every set finds."""

from itertools import combinations

import numpy as np
import pytest

from w2w_studies.paper.exact import FacilityLocation


def mean_max(value, places):
    return value[list(places)].max(axis=0).mean()


@pytest.mark.parametrize("seed", range(20))
def test_as_good_as_every_set_tried(seed):
    rng = np.random.default_rng(seed)
    value, allowed = rng.uniform(size=(8, 4)), rng.random(8) < 0.8
    allowed[:2] = True
    group, size = np.array([0, 1]), int(rng.integers(1, 5))
    found = FacilityLocation(value, np.ones(8), allowed, [group], size, 60.0).best()
    met = [
        places
        for count in range(1, size + 1)
        for places in combinations(np.flatnonzero(allowed).tolist(), count)
        if set(places) & {0, 1}
    ]
    assert found.proven
    assert tuple(found.patches.tolist()) in met
    assert mean_max(value, found.patches) == pytest.approx(max(mean_max(value, one) for one in met), abs=1e-5)
