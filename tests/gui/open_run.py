# SPDX-License-Identifier: GPL-3.0-or-later
"""Open what a run left, in a real Blender window: run inside Blender by `test_open_run.py`.

Environment: W2W_ZIP the extension, W2W_RUN the results folder, W2W_OUT where the report and pictures go.
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
RUN = Path(os.environ["W2W_RUN"])
UI = "bl_ext.user_default.w2w.blender_addon.w2w.ui"

report: dict[str, object] = {}


def scenario() -> Script:
    """The file of the run, then its folder dropped on another scene."""
    driver = Driver(OUT / "pictures")
    yield from enable_late(driver)
    yield from open_file(driver)
    yield from look_at_a_spot(driver)
    yield from undo(driver)
    yield from cancel_a_choice(driver)
    yield from two_maps(driver)
    yield from delete_body(driver)
    yield from drop_summary(driver)
    (OUT / "report.json").write_text(json.dumps(report, indent=2))


def study() -> bpy.types.PropertyGroup:
    """The study that the panel shows."""
    return bpy.context.scene.w2w.body.w2w


def found() -> dict[str, object]:
    """What the panel shows of the run."""
    state = sys.modules[f"{UI}.state"]
    body = bpy.context.scene.w2w.body
    clips = [clip for clip in study().clips if clip.action is not None]
    return {
        "clips": len(clips),
        "baked": sum(sys.modules[f"{UI}.signal_cache"].has(clip.signals) for clip in clips),
        "keys": len(frames(clips[0].action)),
        "patches": len(study().patch_collection.objects),
        "chosen": [place.patch for place in study().chosen],
        "regions": len(study().regions),
        "heatmaps": len(body.data.color_attributes),
        "up_to_date": study().ranked_as == state.rank_settings(study()),
        "message": sys.modules[f"{UI}.jobs"].message.text,
    }


def frames(action: bpy.types.Action) -> list[float]:
    """Times of the keys of an action."""
    curves = list(action.fcurves)
    return [point.co[0] for point in max(curves, key=lambda c: len(c.keyframe_points)).keyframe_points]


def enable_late(driver: Driver) -> Script:
    """Open study.blend without the extension, then install it: the panel fills."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["W2W_ZIP"], repo="user_default", enable_on_install=True
    )
    yield from driver.until(lambda: bpy.context.scene.w2w.body is not None, 30)
    report["enabled_late"] = found()


def open_file(driver: Driver) -> Script:
    """Open study.blend; the panel shows the ranking."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    driver.area.spaces.active.show_region_ui = True
    yield from driver.turns(5)
    driver.region("UI").active_panel_category = "W2W"
    yield from driver.turns(20)
    yield from driver.look("1_opened")
    report["opened"] = found()


def look_at_a_spot(driver: Driver) -> Script:
    """Scroll down to the table of sensor places, click the first row, play a clip."""
    yield from driver.scroll_sidebar(40)
    yield from driver.look("2_ranking")
    yield from driver.press("w2w.select_patch")
    report["picked"] = study().picked
    with bpy.context.temp_override(window=driver.window, area=driver.area, region=driver.region("WINDOW")):
        bpy.ops.w2w.preview_clip(index=0)
    bpy.context.scene.frame_set(40)
    yield from driver.turns(20)
    yield from driver.look("3_signals")


def undo(driver: Driver) -> Script:
    """Change the target and take it back: the study stays."""
    report["picked_before_undo"] = study().picked
    yield from driver.key("Z", ctrl=True)
    yield from driver.key("Z", ctrl=True)
    yield from driver.turns(10)
    body = bpy.context.scene.w2w.body
    report["clips_after_undo"] = -1 if body is None else len(body.w2w.clips)


def cancel_a_choice(driver: Driver) -> Script:
    """Ask for more than the run did, choose sensors anew, and cancel that."""
    jobs = sys.modules[f"{UI}.jobs"]
    report["worn"] = [place.patch for place in study().worn]
    study().target = 0.99
    with bpy.context.temp_override(window=driver.window, area=driver.area, region=driver.region("WINDOW")):
        bpy.ops.w2w.choose_sensors("INVOKE_DEFAULT")
    yield from driver.turns(10)
    report["choosing"] = jobs.running is not None
    yield from driver.look("4_choosing")
    yield from driver.key("ESC")
    yield from driver.turns(5)
    report["message_after_esc"] = jobs.message.text


def two_maps(driver: Driver) -> Script:
    """Press Side by Side, let an activity be background, press again."""
    yield from driver.scroll_sidebar_to_top()
    x, y = yield from driver.reach("w2w.side_by_side")
    yield from driver.click(x, y)
    yield from driver.until(lambda: study().beside is not None, 30)
    study().view, study().beside_view = "A1", "A2"
    yield from driver.key("NUMPAD_1")
    yield from driver.key("HOME")
    yield from driver.turns(30)
    yield from driver.look("6_two_maps")
    legend = sys.modules[f"{UI}.legend"].legend(study(), sys.modules[f"{UI}.state"].utility_of(study()))
    report["two_maps"] = [legend.name, legend.beside]
    before = study().regions[0].f1
    study().activities["walk_left"].part = "BACKGROUND"
    report["background_changes_the_table"] = study().regions[0].f1 != before
    yield from driver.turns(10)
    yield from driver.look("7_background")
    study().activities["walk_left"].part = "COUNTED"
    yield from driver.press("w2w.side_by_side")
    yield from driver.turns(10)
    report["beside_after_second_press"] = study().beside is not None


def delete_body(driver: Driver) -> Script:
    """Delete the body by its key: the patches go along; undo brings both back."""
    counts = [len(bpy.context.scene.objects)]
    bpy.ops.w2w.select_body()
    yield from driver.key("DEL")
    for keys in ({"ctrl": True}, {"ctrl": True, "shift": True}):
        yield from driver.turns(40)
        counts.append(len(bpy.context.scene.objects))
        yield from driver.key("Z", **keys)
    yield from driver.turns(40)
    report["objects_by_delete_undo_redo"] = [*counts, len(bpy.context.scene.objects)]


def drop_summary(driver: Driver) -> Script:
    """Drop summary.json on an empty scene."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    yield from driver.turns(10)
    bpy.data.batch_remove([*bpy.data.objects])
    driver.area.spaces.active.show_region_ui = True
    yield from driver.turns(5)
    driver.region("UI").active_panel_category = "W2W"
    yield from driver.turns(10)
    yield from driver.look("4_empty")
    jobs = sys.modules[f"{UI}.jobs"]
    jobs.message = None
    region = driver.region("WINDOW")
    slowest, last, start = 0.0, time.monotonic(), time.monotonic()
    for _ in until_opened(driver.drop([RUN / "summary.json"], region.x + 200, region.y + 300)):
        yield
        slowest, last = max(slowest, time.monotonic() - last), time.monotonic()
        if last - start > 120:
            raise TimeoutError("nothing was opened")
    report["longest_freeze_while_opening_seconds"] = round(slowest, 3)
    yield from driver.turns(10)
    yield from driver.key("NUMPAD_1")
    yield from driver.key("HOME")
    yield from driver.turns(30)
    yield from driver.look("5_dropped")
    report["dropped"] = found()


def until_opened(dropping: Script) -> Script:
    """Drop, then wait for the job to end."""
    jobs = sys.modules[f"{UI}.jobs"]
    yield from dropping
    while jobs.running is not None or jobs.message is None:
        yield


run(scenario())
