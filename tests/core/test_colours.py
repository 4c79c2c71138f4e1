# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of scores: in order for every eye, exact at the ends, honest about what is missing."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from w2w.core.colours import (
    COLOUR_MAPS,
    LEAST_SPAN,
    NEUTRAL_GREY,
    Scale,
    colour_table,
    score_colours,
    score_range,
    span_note,
)

COLOUR_BLINDNESS = {
    "protanopia": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopia": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopia": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}
"""Simulation matrices on linear RGB (Machado, Oliveira & Fernandes 2009, doi:10.1109/TVCG.2009.113)."""


def linear(colours):
    return np.where(colours <= 0.04045, colours / 12.92, ((colours + 0.055) / 1.055) ** 2.4)


def lightness(rgb):
    """CIE L* of linear RGB."""
    luminance = np.clip(rgb, 0, 1) @ (0.2126, 0.7152, 0.0722)
    return np.where(luminance > 0.008856, 116 * np.cbrt(luminance) - 16, 903.3 * luminance)


@pytest.mark.parametrize("blindness", [None, *COLOUR_BLINDNESS])
def test_higher_scores_are_lighter_for_every_eye(blindness):
    rgb = linear(colour_table())
    if blindness:
        rgb = rgb @ np.transpose(COLOUR_BLINDNESS[blindness])
    steps = np.diff(lightness(rgb)[::16])
    assert (steps > 0).all()
    # evenly: no stretch of scores looks flat and none like an edge
    assert steps.max() < 4 * np.median(steps)


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=30))
def test_colours_do_not_depend_on_shape_and_clip_at_the_ends(values):
    scores = np.array(values)
    colours = score_colours(scores, 0, 1)
    assert colours.shape == (len(values), 3)
    assert ((colours >= 0) & (colours <= 1)).all()
    np.testing.assert_array_equal(score_colours(scores[:, None], 0, 1)[:, 0], colours)
    np.testing.assert_array_equal(score_colours(np.clip(scores, 0, 1), 0, 1), colours)


def test_the_ends_have_the_map_s_end_colours():
    table = colour_table()
    np.testing.assert_allclose(score_colours([0.2, 0.9, 0.55], 0.2, 0.9), table[[0, -1, 512]], atol=0.003)
    np.testing.assert_allclose(score_colours([3.0, 7.0], 3, 7), table[[0, -1]])


def test_missing_scores_are_grey_and_leave_the_range_alone():
    colours = score_colours([0.2, np.nan, 0.9], 0.2, 0.9)
    np.testing.assert_array_equal(colours[1], NEUTRAL_GREY)
    np.testing.assert_array_equal(colours[[0, 2]], score_colours([0.2, 0.9], 0.2, 0.9))
    np.testing.assert_array_equal(score_colours(np.full(4, np.nan), 0, 1), np.tile(NEUTRAL_GREY, (4, 1)))
    assert score_range([np.nan, 0.3, 0.1]) == (0.1, 0.3)


def test_equal_scores_take_the_middle_colour():
    np.testing.assert_allclose(score_colours([0.7, 0.7], 0.7, 0.7), colour_table()[[512, 512]], atol=0.003)


@pytest.mark.parametrize(
    ("scores", "span", "ends"),
    [
        ([0.54, 0.56], LEAST_SPAN, (0.5, 0.6)),
        ([0.54, np.nan, 0.56], 0.4, (0.35, 0.75)),
        ([0.2, 0.9], LEAST_SPAN, (0.2, 0.9)),
        ([0.98, 1.0], LEAST_SPAN, (0.9, 1.0)),
        ([0.01], LEAST_SPAN, (0.0, 0.1)),
        ([0.3, 0.4], 1.0, (0.0, 1.0)),
        ([7.0, 7.0], LEAST_SPAN, (6.95, 7.05)),
    ],
)
def test_scores_that_hardly_differ_do_not_take_the_whole_colour_map(scores, span, ends):
    assert score_range(scores, span) == pytest.approx(ends)
    colours = score_colours(scores, *score_range(scores, span))
    shares = (np.array(scores) - ends[0]) / (ends[1] - ends[0])
    np.testing.assert_allclose(colours[0], colour_table()[round(1023 * shares[0])], atol=0.01)


def test_the_legend_says_where_scores_lie_that_do_not_fill_the_colours():
    assert span_note([0.541, np.nan, 0.562], *score_range([0.541, 0.562])) == "scores 0.54 to 0.56"
    assert span_note([0.2, 0.9], *score_range([0.2, 0.9])) == ""
    assert span_note([np.nan], *score_range([np.nan])) == ""


@pytest.mark.parametrize(("low", "high"), [(0.9, 0.2), (np.nan, 1), (0, np.inf)])
def test_a_range_that_is_none_is_refused(low, high):
    with pytest.raises(ValueError, match="colour range must run"):
        score_colours([0.5], low, high)


@pytest.mark.parametrize("name", COLOUR_MAPS)
def test_a_colour_map_is_the_published_one(name):
    published = pytest.importorskip("cmap").Colormap(name)
    np.testing.assert_allclose(colour_table(name, 500), published(np.linspace(0, 1, 500))[:, :3], atol=1e-12)


def test_an_unknown_colour_map_is_named_and_so_are_those_that_exist():
    with pytest.raises(ValueError, match="no colour map is called 'jet'; there are viridis, cividis"):
        colour_table("jet")


def test_places_are_alike_within_a_span_that_is_less_where_they_differ():
    scores = np.array([0.5, 0.57])
    differ, alike = (Scale.of_places(scores, "F1", "viridis", differ) for differ in (True, False))
    assert (differ.is_alike, alike.is_alike) == (False, True)
    assert alike.note == "Places are alike: 0.50 to 0.57"
    assert (alike.low, alike.high) == (differ.low, differ.high)
