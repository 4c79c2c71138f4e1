# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps of disjoint halves of the performers agree where there is a map, and not where there is none."""

import numpy as np
import pytest

from w2w_studies.validation.library_repeats import means_agree, repeats
from w2w_studies.validation.within_sources import rank_within_sources

from .mixed_library import APART, PATCHES, windows


@pytest.mark.slow
def test_halves_agree_where_there_is_a_map_and_not_where_there_is_none():
    shape = {"film": ("a", "b", "c"), "lab": ("a", "d")}
    real = repeats(windows(shape, performers=8, signal=1.5), halvings=3)
    assert real.mean.shape == (3,)
    assert real.mean.mean() > 0.6
    assert set(real.by_activity) == {"a", "b", "c", "d"}
    assert real.mean_by_activity > 0.4
    noise = repeats(windows(shape, performers=8, signal=0.0), halvings=3)
    assert noise.mean.mean() < 0.4
    assert noise.f1.mean() < real.f1.mean()


@pytest.mark.slow
def test_fewer_clips_repeat_less():
    made = windows({"film": ("a", "b", "c")}, performers=8, clips=6, signal=0.9)
    few, many = (repeats(made, halvings=4, clips=clips) for clips in (3, 20))
    assert few.f1.mean() < many.f1.mean()
    assert few.mean.mean() < many.mean.mean()


def test_performers_who_cannot_be_halved_give_no_number():
    found = repeats(windows(APART, performers=2), halvings=2)
    assert np.isnan(found.mean).all()


def test_the_mean_over_sources_gives_each_source_one_vote():
    """What three activities of one source say outvotes the other's two in the mean over activities alone."""
    made = windows({"film": ("a", "b", "c"), "lab": ("d", "e")}, performers=6)
    turned = windows({"film": ("a", "b", "c"), "lab": ("d", "e")}, performers=6, seed=1)
    lab = made.source == "lab"
    features = turned.inputs.array
    features[lab] = features[lab][:, ::-1]  # the lab's good patches are at the other end
    one, other = rank_within_sources(made), rank_within_sources(turned)
    both = means_agree(one, other)
    assert both.of_activities > both.of_sources
    film = means_agree(one.without("lab"), other.without("lab"))
    assert film.of_activities == pytest.approx(film.of_sources)
    assert film.of_sources > 0.5
    assert means_agree(one.without("film"), other.without("film")).of_sources < 0


@pytest.mark.slow
def test_halves_are_compared_again_without_each_source():
    found = repeats(windows({"film": ("a", "b"), "lab": ("c", "d")}, performers=8), halvings=2)
    assert set(found.left_out) == {"film", "lab"}
    assert all(len(pairs) == 2 for pairs in found.left_out.values())
    assert found.of_sources.shape == (2,)
    alone = repeats(windows({"film": ("a", "b")}, performers=8), halvings=2)
    assert alone.left_out == {}
    np.testing.assert_allclose(alone.mean, alone.of_sources)


def test_the_made_library_has_patches_that_tell_nothing():
    assert rank_within_sources(windows(APART)).f1.shape == (PATCHES, 4)
