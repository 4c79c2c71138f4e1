# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches tried by worker processes: the same map, and workers that die of it are said."""

import os
from contextlib import closing

import numpy as np
import pytest

from w2w.headless.runs.workers import Crew, EngineError, spread_here

from .made_patches import made_patches, ranked

pytestmark = pytest.mark.usefixtures("few_orders")


def test_workers_give_the_same_map(tmp_path):
    library, told, shared = made_patches(tmp_path), [], []

    def spread(work, items):
        shared.append(len(items))
        return over(work, items)

    with closing(Crew()) as crew:
        over = spread_here(2, crew)
        here, there = ranked(library, None), ranked(library, spread, progress=told.append)
    for name in ("predictions", "f1", "expected_f1", "expected_mean", "expected_low", "errors"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert shared == [1, 2]  # ridges are tried on few patches, then 16 patches are ranked and 4
    assert told == [0.5, 1.0]


@pytest.mark.slow
def test_workers_that_die_at_it_end_the_run_with_a_sentence():
    with pytest.raises(EngineError, match="die while they rank patches"):
        list(spread_here(2, Crew())(_die, [1, 2]))


def test_with_one_worker_patches_stay_in_this_process():
    assert spread_here(1, Crew()) is None


def _die(_item):
    os._exit(1)
