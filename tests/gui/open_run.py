# SPDX-License-Identifier: GPL-3.0-or-later
"""Open what a run left, in a real Blender window: run inside Blender by `test_open_run.py`.

Environment: W2W_ZIP the extension, W2W_RUN the results folder, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import curves, empty, install, longest_freeze, module, open_tab, play, report, study

RUN = Path(os.environ["W2W_RUN"])
OPENING_S = 120.0


def found() -> dict[str, object]:
    """What the panel shows of the run."""
    state = module("study.state")
    body = bpy.context.scene.w2w.body
    clips = [clip for clip in study().clips if clip.action is not None]
    return {
        "clips": len(clips),
        "baked": sum(module("study.signal_cache").has(clip) for clip in clips),
        "keys": len(frames(clips[0].action)),
        "patches": len(study().patch_collection.objects),
        "chosen": [place.patch for place in study().chosen],
        "regions": len(study().regions),
        "heatmaps": len(body.data.color_attributes),
        "up_to_date": study().ranked_as == state.rank_settings(study()),
        "message": module("jobs.jobs").message.text,
    }


def frames(action: bpy.types.Action) -> list[float]:
    """Times of the keys of an action."""
    return [
        point.co[0] for point in max(curves(action), key=lambda c: len(c.keyframe_points)).keyframe_points
    ]


def enable_late(driver: Driver) -> Script:
    """Open study.blend without the extension, then install it: the panel fills."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    install()
    yield from driver.until(lambda: bpy.context.scene.w2w.body is not None, 30)
    report["enabled_late"] = found()


def open_file(driver: Driver) -> Script:
    """Open study.blend; the panel shows the ranking."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    yield from open_tab(driver)
    yield from driver.turns(60)
    yield from driver.look("1_opened")
    report["outliner"] = driver.foot_of_outliner()
    report["opened"] = found()


def look_at_a_spot(driver: Driver) -> Script:
    """Scroll down to the table of sensor places, click the first row, play a clip."""
    yield from driver.look("2_ranking")
    yield from driver.open_panel_below("w2w.export_presentation")
    yield from driver.press("w2w.select_patch")
    report["picked"] = study().picked
    with driver.in_view():
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
    jobs = module("jobs.jobs")
    report["worn"] = [place.patch for place in study().worn]
    study().target = 0.99
    with driver.in_view():
        bpy.ops.w2w.choose_sensors("INVOKE_DEFAULT")
    yield from driver.turns(1)
    report["choosing"] = jobs.running is not None
    driver.photograph("4_choosing")
    yield from driver.key("ESC")
    yield from driver.turns(5)
    report["message_after_esc"] = jobs.message.text


def two_maps(driver: Driver) -> Script:
    """Press Side by Side, let an activity be background, press again."""
    yield from driver.scroll_sidebar_to_top()
    yield from driver.open_panel_with("show_overlay")
    yield from driver.press("w2w.side_by_side")
    yield from driver.until(lambda: study().beside is not None, 30)
    study().view, study().beside_view = "A1", "A2"
    yield from driver.look_from_the_front()
    with driver.in_view():
        bpy.ops.view3d.zoom(delta=-1)  # all of the scene is in view, but partly under the sidebar
    yield from driver.look("6_two_maps")
    legend = module("viewport.legend").legend(study(), module("study.state").utility_of(study()))
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
    empty(driver)
    yield from open_tab(driver)
    yield from driver.look("4_empty")
    module("jobs.jobs").message = None
    report["longest_freeze_while_opening"] = yield from longest_freeze(drop_and_wait(driver))
    yield from driver.turns(10)
    yield from driver.look_from_the_front()
    yield from driver.look("5_dropped")
    report["dropped"] = found()


def drop_and_wait(driver: Driver) -> Script:
    """Drop the summary, then wait for the job to end."""
    jobs, region = module("jobs.jobs"), driver.region("WINDOW")
    yield from driver.drop([RUN / "summary.json"], region.x + 200, region.y + 300)
    yield from driver.until(lambda: jobs.running is None and jobs.message is not None, OPENING_S)


play(
    enable_late,
    open_file,
    look_at_a_spot,
    undo,
    cancel_a_choice,
    two_maps,
    delete_body,
    drop_summary,
)
