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
from panel import OUT, empty, idle, install, module, open_tab, play, report, study, to_page

N_PATCHES = 64
EDGE, WIDER = 6, 200
"""Pixels from the sidebar's edge to where it is dragged, and how far."""

MENU = 20
"""Pixels from the buttons of a part's file to the menu of presets above."""

CHEST, THIGH = (0.0, -0.1, 1.25), (0.09, -0.05, 0.75)


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
    driver.photograph("1_importing")
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
    report["outliner"] = driver.foot_of_outliner()
    yield from driver.look("2_folded")
    study().show_patches = True
    yield from driver.look("2_patches")
    study().show_patches = False


def look_around(driver: Driver) -> Script:
    """Beside a wide sidebar, with another thing in local view, show two maps; then hide the badge."""
    sidebar, window, space = driver.region("UI"), driver.region("WINDOW"), driver.area.spaces.active
    narrow, y = sidebar.width, sidebar.y + sidebar.height // 2
    yield from driver.drag(sidebar.x + EDGE, y, -WIDER)
    report["widened"] = sidebar.width - narrow
    with driver.in_view():
        bpy.ops.mesh.primitive_cube_add(size=0.3, location=(3, 0, 0))
        bpy.ops.view3d.localview(frame_selected=False)
        bpy.ops.w2w.side_by_side()
    yield from driver.look("2_wide")
    body, framing, cube = bpy.context.scene.w2w.body, module("viewport.framing"), bpy.context.object
    free = framing.free_area(driver.area, window)
    shown = report["shown"] = []
    for item in (body, study().beside):
        low, high = framing.extent([item])
        spots = [driver.on_screen((x, 0.0, z)) for x in (low[0], high[0]) for z in (low[2], high[2])]
        middle = driver.on_screen((low + high) / 2)
        shown.append({"spots": spots, "middle": [middle[0], driver.window.height - middle[1]]})
    report["free"] = [
        window.x + free.left,
        window.x + free.right,
        window.y + free.bottom,
        window.y + free.top,
    ]
    with driver.in_view():
        bpy.ops.w2w.side_by_side()
        bpy.ops.view3d.localview(frame_selected=False)
        framing.frame_answer(body)
    yield from driver.turns(5)
    cube.hide_set(False)  # it was hidden for the map
    patches = module("study.state").patches_of(body)
    badge, viewer = study().chosen[0].patch, space.region_3d.view_matrix.inverted().translation
    spot = body.matrix_world @ body.data.vertices[int(patches.vertices[badge])].co
    sights = report["badge_in_sight"] = []
    for distance in (-0.5, 0.5):
        cube.location = spot + distance * (viewer - spot).normalized()
        yield from driver.turns(5)
        with driver.in_view():
            surface = module("viewport.drawing").Surface(bpy.context, body, patches)
            sights.append(surface.in_sight(badge))
    yield from driver.look("2_hidden_badge")
    bpy.data.objects.remove(cube)
    yield from driver.drag(sidebar.x + EDGE, y, WIDER)


def choose_a_part(driver: Driver) -> Script:
    """Choose one's own part from the menu of sensors, then a preset again."""
    yield from to_page(driver, "Details")
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


def edit_a_part(driver: Driver) -> Script:
    """Start a part from a preset, name it, type a figure, drag one and take that back, save it, load it."""
    yield from driver.open_panel_above("window_s")
    x, y = yield from driver.reach("w2w.load_sensor")
    yield from driver.click(x, y + MENU)
    yield from driver.turns(20)
    yield from driver.look("3_presets")
    yield from driver.event("X", "PRESS", x, y)  # of Xsens
    yield from driver.event("X", "RELEASE", x, y)
    yield from driver.turns(20)
    edited = report["edited"] = [figures()]
    yield from driver.fill_in("own_sensor_name", "wrist pod", FIELD)
    yield from driver.fill_in("acc_range", "4", MIDDLE)
    edited.append(figures())
    x, y = yield from driver.reach("acc_noise", MIDDLE)
    yield from driver.drag(x, y, 60)
    edited.append(figures())
    yield from driver.look("3_edited")
    yield from driver.key("Z", ctrl=True)
    edited.append(figures())
    yield from driver.press("w2w.save_sensor", FIELD)
    yield from driver.choose_folder(OUT)
    yield from driver.turns(20)
    report["saved"] = sorted(path.name for path in OUT.glob("wrist*"))
    study().sensor, study().own_sensor_text = "bmi270", ""
    yield from driver.press("w2w.load_sensor")
    yield from driver.choose_folder(OUT, report["saved"][0])
    yield from driver.turns(20)
    edited.append(figures())


def figures() -> list[object]:
    """Which sensor it is, its name, its range and its noise."""
    shown = study()
    return [shown.sensor, shown.own_sensor_name, round(shown.acc_range, 2), round(shown.acc_noise, 2)]


def tap(driver: Driver) -> Script:
    """Pick with a pen, which slides a few pixels before it is lifted; events have no pressure here."""
    yield from driver.look_from_the_front()
    yield from driver.key("W", ctrl=True, alt=True)
    report["tapped"] = []
    for place, keys in ((CHEST, {}), (THIGH, {"shift": True})):
        x, y = driver.on_screen(place)
        yield from driver.event("LEFTMOUSE", "PRESS", x, y, **keys)
        for step in range(1, 9):
            yield from driver.move(x + step, y - step)
        yield from driver.event("LEFTMOUSE", "RELEASE", x + 8, y - 8, **keys)
        yield from driver.turns(5)
        regions = module("study.state").patches_of(bpy.context.scene.w2w.body).regions
        report["tapped"].append(
            [regions[patch] for patch in (study().picked, study().compared) if patch >= 0]
        )
    yield from driver.look("4_tapped")


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
    """Larger and smaller, with a second window: a click picks the same patch in both."""
    view = bpy.context.preferences.view
    view.ui_scale = 1.7
    yield from driver.scroll_sidebar_to_top()
    yield from driver.look("6_large")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.window_new_main()
    report["picked"] = []
    for scale in (1.7, 0.7):
        view.ui_scale = scale
        yield from driver.turns(30)
        for driver.number in (0, 1):
            study().picked = -1
            yield from driver.look_from_the_front()
            yield from driver.click(*driver.on_screen(CHEST))
            report["picked"].append(study().picked)
    driver.photograph("6_second_window")


play(
    prepare,
    cancel_an_import,
    look_at_patches,
    look_around,
    choose_a_part,
    edit_a_part,
    tap,
    light,
    german,
    scales,
)
