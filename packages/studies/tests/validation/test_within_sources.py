# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities compared within their source: the source is no help, and no performer is seen before."""

import numpy as np
import pytest

from w2w_studies.validation.across_sources import between_sources
from w2w_studies.validation.within_sources import rank_within_sources

from .mixed_library import APART, GOOD, PATCHES, windows


def test_the_source_raises_no_score():
    """Noise alone: two sources told apart make F1 .5 of nothing; within a source it is chance."""
    made = windows(APART, source_shift=6.0, signal=0.0, performers=6)
    within = rank_within_sources(made)
    assert within.activities == ("a", "b", "c", "d")
    assert within.sources_of("a") == ["film"]
    at_once = rank_within_sources(made.as_one_source())
    assert within.f1.mean() == pytest.approx(0.5, abs=0.08)  # two activities each: chance is a half
    assert at_once.f1.mean() > 0.4  # of four activities: chance would be a quarter
    assert at_once.f1.mean() < 0.6


def test_scores_are_means_over_the_sources_that_show_an_activity():
    made = windows({"film": ("a", "b", "c"), "lab": ("a", "b")})
    found = rank_within_sources(made)
    film, lab = found.parts["film"], found.parts["lab"]
    np.testing.assert_allclose(found.f1[:, 0], (film.f1[:, 0] + lab.f1[:, 0]) / 2, rtol=1e-6)
    np.testing.assert_allclose(found.f1[:, 2], film.f1[:, 2], rtol=1e-6)
    assert set(between_sources(found)) == {"a", "b"}
    assert found.expected[:GOOD].mean() > found.expected[GOOD:].mean()


def test_a_source_in_which_nothing_can_be_compared_is_left_out_with_the_reason():
    made = windows({"film": ("a", "b"), "lab": ("c",)})
    found = rank_within_sources(made)
    assert found.activities == ("a", "b")
    assert "two activities" in found.left_out["lab"]
    with pytest.raises(ValueError, match="lab: a ranking needs two activities"):
        rank_within_sources(made.some(made.source == "lab"))


def test_one_performer_is_never_trained_on_and_tested():
    """Each performer's own quirk names the activity: whoever knows the performer is always right."""
    made = windows({"film": ("a", "b")}, performers=6, clips=4, signal=0.0)
    features = made.inputs.array
    rng = np.random.default_rng(1)
    for who in np.unique(made.performer):
        for name in ("a", "b"):
            features[(made.performer == who) & (made.activity == name)] += 4 * rng.normal(
                size=(1, PATCHES, 8)
            )
    assert rank_within_sources(made).f1.mean() < 0.7


def test_a_map_without_one_source_is_that_of_the_others():
    found = rank_within_sources(windows({"film": ("a", "b", "c"), "lab": ("a", "b")}))
    less = found.without("film")
    assert less.activities == ("a", "b")
    np.testing.assert_array_equal(less.f1, found.parts["lab"].f1)
    assert less.without("lab") is None
