# SPDX-License-Identifier: GPL-3.0-or-later
"""A legend of colours keeps to its box, upright and flat, and has the ends of its scale."""

import numpy as np
import pytest

from w2w.drawing.colour_bar import Legend, draw_colour_bar, sizes
from w2w.drawing.places import Box, Place

from .made_canvas import NotingCanvas


@pytest.mark.parametrize("form", [0, 1])
@pytest.mark.parametrize("beside", ["run", ""])
@pytest.mark.parametrize("is_alike", [True, False])
def test_all_of_a_legend_is_drawn_inside_it(form, beside, is_alike):
    canvas = NotingCanvas()
    shown = Legend(
        0.17, 0.87, is_alike=is_alike, note="out of date", name="Mean of activities", beside=beside
    )
    draw_colour_bar(shown, Place(100.0, 50.0, 0.8, form), canvas)
    box = Box(100.0, 50.0, *np.add((100, 50), sizes(shown, canvas)[form](0.8)))
    assert canvas.drawn
    assert all(box.holds(*each[:2]) and box.holds(*each[2:]) for each in canvas.drawn)


@pytest.mark.parametrize("form", [0, 1])
def test_a_legend_has_the_ends_of_its_scale_in_numbers(form):
    canvas = NotingCanvas()
    draw_colour_bar(Legend(0.17, 0.87, name="walk"), Place(0.0, 0.0, 1.0, form), canvas)
    assert {"0.17", "0.87", "walk"} <= set(canvas.written)
