# SPDX-License-Identifier: GPL-3.0-or-later
"""Cards of two patches that are compared can be compared."""

from __future__ import annotations

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.ui.viewport.card import HoverCard, on_one_scale


def card(recording: ImuRecording | None, patch: int) -> HoverCard:
    return HoverCard(
        "A", (1, 1, 1, 1), "wrist", (), (), np.zeros(0), 0.0, 1.0, "viridis", recording, patch, "", 0.0
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
