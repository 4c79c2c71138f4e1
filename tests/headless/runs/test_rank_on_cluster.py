# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches tried by a cluster's workers: the same map, and a worker that cannot do it is said."""

import os

import numpy as np
import pytest

from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import utility_map
from w2w.core.windows.inputs import FeatureFiles
from w2w.headless.runs.cluster import spread_over
from w2w.headless.runs.workers import EngineError

from .made_patches import NAMES, made_patches, ranked


@pytest.fixture
def scheduler():
    """Address of a real scheduler with two worker processes."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster:
        yield cluster.scheduler_address


@pytest.fixture
def library(tmp_path):
    return made_patches(tmp_path)


@pytest.mark.slow
def test_a_cluster_gives_the_same_map(library, scheduler):
    told = []
    here, there = ranked(library, None), ranked(library, spread_over(scheduler), progress=told.append)
    for name in ("predictions", "f1", "expected_f1", "expected_mean", "expected_low", "errors"):
        np.testing.assert_array_equal(getattr(here, name), getattr(there, name))
    assert told == [0.5, 1.0]  # 16 patches and 4


@pytest.mark.slow
def test_what_a_worker_cannot_read_is_said(library, scheduler):
    folder, activity, clip = library
    source = FeatureFiles([folder / f"{number}.npz" for number in range(36)])
    spread = spread_over(scheduler)

    def without_files(work, items):
        (folder / "7.npz").unlink()
        return spread(work, items)

    is_test = np.arange(len(clip)) % 2 == 0
    with pytest.raises(FileNotFoundError, match=r"7\.npz"):
        utility_map(source, CrossValidation(activity, clip, None, is_test, NAMES), spread=without_files)


@pytest.mark.slow
def test_workers_that_die_at_it_end_the_run_with_a_sentence(scheduler):
    with pytest.raises(EngineError, match="keep dying while they rank patches"):
        list(spread_over(scheduler)(_die, [1]))


def test_without_a_scheduler_patches_are_tried_here():
    assert spread_over("") is None


def _die(_item):
    os._exit(1)
