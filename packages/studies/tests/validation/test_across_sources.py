# SPDX-License-Identifier: GPL-3.0-or-later
"""What is learned from some sources, tested on one that was never seen."""

import pytest

from w2w_studies.validation.across_sources import across_sources

from .mixed_library import APART, GOOD, windows


def test_one_source_is_left_out_at_a_time():
    made = windows({"film": ("a", "b", "c"), "lab": ("a", "b")}, source_shift=1.0)
    found = across_sources(made)
    assert found.unseen.activities == ("a", "b")  # c has one source
    assert found.unseen.protocol == "leave one of 2 subjects out"
    assert found.sources["a"] == {"film": 12, "lab": 12}
    with pytest.raises(ValueError, match="two activities"):
        across_sources(windows(APART))


def test_an_activity_that_each_source_shows_its_own_way_is_named_only_where_its_source_was_seen():
    made = windows({"film": ("a", "b"), "lab": ("a", "b")}, performers=6, signal=4.0)
    features, lab = made.inputs.array, made.source == "lab"
    features[lab, :GOOD, :2] = features[lab, :GOOD, 1::-1]  # the lab's a looks like the film's b
    found = across_sources(made)
    good = slice(0, GOOD)
    assert found.seen.mean[good].mean() > found.unseen.mean[good].mean() + 0.2
    assert found.unseen.mean[good].mean() < 0.3
