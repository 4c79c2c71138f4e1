# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel Garments by clicking: run inside Blender by `test_garments_window.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder with a short motion, W2W_OUT where the report and
pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import FIELD, LAST, Driver, Script
from panel import TABS, add_body_and_clips, idle, longest_freeze, play, report, study, to_page

N_PATCHES = 64


def worn() -> list[str]:
    """Names of what is worn, the outer first."""
    return [row.item.name for row in study().covers]


def prepare(driver: Driver) -> Script:
    """Install the extension, add a body and a motion, open the panel under step 3."""
    yield from add_body_and_clips(driver, N_PATCHES, os.environ["W2W_CLIPS"])
    yield from to_page(driver, "Details")
    yield from driver.open_panel_below("w2w_page", TABS["Details"])
    yield from driver.open_panel_below("w2w.place_patches")
    yield from driver.look("1_closed_body")


def put_on_and_take_off(driver: Driver) -> Script:
    """Click both garments on, one off, and take that back."""
    yield from driver.press("tshirt")
    yield from driver.press("trousers", FIELD)
    yield from driver.turns(10)
    report["both"] = worn()
    shirt = study().covers[0].item
    report["modifiers"] = [modifier.type for modifier in shirt.modifiers]
    report["lies_on_body"] = bpy.context.scene.w2w.body.collision is not None
    yield from driver.look("2_both")
    yield from driver.press("w2w.take_off", LAST)
    counts = [worn()]
    for keys in ({"ctrl": True}, {"ctrl": True, "shift": True}, {"ctrl": True}):
        yield from driver.key("Z", **keys)
        yield from driver.turns(20)
        counts.append(worn())
    report["off_undo_redo_undo"] = counts
    yield from driver.press("index=1", LAST)
    report["after_taking_off"] = worn()
    report["in_the_scene"] = sorted(item.name for item in bpy.data.objects if item.type == "MESH")


def wear_own(driver: Driver) -> Script:
    """Wear a bag that hangs at a bone, then take it off: it stays in the scene."""
    body = bpy.context.scene.w2w.body
    bpy.ops.mesh.primitive_cube_add(size=0.12, location=(0.0, -0.2, 1.0))
    bag = bpy.context.object
    bag.name = "Bag"
    bag.parent, bag.parent_type, bag.parent_bone = body.parent, "BONE", "pelvis"
    bpy.ops.ed.undo_push(message="Bag")
    yield from driver.turns(10)
    yield from driver.press("w2w.wear_garment")
    report["with_bag"] = worn()
    yield from driver.look("3_bag")
    yield from driver.press("index=1", LAST)
    report["without_bag"] = [worn(), "Bag" in bpy.data.objects]
    bpy.data.objects.remove(bpy.data.objects["Bag"])


def bake(driver: Driver) -> Script:
    """Place patches and bake them, those under the T-shirt on the cloth."""
    yield from driver.scroll_sidebar_to_top()
    yield from driver.press("w2w.place_patches")
    yield from idle(driver)
    yield from driver.press("w2w.bake_signals")
    yield from driver.turns(60)
    yield from driver.look("4_baking")
    report["longest_freeze_seconds"] = yield from longest_freeze(idle(driver))
    report["baked"] = [(bool(clip.signals), clip.bake_path) for clip in study().clips]
    report["frame_after"] = bpy.context.scene.frame_current
    yield from driver.look("5_baked")


play(prepare, put_on_and_take_off, wear_own, bake)
