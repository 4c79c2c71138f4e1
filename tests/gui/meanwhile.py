# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do besides, while W2W works and between its steps: run in Blender by `test_meanwhile.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import MIDDLE, Driver, Script
from panel import OUT, add_body_and_clips, idle, module, play, report, study, to_page

N_PATCHES = 128
EXTENSION = "bl_ext.user_default.w2w"
CLIPS = Path(os.environ["W2W_CLIPS"])
KEYED_AT, LATER = 24, 60
"""Frames a second of the scene when the clips are imported, and afterwards."""


def prepare(driver: Driver) -> Script:
    """Install the extension, add a body, import the clips."""
    bpy.context.scene.render.fps = KEYED_AT
    yield from add_body_and_clips(driver, N_PATCHES, str(CLIPS))


def other_frame_rate(driver: Driver) -> Script:
    """Bake, give the scene another frame rate, bake and preview again."""
    with driver.in_view():
        bpy.ops.w2w.place_patches()
    yield from idle(driver)
    report["signals"] = []
    for rate in (KEYED_AT, LATER):
        bpy.context.scene.render.fps = rate
        for clip in study().clips:
            clip.signals, clip.selected = "", True
        with driver.in_view():
            bpy.ops.w2w.bake_signals()
        yield from idle(driver)
        report["signals"].append([clip.signals for clip in study().clips])
        with driver.in_view():
            bpy.ops.w2w.preview_clip(index=0)
        report.setdefault("wrist", []).append([wrist(seconds) for seconds in (0.5, 1.0, 1.5)])
        report.setdefault("preview_seconds", []).append((bpy.context.scene.frame_preview_end - 1) / rate)
    bpy.ops.w2w.tick_clips(which="NONE")
    yield from driver.look("1_other_rate")


def wrist(seconds: float) -> list[float]:
    """Where the body's wrist is, so long after the clip's beginning."""
    scene, armature = bpy.context.scene, bpy.context.scene.w2w.body.parent
    frame = 1 + seconds * scene.render.fps
    scene.frame_set(int(frame), subframe=frame % 1)
    posed = armature.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [*posed.pose.bones["left_wrist"].head]


def second_window(driver: Driver) -> Script:
    """While Run All runs, press Tab and click in another main window; close that; start from another."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.window_new_main()
    yield from driver.turns(30)
    other = bpy.context.window_manager.windows[-1]
    bpy.ops.w2w.select_body()
    driver.photograph("2_two_windows")
    yield from start(driver, driver.window)
    modes = report["modes"] = []
    for _ in range(3):
        press(other, "TAB")
        yield from driver.turns(3)
        modes.append([module("jobs.jobs").running is not None, bpy.context.scene.w2w.body.mode])
    driver.photograph("2_running")
    yield from idle(driver)
    press(other, "MOUSEMOVE", "NOTHING")
    yield from driver.turns(30)
    driver.photograph("2_over")
    report["mode_afterwards"] = []
    for _ in range(2):
        press(other, "TAB")  # nothing holds it back any more
        yield from driver.turns(30)
        report["mode_afterwards"].append(bpy.context.scene.w2w.body.mode)


def close_windows(driver: Driver) -> Script:
    """Esc in another window; close one that a job runs beside; close one that a job was started in."""
    jobs = module("jobs.jobs")
    yield from start(driver, driver.window)
    press(bpy.context.window_manager.windows[-1], "ESC")
    yield from idle(driver)
    yield from start(driver, driver.window)
    close(bpy.context.window_manager.windows[-1])
    yield from driver.turns(3)
    report["goes_on"] = jobs.running is not None
    yield from idle(driver)
    report["baked_beside"] = sum(bool(clip.signals) for clip in study().clips)
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.window_new_main()
    yield from driver.turns(30)
    yield from start(driver, bpy.context.window_manager.windows[-1])
    close(bpy.context.window_manager.windows[-1])
    yield from idle(driver)
    yield from driver.look("3_closed")


def start(driver: Driver, window: bpy.types.Window) -> Script:
    """Start Run All in a window, with all of its work to do, and wait until it bakes."""
    for clip in study().clips:
        clip.signals = ""
    study().seed += 1  # or the ranking would be up to date
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    region = next(region for region in area.regions if region.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        bpy.ops.w2w.run_all("INVOKE_DEFAULT")
    yield from driver.until(lambda: any(clip.signals for clip in study().clips), 300)


def press(window: bpy.types.Window, kind: str, value: str = "PRESS") -> None:
    """An event in the middle of a window's 3D view."""
    area = next(area for area in window.screen.areas if area.type == "VIEW_3D")
    x, y = area.x + area.width // 2, area.y + area.height // 2
    window.event_simulate("MOUSEMOVE", "NOTHING", x=x, y=y)
    if value == "PRESS":
        window.event_simulate(kind, "PRESS", x=x, y=y)
        window.event_simulate(kind, "RELEASE", x=x, y=y)


