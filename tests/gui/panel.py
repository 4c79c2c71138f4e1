# SPDX-License-Identifier: GPL-3.0-or-later
"""W2W's panel in Blender's window, for the scripts that drive it: its study, its jobs, what was found.

Environment: W2W_ZIP the extension, W2W_OUT where the report and the pictures go.
"""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from types import ModuleType

import bpy
from driver import Driver, Script, run

OUT = Path(os.environ["W2W_OUT"])
PACKAGE = "w2w"
JOB_S = 1800.0
"""The longest that a job may take on a busy machine; garments take longest."""

TABS = {"Clips": 0.2, "Answer": 0.5, "Details": 0.8}
"""Where across the sidebar the tabs stand."""

report: dict[str, object] = {}


def play(*steps: Callable[[Driver], Script]) -> None:
    """Run steps one after the other; write the report, with the seconds that each step took."""
    run(_played(steps))


def study() -> bpy.types.PropertyGroup:
    """The study; looked up anew each time, for undo replaces everything."""
    return bpy.context.scene.w2w.body.w2w


def module(name: str) -> ModuleType:
    """A module of the panel."""
    return sys.modules[f"{PACKAGE}.ui.{name}"]


def curves(action: bpy.types.Action) -> list[bpy.types.FCurve]:
    """All f-curves of an action, in any Blender."""
    slots = sys.modules[f"{PACKAGE}.scene.base.fcurves"].action_curves(action)
    return [curve for slot in slots for curve in slot]


def install() -> None:
    """Install the extension from its zip."""
    bpy.ops.extensions.package_install_files(
        filepath=os.environ["W2W_ZIP"], repo="user_default", enable_on_install=True
    )


def open_tab(driver: Driver) -> Script:
    """Show the panel in the sidebar."""
    driver.area.spaces.active.show_region_ui = True
    yield from driver.turns(5)
    driver.region("UI").active_panel_category = "W2W"
    yield from driver.turns(10)


def to_page(driver: Driver, name: str) -> Script:
    """Click a tab at the top of the panel."""
    yield from driver.scroll_sidebar_to_top()
    driver.seen.clear()  # a button further down turns pages, too
    x, y = yield from driver.reach("w2w_page", TABS[name])
    yield from driver.click(x, y)
    yield from driver.turns(20)


def empty(driver: Driver) -> None:
    """Remove all objects of the scene."""
    with bpy.context.temp_override(window=driver.window):
        bpy.data.batch_remove([*bpy.data.objects])
        bpy.ops.ed.undo_push(message="Empty")


def add_body_and_clips(driver: Driver, patches: int, folder: str) -> Script:
    """Install, add a body and a folder of motions, and look at the body from the front."""
    install()
    empty(driver)
    with driver.in_view():
        bpy.ops.w2w.add_body()
        bpy.ops.ed.undo_push(message="Body")
    yield from open_tab(driver)
    study().patch_count = patches
    with driver.in_view():
        bpy.ops.w2w.import_folder(directory=folder)
    yield from idle(driver)
    yield from driver.look_from_the_front()


def idle(driver: Driver) -> Script:
    """Wait until no job runs, and note what it said."""
    yield from driver.turns(5)
    yield from driver.until(lambda: module("jobs.jobs").running is None, JOB_S)
    yield from driver.turns(5)
    message = module("jobs.jobs").message
    report.setdefault("messages", []).append(message.text if message else "")


def longest_freeze(waiting: Script) -> Generator[None, None, tuple[float, str]]:
    """The longest time between two turns of the window while a script runs, and what the job was at then.

    Parameters
    ----------
    waiting : generator
        A script that does little itself.

    Returns
    -------
    seconds : float
    text : str
    """
    jobs = module("jobs.jobs")
    slowest, during = 0.0, ""
    for _ in waiting:
        text, begun = jobs.running.text if jobs.running else "", time.monotonic()
        yield
        if time.monotonic() - begun > slowest:
            slowest, during = time.monotonic() - begun, text
    return round(slowest, 3), during


def _played(steps: tuple[Callable[[Driver], Script], ...]) -> Script:
    driver = Driver(OUT / "pictures")
    seconds = report["seconds"] = {}
    for step in steps:
        begun, worked = time.monotonic(), time.process_time()
        yield from step(driver)
        took = time.monotonic() - begun, time.process_time() - worked
        seconds[step.__name__] = [round(part, 1) for part in took]
        print(f"{step.__name__}: {took[0]:.1f} s, {took[1]:.1f} s of a processor", flush=True)
    (OUT / "report.json").write_text(json.dumps(report, indent=2))
