# SPDX-License-Identifier: GPL-3.0-or-later
"""A study and its results folder, in a real window: run inside Blender by `test_study_folder.py`.

Environment: W2W_ZIP the extension, W2W_RUN the results folder, which is moved about, W2W_OUT where the report
and pictures go.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import OUT, idle, install, module, open_tab, play, report, study

RUN = Path(os.environ["W2W_RUN"])
PLACES = OUT / "places"


def state() -> dict[str, object]:
    """How the study stands to its signals and its ranking."""
    module("study.signal_cache")._recordings.clear()
    clips = [clip for clip in study().clips if clip.action is not None]
    return {
        "signals": sum(module("study.signal_cache").has(clip) for clip in clips),
        "read": sum(module("study.signal_cache").recording(clip) is not None for clip in clips),
        "to_bake": len(module("steps.baking").to_bake(study())),
        "is_ranked": study().ranked_as == module("study.state").rank_settings(study()),
        "sensor": study().sensor,
        "folder": study().results_folder,
        "heatmaps": len(bpy.context.scene.w2w.body.data.color_attributes),
        "has_ranking": module("study.state").utility_of(study()) is not None,
    }


def open_blend(driver: Driver, path: Path) -> Script:
    """Open a file and show the panel."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(path))
    yield from driver.turns(10)
    yield from open_tab(driver)


def begin(driver: Driver) -> Script:
    """Open the run's file where the run left it."""
    install()
    shutil.rmtree(PLACES, ignore_errors=True)
    PLACES.mkdir()
    yield from open_blend(driver, RUN / "study.blend")
    report["opened"] = state()


def undo(driver: Driver) -> Script:
    """Bake and rank with another sensor, then take all of it back."""
    study().sensor = "watch"
    with driver.in_view():
        bpy.ops.ed.undo_push(message="Sensor")
        bpy.ops.w2w.bake_signals("INVOKE_DEFAULT")
    yield from idle(driver)
    with driver.in_view():
        bpy.ops.w2w.rank_patches("INVOKE_DEFAULT")
    yield from idle(driver)
    report["other_sensor"] = state()
    for name in ("ranking_undone", "baking_undone", "sensor_undone"):
        yield from driver.key("Z", ctrl=True)
        yield from driver.turns(10)
        report[name] = state()
    for _ in range(3):
        yield from driver.key("Z", ctrl=True, shift=True)
        yield from driver.turns(10)
    report["redone"] = state()


def save_as(driver: Driver) -> Script:
    """Save the run's file beside its folder, move both together, and open it there."""
    yield from open_blend(driver, RUN / "study.blend")
    together = PLACES / "together"
    shutil.copytree(RUN, together / "results")
    yield from open_blend(driver, together / "results" / "study.blend")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_as_mainfile(filepath=str(together / "mine.blend"))
    together.rename(PLACES / "elsewhere")
    yield from open_blend(driver, PLACES / "elsewhere" / "mine.blend")
    report["both_moved"] = state()
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_as_mainfile(filepath=str(PLACES / "mine.blend"))
    yield from open_blend(driver, PLACES / "mine.blend")
    report["saved_as"] = state()


def locate(driver: Driver) -> Script:
    """Move the results folder away and open the file: the panel says so; press Locate Results."""
    (PLACES / "elsewhere" / "results").rename(PLACES / "moved")
    yield from open_blend(driver, PLACES / "mine.blend")
    yield from driver.look_from_the_front()
    report["lost"] = state()
    x, y = yield from driver.reach("w2w.locate_results")
    yield from driver.look("1_lost")
    yield from driver.click(x, y)
    yield from driver.choose_folder(PLACES / "moved")
    yield from driver.turns(20)
    yield from driver.look("2_located")
    report["located"] = state() | {"message": module("jobs.jobs").message.text}
    yield from driver.key("Z", ctrl=True)
    yield from driver.turns(10)
    report["locating_undone"] = state()
    yield from driver.key("Z", ctrl=True, shift=True)
    yield from driver.turns(10)
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_mainfile()
    yield from open_blend(driver, PLACES / "mine.blend")
    report["located_and_opened"] = state()


def alone(driver: Driver) -> Script:
    """Open a copy of the file on a machine that has no results folder, then bake there."""
    (PLACES / "machine").mkdir()
    shutil.move(PLACES / "mine.blend", PLACES / "machine" / "mine.blend")
    (PLACES / "moved").rename(PLACES / "left")
    yield from open_blend(driver, PLACES / "machine" / "mine.blend")
    report["alone"] = state()
    yield from driver.look_from_the_front()
    yield from driver.look("3_alone")
    with driver.in_view():
        bpy.ops.w2w.bake_signals("INVOKE_DEFAULT")
    yield from idle(driver)
    report["baked_alone"] = state()


def save_results(driver: Driver) -> Script:
    """Save what was baked as a folder: the study works there; undo leads back to the cache."""
    with driver.in_view():
        bpy.ops.w2w.rank_patches("INVOKE_DEFAULT")
    yield from idle(driver)
    with driver.in_view():
        bpy.ops.w2w.save_results(directory=str(PLACES / "saved"))
    yield from idle(driver)
    report["saved"] = state()
    yield from driver.look("4_saved")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_as_mainfile(filepath=str(PLACES / "saved.blend"))
    yield from driver.key("Z", ctrl=True)
    yield from driver.turns(10)
    report["saving_undone"] = state()
    bpy.ops.w2w.clear_cache()
    yield from open_blend(driver, PLACES / "saved.blend")
    report["opened_without_cache"] = state()


play(begin, undo, save_as, locate, alone, save_results)
