# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparisons of one source each make one of all activities, and show which side told sources apart."""

import numpy as np
import pytest

from w2w_studies.validation.by_source import merged, replaced_sides
from w2w_studies.validation.site_scores import SiteScores
from w2w_studies.validation.sites import compare_scores

SITES = ("wrist", "hip", "ankle", "chest")
HONEST = np.array([0.9, 0.6, 0.3, 0.5])


def scores(activities, f1):
    """Scores (S, A) with small errors."""
    f1 = np.broadcast_to(np.asarray(f1)[:, None], (len(SITES), len(activities)))
    rng = np.random.default_rng(0)
    samples, halves = (f1 + rng.normal(0, 0.01, (*shape, *f1.shape)) for shape in ((2000,), (2, 200)))
    return SiteScores(
        tuple(activities), f1.copy(), samples, halves, "people", 9, 30, 90, "ridge", "leave", {}
    )


def test_an_activity_of_two_parts_is_their_mean():
    found = merged([scores("ab", HONEST), scores("bc", HONEST - 0.2)], "abc")
    np.testing.assert_allclose(found.f1.T, [HONEST, HONEST - 0.1, HONEST - 0.2])
    assert found.samples.shape == (2000, 4, 3)
    with pytest.raises(ValueError, match="no part tested d"):
        merged([scores("ab", HONEST)], "abd")


def test_the_side_that_told_sources_apart_is_found():
    """Pooled, the simulated ankle names the source; source by source it cannot."""
    told = HONEST + np.array([0, 0.2, 0.65, 0])
    whole = compare_scores(scores("abcd", HONEST), scores("abcd", told), SITES)
    parts = [compare_scores(scores(names, HONEST), scores(names, HONEST), SITES) for names in ("ab", "cd")]
    found = replaced_sides(whole, parts)
    rho = [one.overall.spearman for one in found.values()]
    assert rho[0] < 0.5
    assert rho[1:3] == pytest.approx([1, 1])
    assert rho[3] == rho[0]
    assert found["simulated sensors source by source"].regret.lost == 0
    assert found["all sources at once, as in the test"].regret.lost == pytest.approx(0.6)
