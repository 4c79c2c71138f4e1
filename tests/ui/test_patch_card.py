# SPDX-License-Identifier: GPL-3.0-or-later
"""Cards of two patches that are compared can be compared."""

from __future__ import annotations

import numpy as np
import pytest

from w2w.core.colours import Scale
from w2w.core.imu.recording import ImuRecording
from w2w.ui.viewport.card import WIDTH, HoverCard, on_one_scale
from w2w.ui.viewport.framing import FreeArea
from w2w.ui.viewport.overlay import fitting_scale, place_cards

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


@pytest.mark.parametrize("width", [2000.0, 1000.0, 700.0, 420.0])
@pytest.mark.parametrize("height", [900.0, 500.0, 300.0])
@pytest.mark.parametrize("scale", [1.0, 2.0])
def test_two_cards_are_drawn_whole_and_leave_the_legend_its_room(
    width: float, height: float, scale: float
) -> None:
    recording = ImuRecording(
        np.ones((50, 2, 3), np.float32), np.ones((50, 2, 3), np.float32), 60.0, ("a", "b")
    )
    cards, free = [card(recording, 0), card(recording, 1)], FreeArea(50.0, 50.0 + width, 20.0, 20.0 + height)
    fitting = fitting_scale(cards, LEGEND, free, scale)
    placed = place_cards(cards, free, fitting)
    assert len(placed) == 2
    right = max(x + WIDTH * fitting for _, x, _ in placed)
    top = max(y + shown.height(fitting) for shown, _, y in placed)
    assert right + LEGEND * fitting <= free.right
    assert top <= free.top


def test_a_legend_alone_is_as_large_as_the_window_says_or_fits() -> None:
    free = FreeArea(0.0, 300.0, 0.0, 800.0)
    assert fitting_scale([], LEGEND, free, 1.7) == 1.7
    assert 120 < LEGEND * fitting_scale([], LEGEND, free._replace(right=150.0), 1.7) < 130
