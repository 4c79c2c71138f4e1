# SPDX-License-Identifier: GPL-3.0-or-later
"""What sets are judged by: halves that a ranking knows already are not ranked again."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.ranking.halves import CrossValidation, maps_of
from w2w.core.ranking.joint_scores import JointScores
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.selection import set_tests
from w2w.core.selection.joint import choose_together
from w2w.core.selection.set_tests import SetTests

from ...rings import by_day
from .made_sets import CLIPS, NAMES, N, alone, library, terms

SUBJECTS = {"clips": None, "four": 4, "three": 3}


@pytest.fixture(scope="module", params=by_day(["clips", "three"], SUBJECTS))
def asked(request):
    """A library, with clips or subjects left out."""
    features, names, clip = library()
    count = SUBJECTS[request.param]
    subject = None if count is None else np.array(list("abcd"))[clip % CLIPS % count]
    return features, CrossValidation(names, clip, subject, np.ones(len(clip), dtype=bool), NAMES, 3)


@pytest.fixture(scope="module")
def utility(asked):
    return utility_map(*asked, resamples=20)


def test_each_half_has_the_map_that_the_ranking_made_of_it(asked, utility, monkeypatch):
    known = SetTests.of(*asked, Pooling.none(N), utility=utility)
    anew = SetTests.of(*asked, Pooling.none(N))
    assert len(known.pairs) == (2 if known.plan.disjoint else 3)
    for pair, pair_anew in zip(known.pairs, anew.pairs, strict=True):
        for half, half_anew in zip(pair, pair_anew, strict=True):
            # by the same clips, but each fold of the ranking has a ridge of its own
            assert np.corrcoef(half.single, half_anew.single)[0, 1] > 0.9
            f1, f1_anew = (one.alone[half.trial.testable].mean(axis=1) for one in (half, half_anew))
            np.testing.assert_allclose(f1, f1_anew, atol=0.1)
    monkeypatch.setattr(JointScores, "of_added", None)
    assert known.pairs[0][0].single.shape == (N,)


def test_sets_are_chosen_by_the_known_maps_on_fewer_windows_too(asked, utility, monkeypatch):
    monkeypatch.setattr(set_tests, "MOST_WINDOWS", 48)
    known = SetTests.of(*asked, Pooling.none(N), utility=utility)
    chosen = choose_together(known, alone(known), terms(3), target=1.0)
    assert chosen.promise.known
    halves = maps_of(utility.trial_f1, asked[1].plan().plan)
    for pair, of_pair in zip(known.pairs, halves, strict=False):
        for half, f1 in zip(pair, of_pair, strict=True):
            np.testing.assert_array_equal(half.alone, f1.astype(np.float32))


def test_a_file_keeps_what_halves_said_and_may_lack_it(utility, tmp_path):
    utility.save(tmp_path / "u.npz")
    again = UtilityMap.load(tmp_path / "u.npz")
    np.testing.assert_array_equal(again.trial_f1, utility.trial_f1)


def test_a_ranking_without_halves_has_none(asked):
    utility = utility_map(*asked, resamples=20, halvings=0)
    assert utility.trial_f1 is None
    tests = SetTests.of(*asked, Pooling.none(N), utility=utility)
    assert np.isfinite(tests.pairs[0][0].single).all()


def test_the_worst_activity_decides_where_every_one_is_asked_for(asked, utility):
    half = SetTests.of(*asked, Pooling.none(N), utility=utility).pairs[0][0]
    candidates, weights = np.arange(N), half.weights
    worst = half.added((), candidates, worst=True)
    each = []
    for activity in range(len(weights)):
        alone = replace(half, weights=np.eye(len(weights))[activity])
        each.append(alone.added((), candidates, worst=False))
    np.testing.assert_allclose(worst, np.min(each, axis=0))
    assert (np.ptp(each, axis=0) > 0.01).any()
