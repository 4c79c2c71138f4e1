# SPDX-License-Identifier: GPL-3.0-or-later
"""The difference of two heatmaps: on the body and in its legend."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.colours import DIFFERENCE_MAP, LEAST_SPAN, NEUTRAL_GREY, Scale, colour_table
from w2w.scene import heatmap
from w2w.scene.base.body import painted_colours
from w2w.ui.jobs.jobs import views
from w2w.ui.study.lists import keep_answer
from w2w.ui.study.scores import own_scale, shown_scores
from w2w.ui.study.state import patches_of, utility_of
from w2w.ui.viewport import overlay
from w2w.ui.viewport.legend import legend, show_colours

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender")


def test_one_activity_minus_another_is_painted_about_none(library: Path) -> None:
    body = make_study(library)
    study, utility = body.w2w, utility_of(body.w2w)
    count = len(body.data.color_attributes)
    study.view, study.minus = "A1", "A3"
    difference = utility.expected_f1[:, 0] - utility.expected_f1[:, 2]
    np.testing.assert_array_equal(shown_scores(study, utility), difference)
    shown = legend(study, utility)
    first, third = utility.activities[0], utility.activities[2]
    assert (shown.name, shown.title) == (f"{first} minus {third}", "Difference of F1")
    assert shown.high == -shown.low == max(np.abs(difference).max(), LEAST_SPAN / 2)
    assert body.data.color_attributes.active_color.name == heatmap.DIFFERENCE
    assert len(body.data.color_attributes) == count + 1
    patch = int(difference.argmax())
    vertex = int(patches_of(body).vertices[patch])
    table = colour_table(DIFFERENCE_MAP)
    row = round((difference[patch] - shown.low) / (shown.high - shown.low) * (len(table) - 1))
    colour = body.data.color_attributes.active_color.data[vertex].color_srgb
    np.testing.assert_allclose(colour[:3], table[row], atol=0.02)


def test_the_difference_follows_what_is_shown_and_ticked_and_goes(library: Path) -> None:
    body = make_study(library)
    study, utility = body.w2w, utility_of(body.w2w)
    study.minus = "MEAN"
    assert not shown_scores(study, utility).any()
    assert (legend(study, utility).low, legend(study, utility).high) == (-LEAST_SPAN / 2, LEAST_SPAN / 2)
    study.view = "A2"
    expected = utility.expected_f1[:, 1] - utility.expected_mean
    np.testing.assert_allclose(shown_scores(study, utility), expected)
    study.minus = "NOTHING"
    assert heatmap.DIFFERENCE not in body.data.color_attributes
    assert body.data.color_attributes.active_color.name == f"Expected F1: {utility.activities[1]}"
    assert legend(study, utility).title == "Expected F1"
    study.minus = "A1"
    bpy.ops.w2w.remove_patches()
    assert len(heatmap.heatmap_names(body)) == 0


def test_differences_reach_as_far_to_both_sides() -> None:
    for values, reach in ((np.array([-0.3, 0.1, np.nan]), 0.3), (np.zeros(4), LEAST_SPAN / 2)):
        scale = Scale.of_difference(values)
        assert (scale.low, scale.high) == (-reach, reach)


def test_places_that_do_alike_are_shown_plain_and_said_so(library: Path) -> None:
    body = make_study(library)
    study, patches = body.w2w, patches_of(body)
    told = own_scale(study, np.linspace(0.2, 0.7, len(patches)))
    assert (told.low, told.high, told.is_alike) == (0.2, 0.7, False)
    flat = np.linspace(0.8, 0.8 + 0.4 * LEAST_SPAN, len(patches))
    alike = own_scale(study, flat)
    assert (alike.is_alike, alike.note) == (True, "Places are alike: 0.80 to 0.84")
    colours = alike.colours(patches, flat)
    np.testing.assert_array_equal(colours, np.broadcast_to(NEUTRAL_GREY, colours.shape))
    wider = np.linspace(0.8, 0.8 + 0.9 * LEAST_SPAN, len(patches))
    assert not own_scale(study, wider).is_alike
    keep_answer(study, {"sentence": "", "places_differ": False})
    assert own_scale(study, wider).is_alike


def test_a_body_without_a_map_is_a_mannequin_and_so_is_one_whose_places_do_alike(library: Path) -> None:
    bpy.ops.w2w.add_body()
    new = bpy.context.scene.w2w.body.data
    assert new.color_attributes.active_color.name == heatmap.MANNEQUIN
    assert [material.name for material in new.materials] == ["Heatmap"]
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    body = make_study(library)
    study, plain = body.w2w, painted_colours(body.data.color_attributes[heatmap.MANNEQUIN])
    assert body.data.color_attributes.active_color.name == heatmap.MEAN
    assert np.ptp(plain, axis=0).min() > 0.2
    patches, flat = patches_of(body), np.full(len(patches_of(body)), 0.8)
    alike = heatmap.map_colours(body, own_scale(study, flat), patches, flat)
    np.testing.assert_array_equal(alike, plain)
    bpy.ops.w2w.remove_patches()
    assert body.data.color_attributes.active_color.name == heatmap.MANNEQUIN


def test_a_view_that_opens_later_shows_the_colours_once(library: Path) -> None:
    make_study(library)
    space = views(bpy.context)[0].spaces.active
    overlay._known.clear()
    for is_due in (True, False):  # then people may turn them off
        space.shading.color_type = "MATERIAL"
        overlay._colour_new(space)
        assert bpy.app.timers.is_registered(show_colours) == is_due
        if is_due:
            bpy.app.timers.unregister(show_colours)
            show_colours()
            assert overlay.is_coloured(space.shading)
