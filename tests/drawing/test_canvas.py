# SPDX-License-Identifier: GPL-3.0-or-later
"""Words on a canvas are cut where they have no room."""

from w2w.drawing.canvas import clipped

from .made_canvas import NotingCanvas


def test_words_are_cut_where_they_have_no_room():
    canvas = NotingCanvas()  # a letter of size 10 is 5 wide
    assert clipped(canvas, "left wrist", 50, 10) == "left wrist"
    assert clipped(canvas, "left wrist", 49, 10) == "left wri…"
    assert clipped(canvas, "left wrist", 30, 10) == "left…"
    assert clipped(canvas, "left wrist", 0, 10) == "…"
