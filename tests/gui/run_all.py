# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All and a placement of one's own, by clicking: run inside Blender by `test_run_all_window.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import json
import os
import sys
import time
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script, run

OUT = Path(os.environ["W2W_OUT"])
UI = "bl_ext.user_default.w2w.blender_addon.w2w.ui"
N_PATCHES = 128
BAKED_FIRST = 3

report: dict[str, object] = {}


def scenario() -> Script:
    """From an empty scene to a ranked placement."""
    driver = Driver(OUT / "pictures")
    yield from prepare(driver)
    yield from stop_and_go_on(driver)
    yield from name_a_spot(driver)
    (OUT / "report.json").write_text(json.dumps(report, indent=2))


def study() -> bpy.types.PropertyGroup:
    """The study; looked up anew each time, for undo replaces everything."""
    return bpy.context.scene.w2w.body.w2w


def module(name: str) -> object:
    """A module of the extension's panel."""
    return sys.modules[f"{UI}.{name}"]


def baked() -> int:
    """How many clips are baked."""
    return sum(bool(clip.signals) for clip in study().clips)


def idle(driver: Driver) -> Script:
    """Wait until no job runs."""
    yield from driver.turns(5)
    yield from driver.until(lambda: module("jobs").running is None, 600)
    yield from driver.turns(5)
    report.setdefault("messages", []).append(module("jobs").message.text)


def prepare(driver: Driver) -> Script:
    """Install the extension, add a body, import the clips."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["W2W_ZIP"], repo="user_default", enable_on_install=True
    )
    with bpy.context.temp_override(window=driver.window):
        bpy.data.batch_remove([*bpy.data.objects])
        bpy.ops.w2w.add_body()
        bpy.ops.ed.undo_push(message="Body")
    driver.area.spaces.active.show_region_ui = True
    yield from driver.turns(5)
    driver.region("UI").active_panel_category = "W2W"
    study().patch_count = N_PATCHES
    with bpy.context.temp_override(window=driver.window, area=driver.area, region=driver.region("WINDOW")):
        bpy.ops.w2w.import_folder(directory=os.environ["W2W_CLIPS"])
    yield from idle(driver)
    report["clips"] = len(study().clips)
    yield from driver.key("NUMPAD_1")
    yield from driver.key("HOME")
    yield from driver.turns(30)
    yield from driver.look("1_imported")


def stop_and_go_on(driver: Driver) -> Script:
    """Press Run All, Esc after some clips, and Run All again."""
    yield from driver.press("w2w.run_all")
    yield from driver.until(lambda: baked() >= BAKED_FIRST, 300)
    yield from driver.look("2_baking")
    yield from driver.key("ESC")
    yield from idle(driver)
    report["baked_after_esc"] = baked()
    keys = [clip.signals for clip in study().clips]
    yield from driver.look("3_stopped")
    yield from driver.press("w2w.run_all")
    slowest, last, during = 0.0, time.monotonic(), ""
    while module("jobs").running is not None:
        during_now = module("jobs").running.text
        yield
        if time.monotonic() - last > slowest:
            slowest, during = time.monotonic() - last, during_now
        last = time.monotonic()
    report["longest_freeze_seconds"] = [round(slowest, 3), during]
    yield from idle(driver)
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
    with bpy.context.temp_override(window=driver.window, area=driver.area, region=driver.region("WINDOW")):
        bpy.ops.w2w.add_placement("INVOKE_DEFAULT")
    yield from driver.turns(10)
    yield from driver.look("5_naming")
    yield from driver.key("RET")
    yield from driver.turns(10)
    report["own"] = {own.name: own.vertex for own in study().own}
    yield from driver.scroll_sidebar_to_top()
    yield from driver.press("w2w.run_all")
    yield from idle(driver)
    body = bpy.context.scene.w2w.body
    report["scores"] = module("own_placements").scores_of_own(body, study().own[0])
    yield from driver.scroll_sidebar(6)
    yield from driver.look("6_ranked")
    yield from driver.scroll_sidebar(14)
    yield from driver.look("7_results")


run(scenario())