def close(window: bpy.types.Window) -> None:
    """Close a window."""
    with bpy.context.temp_override(window=window):
        bpy.ops.wm.window_close()


def disable(driver: Driver) -> Script:
    """Disable the extension while Run All runs, and enable it again: all goes on."""
    yield from start(driver, driver.window)
    yield from driver.look("4_before")
    bpy.ops.preferences.addon_disable(module=EXTENSION)
    yield from driver.turns(30)
    bpy.ops.preferences.addon_enable(module=EXTENSION)
    yield from driver.turns(30)
    report["stuck"] = module("jobs.jobs").running is not None
    yield from driver.look("4_enabled")
    yield from start(driver, driver.window)
    yield from idle(driver)
    report["baked_again"] = sum(bool(clip.signals) for clip in study().clips)


def unlink(driver: Driver) -> Script:
    """Unlink the body's collection and link it again."""
    home, scene = bpy.context.scene.w2w.body.users_collection[0], bpy.context.scene
    counts = [len(bpy.data.objects)]
    scene.collection.children.unlink(home)
    yield from driver.turns(60)
    yield from driver.look("5_unlinked")
    counts.append(len(bpy.data.objects))
    scene.collection.children.link(home)
    yield from driver.turns(60)
    yield from driver.look("5_linked")
    report["objects_by_unlink_link"] = [*counts, len(bpy.data.objects)]
    report["works_again"] = bpy.ops.w2w.run_all.poll()


def labels(driver: Driver) -> Script:
    """Import a folder, edit its labels.csv, put another file into it, press Folder again."""
    folder = OUT / "labelled"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    files = sorted(CLIPS.rglob("*.bvh"))
    report["labels"] = []
    for number, activity in enumerate(("strolling", "marching")):
        for file in files[: 2 + number]:
            shutil.copy(file, folder)
        rows = [f"{file.name},{activity}" for file in files[: 2 + number]]
        (folder / "labels.csv").write_text("\n".join(["file,activity", *rows]))
        bpy.ops.w2w.tick_clips(which="ALL")
        bpy.ops.w2w.remove_clips()
        yield from to_page(driver, "Clips")
        yield from driver.press("w2w.import_folder", MIDDLE)
        yield from driver.choose_folder(folder)
        yield from driver.turns(30)
        yield from driver.look(f"6_labels_{number}")
        yield from driver.key("RET")
        yield from idle(driver)
        report["labels"].append([clip.activity for clip in study().clips])


def another_file(driver: Driver) -> Script:
    """Open another file while a job runs."""
    with driver.in_view():
        bpy.ops.w2w.import_folder(directory=str(CLIPS))
    yield from driver.turns(3)
    report["ran_when_opened"] = module("jobs.jobs").running is not None
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    yield from driver.turns(30)
    jobs = module("jobs.jobs")
    report["after_opening"] = [jobs.running is not None, jobs.message is not None]


play(prepare, other_frame_rate, second_window, close_windows, disable, unlink, labels, another_file)
