# SPDX-License-Identifier: GPL-3.0-or-later
"""From an empty tab to an answer by one button, then a click on the body: run by `test_try_examples.py`.

Environment: W2W_ZIP the extension, W2W_OUT where the report and the pictures go.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import idle, install, module, open_tab, play, report, study, to_page


def try_it(driver: Driver) -> Script:
    """Press the first button of the empty tab, in Blender's own first scene."""
    install()
    yield from open_tab(driver)
    yield from driver.look("0_empty")
    yield from driver.press("w2w.try_examples")
    yield from driver.turns(60)
    yield from driver.look("1_running")
    yield from idle(driver)
    yield from driver.turns(30)
    yield from driver.look("2_answer")
    report["clips"] = len(study().clips)
    report["page"] = module("study.pages").shown_page()
    report["patch"] = module("study.lists").answer_of(study())["patch"]


def click_the_body(driver: Driver) -> Script:
    """Click the body as the scene's tool is; Esc looks away, a click beside the body is Blender's own."""
    middle = body_point(driver, 0.73)
    yield from driver.click(*middle)
    yield from driver.turns(10)
    report["picked"] = study().picked
    yield from driver.look("3_card")
    yield from driver.key("ESC")
    report["picked_after_esc"] = study().picked
    yield from driver.click(middle[0] - 200, middle[1])
    report["picked_beside"] = study().picked


def body_point(driver: Driver, share: float) -> tuple[int, int]:
    """Where a point in the middle of the body is in the window, at a share of its height."""
    low, high = module("viewport.framing").extent([bpy.context.scene.w2w.body])
    return driver.on_screen(((low[0] + high[0]) / 2, low[1], low[2] + share * (high[2] - low[2])))


def other_pages(driver: Driver) -> Script:
    """Look at the other two pages; another tab keeps clicks to Blender."""
    for name in ("Clips", "Details"):
        yield from to_page(driver, name)
        yield from driver.look(f"4_{name.lower()}")
    driver.region("UI").active_panel_category = "View"
    yield from driver.turns(10)
    yield from driver.click(*body_point(driver, 0.73))
    report["picked_in_another_tab"] = study().picked


play(try_it, click_the_body, other_pages)
