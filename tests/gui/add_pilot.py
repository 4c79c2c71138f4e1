# SPDX-License-Identifier: GPL-3.0-or-later
"""A pilot from the panel by mouse, saved and opened again: run inside Blender by `test_pilot_window.py`.

Environment: W2W_ZIP the extension, W2W_RUN the results folder, W2W_WORN recordings of people, W2W_OUT where
the report and pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import OUT, idle, install, module, open_tab, play, report, study, to_page

RUN, WORN = Path(os.environ["W2W_RUN"]), Path(os.environ["W2W_WORN"])
SAVED = OUT / "saved"


def pilot() -> dict[str, object] | None:
    """What the panel keeps of a pilot."""
    return (module("study.lists").advice_of(study()) or {}).get("pilot")


def begin(driver: Driver) -> Script:
    """Open the run's file: it has no pilot."""
    install()
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    yield from open_tab(driver)
    yield from to_page(driver, "Answer")
    yield from driver.open_panel_below("w2w.export_presentation")
    report["before"] = pilot()


def add(driver: Driver) -> Script:
    """Press Add a Pilot, choose the folder in the file browser, and wait."""
    yield from driver.press("w2w.add_pilot")
    yield from driver.choose_folder(WORN)
    yield from idle(driver)
    report["added"] = pilot()
    yield from driver.reach("w2w.add_pilot")
    yield from driver.look("1_pilot")


def save_and_open(driver: Driver) -> Script:
    """Save Results, then open them in an empty scene."""
    with driver.in_view():
        bpy.ops.w2w.save_results(directory=str(SAVED))
    yield from idle(driver)
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.read_homefile(use_empty=False)
    yield from driver.turns(10)
    with driver.in_view():
        bpy.ops.w2w.open_results(filepath=str(SAVED))
    yield from idle(driver)
    yield from open_tab(driver)
    yield from to_page(driver, "Answer")
    yield from driver.open_panel_below("w2w.export_presentation")
    report["opened"] = pilot()
    yield from driver.reach("w2w.add_pilot")
    yield from driver.look("2_opened")


play(begin, add, save_and_open)
