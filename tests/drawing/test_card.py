# SPDX-License-Identifier: GPL-3.0-or-later
"""Cards of two patches that are compared can be compared."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.colours import Scale
from w2w.core.imu.recording import ImuRecording
from w2w.drawing.card import HoverCard, on_one_scale
from w2w.drawing.colour_bar import Legend, sizes
from w2w.drawing.places import Box, FreeArea, Place, place_all

from .made_canvas import NotingCanvas

LEGEND = 130.0
"""Width of a legend at a scale of 1, pixels."""


def card(recording: ImuRecording | None, patch: int) -> HoverCard:
    return HoverCard(
        "A", (1, 1, 1, 1), "wrist", (), (), np.zeros(0), Scale(0.0, 1.0), recording, patch, "", 0.0
    )


def test_plots_of_two_patches_share_their_scales() -> None:
    acc = np.zeros((50, 2, 3), dtype=np.float32)
    acc[20, 0, 1], acc[30, 1, 2] = 8.0, -41.0
    gyr = np.full_like(acc, 0.2)
    gyr[5, 0, 0] = 2.5
    recording = ImuRecording(acc, gyr, 60.0, ("wrist", "ankle"))
    quiet, lively = on_one_scale([card(recording, 0), card(recording, 1)])
    assert quiet.limits == lively.limits == ((-50.0, 50.0), (-3.0, 3.0))
    (alone,) = on_one_scale([card(recording, 0)])
    assert alone.limits == ((-10.0, 10.0), (-3.0, 3.0))


def test_without_signals_there_is_nothing_to_share() -> None:
    assert on_one_scale([card(None, 0)])[0].limits == ()


BODY = np.concatenate(
    [
        np.column_stack([np.linspace(-0.5, 0.5, 60), np.full(60, 0.82)]),  # arms stretched out
        np.column_stack([np.zeros(60), np.linspace(0.003, 0.997, 60)]),
        np.column_stack([np.linspace(-0.1, 0.1, 30), np.full(30, 0.02)]),
    ]
)
"""A body in its rest pose, in its heights."""


@pytest.mark.parametrize("size", [(1800.0, 900.0), (700.0, 660.0), (560.0, 600.0)])
@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_cards_and_legend_stand_at_the_edges_over_no_body_nor_each_other(
    size: tuple[float, float], scale: float
) -> None:
    free = FreeArea(50.0, 50.0 + size[0], 20.0, 20.0 + size[1])
    body = BODY * 0.8 * size[1] + (50 + size[0] / 2, 20 + 0.1 * size[1])
    taken: list[Box] = []

    def at_the_edges(width: float, gap: float) -> list[float]:
        return [free.left + gap, free.right - gap - width]

    for forms in (card(None, 0).sizes(), [lambda scale: (LEGEND * scale, 230 * scale)]):
        (stand,) = place_all([forms], free, body, taken, scale, at_the_edges)
        box = stand.box(forms)
        assert not stand.covers
        assert stand.scale <= scale
        assert free.left <= box.left < box.right <= free.right
        assert free.bottom <= box.bottom < box.top <= free.top
        assert not any(box.holds(*spot) for spot in body)
        assert not any(box.holds(x, y) for each in taken for x in each[::2] for y in each[1::2])
        taken.append(box)


NARROW = FreeArea(118.0, 485.0, 0.0, 525.0)
"""What a window of 1280 x 800 leaves beside the sidebar at a scale of 2."""

AXES, BUTTONS = Box(285.0, 325.0, 485.0, 525.0), Box(389.0, 89.0, 485.0, 525.0)
"""Blender's own in it."""

STANDING = np.column_stack([np.tile((135.0, 275.0), 50), np.repeat(np.linspace(12, 500, 50), 2)])
SIGNALS = ImuRecording(np.zeros((50, 1, 3)), np.zeros((50, 1, 3)), 60.0, ("wrist",))


def at_narrow_edges(width: float, gap: float) -> list[float]:
    return [NARROW.left + gap, NARROW.right - gap - width]


@pytest.mark.parametrize("body", [BODY * (230.0, 260.0) + (253.0, 92.0), STANDING])
def test_in_a_view_as_narrow_as_at_scale_two_the_legend_lies_and_the_card_is_folded(body: np.ndarray) -> None:
    shown = Legend(0.17, 0.87, name="Mean of activities")
    for forms in (sizes(shown, NotingCanvas()), card(SIGNALS, 0).sizes()):
        (stand,) = place_all([forms], NARROW, body, [AXES, BUTTONS], 2.0, at_narrow_edges)
        assert (stand.form, stand.covers) == (1, 0)


def test_two_cards_that_would_cover_the_body_are_titles_one_above_the_other() -> None:
    body = BODY * (230.0, 260.0) + (253.0, 92.0)
    two = [card(SIGNALS, 0).sizes()] * 2
    stands = place_all(two, NARROW, body, [AXES, BUTTONS], 2.0, at_narrow_edges)
    assert [(stand.form, stand.covers) for stand in stands] == [(2, 0), (2, 0)]
    assert min(stand.scale for stand in stands) >= 1.2
    below, above = (stand.box(forms) for stand, forms in zip(stands, two, strict=True))
    assert below.top < above.bottom
    wide = FreeArea(50.0, 1850.0, 20.0, 920.0)
    alone = place_all(
        two, wide, BODY * 720 + (950, 110), [], 2.0, lambda width, gap: [50 + gap, 1850 - gap - width]
    )
    assert [stand.form for stand in alone] == [0, 0]


@pytest.mark.parametrize("form", [0, 1, 2])
@pytest.mark.parametrize("is_baked", [True, False])
def test_all_of_a_card_is_drawn_inside_it(form: int, is_baked: bool) -> None:
    canvas = NotingCanvas()
    recording = ImuRecording(np.ones((50, 1, 3)), np.ones((50, 1, 3)), 60.0, ("wrist",)) if is_baked else None
    about = replace(
        card(recording, 0), lines=("expected F1 .62", "rank 3 of 512"), activities=("bow", "run"),
        f1=np.array([0.4, 0.9]), clip="bow: a clip", score="0.62", title="right wrist " * 9,
    )  # fmt: skip
    stand = Place(100.0, 50.0, 0.8, form)
    on_one_scale([about])[0].draw(stand, canvas)
    box = about.boxes(stand)[0]
    assert canvas.drawn
    assert all(box.holds(*each[:2]) and box.holds(*each[2:]) for each in canvas.drawn)


def test_a_card_is_closed_by_its_corner() -> None:
    shown = card(None, 0)
    width, height = shown.sizes()[0](1.5)
    whole, corner = shown.boxes(Place(100.0, 200.0, 1.5))
    assert whole == (100, 200, 100 + width, 200 + height)
    assert corner.holds(100 + width - 5, 200 + height - 5)
    assert not corner.holds(100 + width / 2, 200 + height - 5)
