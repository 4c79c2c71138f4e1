# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities compared within their source: the source is no help, and halves share no performer."""

import numpy as np
import pytest

from w2w.core.ranking.inputs import ArrayBlocks
from w2w.core.validation.within_sources import (
    MixedWindows,
    across_sources,
    between_sources,
    rank_within_sources,
    repeats,
)

PATCHES, GOOD = 12, 4
"""Of so many patches the first few tell activities apart."""


def windows(activities_of, performers=4, clips=3, source_shift=0.0, signal=2.5, seed=0):
    """Each performer shows each activity of their source some times; sources differ by a shift."""
    rng = np.random.default_rng(seed)
    rows = [
        (activity, source, f"{source} {who}", f"{source} {who} {activity} {clip}")
        for source, activities in activities_of.items()
        for activity in activities
        for who in range(performers)
        for clip in range(clips)
    ]
    activity, source, performer, motion = np.array(rows).T
    features = rng.normal(size=(len(rows), PATCHES, 8)).astype(np.float32)
    for number, name in enumerate(np.unique(activity)):
        features[activity == name, :GOOD, number] += signal
    for number, name in enumerate(np.unique(source)):
        features[source == name, :, 6 + number] += source_shift
    return MixedWindows(ArrayBlocks(features), activity, motion, source, performer, np.ones(len(rows), bool))


APART = {"film": ("a", "b"), "lab": ("c", "d")}


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
    with pytest.raises(ValueError, match="lab: a utility map needs two activities"):
        rank_within_sources(made.part(made.source == "lab"))


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


def test_fewer_clips_repeat_less():
    made = windows({"film": ("a", "b", "c")}, performers=8, clips=6, signal=0.9)
    few, many = (repeats(made, halvings=4, clips=clips) for clips in (3, 20))
    assert few.f1.mean() < many.f1.mean()
    assert few.mean.mean() < many.mean.mean()


def test_performers_who_cannot_be_halved_give_no_number():
    found = repeats(windows(APART, performers=2), halvings=2)
    assert np.isnan(found.mean).all()


def test_one_source_is_left_out_at_a_time():
    made = windows({"film": ("a", "b", "c"), "lab": ("a", "b")}, source_shift=1.0)
    found = across_sources(made)
    assert found.activities == ("a", "b")  # c has one source
    assert found.protocol == "leave one of 2 subjects out"
    with pytest.raises(ValueError, match="two activities"):
        across_sources(windows(APART))
