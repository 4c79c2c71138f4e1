# SPDX-License-Identifier: GPL-3.0-or-later
"""A legend of colours keeps to its box, upright and flat, and has the ends of its scale."""

from __future__ import annotations

import numpy as np
import pytest

from w2w.drawing.places import Box, Place
from w2w.ui.viewport import colour_bar
from w2w.ui.viewport.legend import Legend

from .drawn import drawn_on


@pytest.mark.parametrize("form", [0, 1])
@pytest.mark.parametrize("beside", ["run", ""])
@pytest.mark.parametrize("is_alike", [True, False])
def test_all_of_a_legend_is_drawn_inside_it(
    monkeypatch: pytest.MonkeyPatch, form: int, beside: str, is_alike: bool
) -> None:
    drawn = drawn_on(monkeypatch, colour_bar)
    shown = Legend(
        0.17, 0.87, is_alike=is_alike, note="out of date", name="Mean of activities", beside=beside
    )
    colour_bar.draw_colour_bar(shown, Place(100.0, 50.0, 0.8, form))
    box = Box(100.0, 50.0, *np.add((100, 50), colour_bar.sizes(shown)[form](0.8)))
    assert drawn
    assert all(box.holds(*each[:2]) and box.holds(*each[2:]) for each in drawn)


@pytest.mark.parametrize("form", [0, 1])
def test_a_legend_has_the_ends_of_its_scale_in_numbers(monkeypatch: pytest.MonkeyPatch, form: int) -> None:
    written: list[str] = []
    monkeypatch.setattr(colour_bar, "text", lambda *given: written.append(given[2]) or 0.0)
    for name in ("rectangle", "bar_of_colours"):
        monkeypatch.setattr(colour_bar, name, lambda *_: None)
    colour_bar.draw_colour_bar(Legend(0.17, 0.87, name="walk"), Place(0.0, 0.0, 1.0, form))
    assert {"0.17", "0.87", "walk"} <= set(written)
