# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All and a placement of one's own, by clicking: run inside Blender by `test_run_all_window.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import add_body_and_clips, idle, longest_freeze, module, play, report, study, to_page

N_PATCHES = 512
BAKED_FIRST = 3


def baked() -> int:
    """How many clips are baked."""
    return sum(bool(clip.signals) for clip in study().clips)


def prepare(driver: Driver) -> Script:
    """Install the extension, add a body, import the clips."""
    yield from add_body_and_clips(driver, N_PATCHES, os.environ["W2W_CLIPS"])
    report["clips"] = len(study().clips)
    yield from driver.look("1_imported")


def stop_and_go_on(driver: Driver) -> Script:
    """Press Run All, Esc after some clips, and Run All again."""
    yield from driver.press("w2w.run_all")
    yield from driver.until(lambda: baked() >= BAKED_FIRST, 300)
    yield from driver.key("ESC")
    yield from idle(driver)
    report["baked_after_esc"] = baked()
    keys = [clip.signals for clip in study().clips]
    yield from driver.look("2_stopped")
    yield from driver.press("w2w.run_all")
    yield from driver.look("3_going_on")
    report["longest_freeze_seconds"] = yield from longest_freeze(idle(driver))
    report["kept"] = sum(clip.signals in filter(None, keys) for clip in study().clips)
    report["baked"] = baked()
    report["worn"] = len(study().worn)
    yield from driver.look("4_done")
    yield from driver.key("Z", ctrl=True)
    report["baked_after_undo"] = baked()
    yield from driver.key("Z", ctrl=True, shift=True)


def name_a_spot(driver: Driver) -> Script:
    """Click the chest, name the spot, run all again, look at its row."""
    yield from driver.key("W", ctrl=True, alt=True)
    x, y = driver.on_screen((0.0, -0.1, 1.25))
    yield from driver.click(x, y)
    report["clicked"] = study().picked_vertex
    with driver.in_view():
        bpy.ops.w2w.add_placement("INVOKE_DEFAULT")
    yield from driver.turns(10)
    yield from driver.look("5_naming")
    yield from driver.key("RET")
    yield from driver.turns(10)
    report["own"] = {own.name: own.vertex for own in study().own}
    yield from to_page(driver, "Clips")
    yield from driver.press("w2w.run_all")
    yield from idle(driver)
    body = bpy.context.scene.w2w.body
    report["scores"] = module("results.own_placements").scores_of_own(body, study().own[0])
    yield from driver.look("6_answer")


play(prepare, stop_and_go_on, name_a_spot)
