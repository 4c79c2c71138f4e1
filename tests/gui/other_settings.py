# SPDX-License-Identifier: GPL-3.0-or-later
"""What people set otherwise: themes, languages, scales, parts of sensors: run by `test_other_settings.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import FIELD, MIDDLE, Driver, Script
from panel import empty, idle, install, module, open_tab, play, report, study

N_PATCHES = 64


def prepare(driver: Driver) -> Script:
    """Install the extension, add a body."""
    install()
    empty(driver)
    with driver.in_view():
        bpy.ops.w2w.add_body()
        bpy.ops.ed.undo_push(message="Body")
    yield from open_tab(driver)
    study().patch_count = N_PATCHES


def cancel_an_import(driver: Driver) -> Script:
    """Esc in the middle of an import, then the whole import."""
    actions = len(bpy.data.actions)
    yield from choose_clips(driver)
    yield from driver.until(lambda: len(study().clips) >= 2)
    yield from driver.look("1_importing")
    yield from driver.key("ESC")
    yield from idle(driver)
    report["left_by_cancel"] = [len(study().clips), len(bpy.data.actions) - actions]
    yield from driver.look("1_cancelled")
    yield from driver.scroll_sidebar_to_top()
    yield from choose_clips(driver)
    yield from idle(driver)
    report["clips"] = len(study().clips)


def choose_clips(driver: Driver) -> Script:
    """Press Folder, choose the clips, accept their labels."""
    yield from driver.press("w2w.import_folder", MIDDLE)
    yield from driver.choose_folder(Path(os.environ["W2W_CLIPS"]))
    yield from driver.turns(30)
    yield from driver.key("RET")
    yield from driver.turns(3)


def look_at_patches(driver: Driver) -> Script:
    """Run all: the patches stay folded in the Outliner; shown, they have the colours of their scores."""
    yield from driver.press("w2w.run_all")
    yield from idle(driver)
    yield from driver.turns(60)
    (area,) = (area for area in driver.window.screen.areas if area.type == "OUTLINER")
    region = next(region for region in area.regions if region.type == "WINDOW")
    report["outliner"] = [region.x, driver.window.height - region.y]  # its lower left corner in a picture
    yield from driver.look("2_folded")
    study().show_patches = True
    yield from driver.look("2_patches")
    study().show_patches = False


def choose_a_part(driver: Driver) -> Script:
    """Choose one's own part from the menu of sensors, then a preset again."""
    report["sensors"] = []
    for letter in "OB":
        x, y = yield from driver.reach("w2w.sensor", FIELD)
        yield from driver.click(x, y)
        yield from driver.turns(20)
        yield from driver.look(f"3_menu_{letter}")
        yield from driver.event(letter, "PRESS", x, y)
        yield from driver.event(letter, "RELEASE", x, y)
        yield from driver.turns(20)
        report["sensors"].append([study().sensor, module("study.state").config_of(study()).sensor])
    yield from driver.look("3_part")


def light(driver: Driver) -> Script:
    """A light theme."""
    themes = Path(bpy.utils.preset_paths("interface_theme")[0])
    yield from driver.scroll_sidebar_to_top()
    with driver.in_view():
        bpy.ops.w2w.select_patch(patch=3)
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.script.execute_preset(
            filepath=str(themes / "Blender_Light.xml"), menu_idname="USERPREF_MT_interface_theme_presets"
        )
    yield from driver.look("4_light")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.preferences.reset_default_theme()
    yield from driver.turns(5)


def german(driver: Driver) -> Script:
    """Blender in German: the sidebar as in English."""
    view, region = bpy.context.preferences.view, driver.region("UI")
    top = driver.window.height - region.y - region.height
    report["sidebar"] = [region.x, top, region.width, region.height]
    for language in ("en_US", "de_DE"):
        view.language = language
        view.use_translate_interface = view.use_translate_tooltips = True
        yield from driver.turns(10)
        yield from driver.move(region.x - 200, region.y + 300)
        yield from driver.look(f"5_{language}")
    view.language = "en_US"
    yield from driver.turns(5)


def scales(driver: Driver) -> Script:
    """Larger and smaller, with a second window."""
    view = bpy.context.preferences.view
    view.ui_scale = 1.7
    yield from driver.scroll_sidebar_to_top()
    yield from driver.look("6_large")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.window_new_main()
    view.ui_scale = 0.7
    yield from driver.turns(30)
    driver.photograph("6_second_window")


play(prepare, cancel_an_import, look_at_patches, choose_a_part, light, german, scales)
