# SPDX-License-Identifier: GPL-3.0-or-later
"""A newcomer's two clicks in a real window: the example motions, and a spot of the body.

Needs what `test_window.py` needs, but for the real clips; skips where one is missing.
"""

from __future__ import annotations

from typing import Any

import pytest

from .sandbox import RESULTS, run_in_window

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    """What the window showed."""
    return run_in_window("try_examples.py", RESULTS / "try_examples", window=("1280", "800"))


def test_one_button_gives_an_answer_on_its_page(report: dict[str, Any]) -> None:
    assert report["clips"] == 40
    assert report["page"] == "ANSWER"
    assert report["patch"] is not None


def test_a_click_on_the_body_shows_a_spot_and_esc_looks_away(report: dict[str, Any]) -> None:
    assert report["picked"] >= 0
    assert report["picked_after_esc"] == -1


def test_clicks_beside_the_body_or_in_another_tab_are_blenders_own(report: dict[str, Any]) -> None:
    assert report["picked_beside"] == -1
    assert report["picked_in_another_tab"] == -1
