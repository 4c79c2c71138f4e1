# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures for the listing, in a real Blender window: run inside Blender by `tools/make_listing.py`.

Environment: W2W_ZIP the extension, W2W_RUN the results folder, W2W_OUT where the pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import Driver, Script
from panel import install, module, open_tab, play, study

RUN = Path(os.environ["W2W_RUN"])


def answer(driver: Driver) -> Script:
    """The heatmap with the numbered sensors, and the answer in the panel."""
    install()
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(RUN / "study.blend"))
    yield from driver.turns(10)
    yield from open_tab(driver)
    yield from driver.look_from_the_front()
    yield from driver.scroll_sidebar(40)
    yield from driver.look("preview_1")


def spot(driver: Driver) -> Script:
    """A spot that was clicked in the table, a clip that plays, and the spot's signal."""
    yield from driver.press("w2w.select_patch")
    with driver.in_view():
        bpy.ops.w2w.preview_clip(index=0)
    bpy.context.scene.frame_set(40)
    yield from driver.turns(20)
    yield from driver.look("preview_2")


def two_maps(driver: Driver) -> Script:
    """Two activities beside each other."""
    yield from driver.scroll_sidebar_to_top()
    x, y = yield from driver.reach("w2w.side_by_side")
    yield from driver.click(x, y)
    yield from driver.until(lambda: study().beside is not None, 30)
    study().view, study().beside_view = "A1", "A2"
    module("jobs.jobs").message = None
    yield from driver.look_from_the_front()
    with driver.in_view():
        bpy.ops.view3d.zoom(delta=-1)
    yield from driver.look("preview_3")


play(answer, spot, two_maps)
