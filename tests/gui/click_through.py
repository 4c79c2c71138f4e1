# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps in a real Blender window, by clicking: run inside Blender by `test_window.py`.

Environment: W2W_ZIP the extension, W2W_DATA the folder of real data, W2W_OUT where the report and the
pictures go. Every check is of Blender's state; the pictures are for people.
"""

from __future__ import annotations

import csv
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parent))
from driver import CLOSED, FIELD, IN_HEADER, LAST, MIDDLE, Driver, Script
from panel import (
    OUT,
    TABS,
    curves,
    empty,
    idle,
    install,
    longest_freeze,
    module,
    open_tab,
    play,
    report,
    study,
    to_page,
)

DATA = Path(os.environ["W2W_DATA"])
ACTIVITIES = (
    "crawling", "kneeling", "load_carrying", "pivot_kick",
    "running", "sit_to_stand", "turning_180", "walking",
)  # fmt: skip
CLIPS_EACH = 6
PART = 0.12
"""Where in a row of the list of activities its part stands, from left to right."""


def prepare(driver: Driver) -> Script:
    """Install the extension, empty the scene, open the tab."""
    install()
    empty(driver)
    yield from open_tab(driver)
    yield from driver.look("0_empty")


def undo_and_redo(driver: Driver, what: str, probe: Callable[[], object]) -> Script:
    """Press Ctrl Z once, Ctrl Shift Z once, and report what a probe finds before, between and after."""
    found = [probe()]
    yield from driver.key("Z", ctrl=True)
    found.append(probe())
    yield from driver.key("Z", ctrl=True, shift=True)
    report.setdefault("undo", {})[what] = [*found, probe()]


def step_body(driver: Driver) -> Script:
    """Add the body; one undo takes it away, one redo brings it back."""
    yield from driver.press("w2w.add_body")
    report["body"] = bpy.context.scene.w2w.body.name
    yield from driver.key("Z", ctrl=True)
    report["bodies_after_undo"] = len(bpy.data.objects)
    yield from driver.key("Z", ctrl=True, shift=True)
    report["bodies_after_redo"] = len(bpy.data.objects)
    yield from driver.key("NUMPAD_1")
    yield from driver.key("NUMPAD_PERIOD")
    yield from driver.turns(30)
    yield from driver.look("1_body")


def step_motions(driver: Driver) -> Script:
    """Import a folder of real clips, cancel another import, take unusable files, preview."""
    library = make_library()
    objects = len(bpy.data.objects)
    yield from driver.press("w2w.import_folder", MIDDLE)
    yield from driver.choose_folder(library)
    yield from driver.turns(30)
    yield from driver.look("2_labels")
    yield from driver.key("RET")
    yield from driver.turns(30)
    yield from driver.look("2_importing")
    yield from idle(driver)
    report["clips"] = len(study().clips)
    report["usable"] = sum(clip.action is not None for clip in study().clips)
    report["activities"] = sorted({clip.activity for clip in study().clips})
    report["objects_left_by_import"] = len(bpy.data.objects) - objects
    yield from undo_and_redo(driver, "import", lambda: len(study().clips))
    actions = len(bpy.data.actions)
    with driver.in_view():
        files = [{"name": path.name} for path in sorted((DATA / "mixamo/_broken").glob("*.fbx"))]
        bpy.ops.w2w.import_motions(directory=f"{DATA}/mixamo/_broken/", files=files)
    yield from idle(driver)
    report["problems"] = {clip.name: clip.problem for clip in study().clips if clip.problem}
    report["actions_from_problems"] = len(bpy.data.actions) - actions
    yield from driver.look("2_motions_problem")
    yield from drop_a_clip(driver)
    bpy.ops.w2w.tick_clips(which="PROBLEM")
    yield from driver.press("w2w.remove_clips", LAST)
    report["clips_after_removing_problems"] = len(study().clips)
    study().clip_index = [clip.activity for clip in study().clips].index("walking")
    yield from driver.press("w2w.preview_clip")
    playing = bpy.context.scene.w2w.body.parent.animation_data.action
    report["previewed"] = playing.name
    yield from driver.key("ESC")
    bpy.context.scene.frame_set(12)
    yield from driver.press("w2w.show_source", FIELD)
    yield from driver.turns(10)
    bpy.context.scene.frame_set(12)
    yield from driver.key("HOME")
    yield from driver.turns(30)
    yield from driver.look("2_source_beside")
    report["source_shown"] = sum("w2w source" in item for item in bpy.data.collections)
    yield from driver.press("w2w.show_source", FIELD)
    yield from driver.key("HOME")
    yield from driver.turns(30)
    report["source_left"] = sum("w2w source" in item for item in bpy.data.collections)


def drop_a_clip(driver: Driver) -> Script:
    """Drop a real FBX and a real BVH on the viewport, one after the other, and undo each."""
    region = driver.region("WINDOW")
    x, y = region.x + 200, region.y + 300
    report["dropped"] = {}
    for path in (real_clips("walking", "fbx")[0], sorted((DATA / "bvh").rglob("*.bvh"))[0]):
        before = len(study().clips)
        yield from driver.drop([path], x, y)
        yield from driver.look(f"2_drop_{path.suffix[1:]}")
        yield from driver.turns(60)
        if len(study().clips) == before:  # Blender offers its own importer too: choose ours in the menu
            yield from driver.event("M", "PRESS", x, y)
            yield from driver.event("M", "RELEASE", x, y)
        yield from driver.until(lambda before=before: len(study().clips) > before, 30)
        yield from idle(driver)
        clip = study().clips[-1]
        report["dropped"][path.suffix] = [clip.n_frames, clip.problem]
        yield from driver.key("Z", ctrl=True)
        report.setdefault("clips_after_undoing_drops", []).append(len(study().clips) - before)


def step_patches(driver: Driver) -> Script:
    """Place patches twice: nothing of the first time is left."""
    yield from to_page(driver, "Details")
    yield from driver.look("3_details")
    yield from driver.open_panel_below("w2w_page", TABS["Details"])
    yield from driver.press("w2w.place_patches")
    yield from idle(driver)
    report["patches"] = len(study().patch_collection.objects)
    yield from driver.look("3_patches")
    yield from driver.press("w2w.place_patches")
    yield from idle(driver)
    report["empties_after_placing_again"] = sum(item.type == "EMPTY" for item in bpy.data.objects)
    study().patch_seed = 1
    first = study().patches_key
    yield from driver.press("w2w.place_patches")
    yield from idle(driver)
    yield from undo_and_redo(driver, "place", lambda: study().patches_key == first)
    yield from driver.key("Z", ctrl=True)
    report["patches_after_undo"] = (study().patches_key == first, len(study().patch_collection.objects))


def step_signals(driver: Driver) -> Script:
    """Cancel a bake by Esc, bake, undo and redo it."""
    yield from driver.press("w2w.bake_signals")
    yield from driver.turns(20)
    yield from driver.look("4_baking")
    yield from driver.key("ESC")
    yield from idle(driver)
    report["baked_after_esc"] = sum(bool(clip.signals) for clip in study().clips)
    yield from driver.press("w2w.bake_signals")
    report["longest_freeze_while_baking"] = yield from longest_freeze(idle(driver))
    report["baked"] = sum(bool(clip.signals) for clip in study().clips)
    yield from driver.key("Z", ctrl=True)
    report["baked_after_undo"] = sum(bool(clip.signals) for clip in study().clips)
    yield from driver.key("Z", ctrl=True, shift=True)
    report["baked_after_redo"] = sum(bool(clip.signals) for clip in study().clips)
    yield from driver.look("4_signals")


def record_further(driver: Driver) -> Script:
    """Tick two further sensors, one to recognise by; look at a part of one's own; take it all back."""
    yield from driver.open_panel_above("window_s")
    for name in ("recorded[0]", "recorded[1]", "recognised_by[1]"):
        yield from driver.press(name, FIELD)
    yield from driver.look("4_further")
    further = module("study.state").config_of(study()).further
    report["further"] = [further.record, further.features]
    with driver.in_view():
        bpy.ops.w2w.start_sensor(like="bmi270")
    yield from driver.look("4_own_part")
    for name in ("recorded[0]", "recorded[1]"):
        yield from driver.press(name, FIELD)
    report["further_left"] = sorted(study().record)
    study().property_unset("sensor")
    study().property_unset("recognise_by")
    yield from driver.close_panel(".band")


def step_activities(driver: Driver) -> Script:
    """Before the first ranking, weigh an activity and let the menu make it background; take that back."""
    yield from driver.open_panel_below("w2w.rank_patches")
    yield from driver.scroll_sidebar(12)
    x, y = yield from driver.reach(".weight", LAST)
    yield from driver.drag(x, y, 40)
    report["weight_after_drag"] = study().activities[0].weight
    study().activities[0].weight = 1.0
    yield from driver.look("5_activities")
    region, parts = driver.region("UI"), []
    x = region.x + int(PART * region.width)
    for letter in "BLC":  # of the menu's words
        yield from driver.click(x, y)
        yield from driver.turns(10)
        if letter == "B":
            driver.photograph("5_part_menu")
        yield from driver.event(letter, "PRESS", x, y)
        yield from driver.event(letter, "RELEASE", x, y)
        yield from driver.turns(10)
        parts.append(study().activities[0].part)
    report["parts_by_menu"] = parts


def step_utility(driver: Driver) -> Script:
    """Rank, look at an activity, drag the target."""
    yield from driver.scroll_sidebar(12)
    yield from driver.press("w2w.rank_patches")
    yield from driver.turns(15)
    yield from driver.look("5_ranking")
    yield from idle(driver)
    report["heatmaps"] = len(bpy.context.scene.w2w.body.data.color_attributes)
    report["shown"] = bpy.context.scene.w2w.body.data.color_attributes.active_color.name
    report["mean_f1_range"] = [row.f1 for row in study().regions]
    report["chosen"] = [place.patch for place in study().chosen]
    yield from undo_and_redo(
        driver, "rank", lambda: (len(bpy.context.scene.w2w.body.data.color_attributes), len(study().chosen))
    )
    yield from driver.look("5_mean")
    yield from to_page(driver, "Answer")
    yield from driver.look("5_places")
    yield from driver.open_panel_below("w2w.export_presentation")
    x, y = yield from driver.reach("target", FIELD)
    yield from driver.drag(x, y, -60)
    report["target_after_drag"] = round(study().target, 3)
    yield from undo_and_redo(driver, "target", lambda: round(study().target, 3))
    yield from to_page(driver, "Details")
    yield from driver.click_header("w2w.reset_shape", CLOSED, IN_HEADER)  # Top Regions, over Shape
    yield from driver.press("w2w.select_patch")
    report["picked_in_table"] = study().picked
    yield from driver.look("5_table_pick")
    study().view = "A3"
    yield from driver.look("5_activity")
    report["shown_activity"] = bpy.context.scene.w2w.body.data.color_attributes.active_color.name


def pick_and_compare(driver: Driver) -> Script:
    """The pick tool by its key; click the body, Shift-click elsewhere; play."""
    yield from driver.key("W", ctrl=True, alt=True)
    tools = bpy.context.workspace.tools
    report["tool"] = tools.from_space_view3d_mode("OBJECT").idname
    x, y = driver.on_screen((0.0, -0.1, 1.25))
    yield from driver.click(x, y)
    report["picked_on_body"] = study().picked
    yield from driver.look("6_pick")
    report["in_sight"] = in_sight(driver)
    x, y = driver.on_screen((0.09, -0.05, 0.9))
    yield from driver.click(x, y, shift=True)
    report["compared_on_body"] = study().compared
    yield from driver.look("6_compare")
    yield from driver.key("SPACE")
    yield from driver.turns(40)
    report["frame_while_playing"] = bpy.context.scene.frame_current
    yield from driver.look("6_playing")
    yield from driver.key("SPACE")


def in_sight(driver: Driver) -> dict[str, list[bool]]:
    """Whether patches of the chest and of the back can be seen from the front."""
    body = bpy.context.scene.w2w.body
    patches = module("study.state").patches_of(body)
    with driver.in_view():
        surface = module("viewport.drawing").Surface(bpy.context, body, patches)
        return {
            part: [surface.in_sight(patch) for patch, region in enumerate(patches.regions) if part in region]
            for part in ("sternum", "abdomen", "lower back", "scapula")
        }


def reshape(driver: Driver) -> Script:
    """Drag a shape slider: the body changes under its heatmap; one undo brings it back."""
    yield from to_page(driver, "Details")
    yield from driver.open_panel_with("w2w.reset_shape")
    x, y = yield from driver.reach("shape.gender", FIELD)
    before, shown = outline(), bpy.context.scene.w2w.body.data.color_attributes.active_color.name
    yield from driver.drag(x, y, 60)
    yield from driver.look("8_shape")
    report["shape_changed"] = outline() != before
    report["heatmap_stays"] = bpy.context.scene.w2w.body.data.color_attributes.active_color.name == shown
    report["patches_stay"] = len(study().patch_collection.objects)
    yield from driver.key("Z", ctrl=True)
    report["shape_undone"] = outline() == before
    report["gender_after_undo"] = study().shape.gender


def outline() -> list[float]:
    """Numbers that change with a body's shape: a vertex, a joint and the pelvis's path in its action."""
    body = bpy.context.scene.w2w.body
    action = body.parent.animation_data.action
    path = next(
        curve for curve in curves(action) if "pelvis" in curve.data_path and "location" in curve.data_path
    )
    joint = body.parent.data.bones["left_shoulder"].head_local
    return [*body.data.vertices[1000].co, *joint, path.keyframe_points[-1].co[1]]


def reopen(driver: Driver) -> Script:
    """A saved file opens complete."""
    before = state()
    path = str(OUT / "study.blend")
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_as_mainfile(filepath=path, compress=True)
        bpy.ops.wm.open_mainfile(filepath=path)
    yield from driver.turns(10)
    report["megabytes"] = round(Path(path).stat().st_size / 1e6, 2)
    report["reopened_alike"] = state() == before
    yield from driver.look("7_reopened")


def show_preferences(driver: Driver) -> Script:
    """The extension's preferences, in place of the 3D view: there is no window manager."""
    driver.area.type = "PREFERENCES"
    bpy.context.preferences.active_section = "ADDONS"
    bpy.context.window_manager.addon_search = "W2W"
    bpy.ops.preferences.addon_expand(module="bl_ext.user_default.w2w")
    yield from driver.turns(20)
    driver.photograph("9_preferences")


def state() -> dict[str, object]:
    """What a saved file must bring back."""
    return {
        "clips": [(clip.name, clip.activity, clip.signals, clip.action.name) for clip in study().clips],
        "chosen": [(place.patch, place.label, place.f1) for place in study().chosen],
        "regions": [(place.patch, place.label, place.f1) for place in study().regions],
        "view": study().view,
        "utility": study().utility_key,
        "patches": [item.name for item in study().patch_collection.objects],
        "picked": (study().picked, study().compared),
    }


def real_clips(activity: str, kind: str) -> list[Path]:
    """Files of an activity, one a motion."""
    with (DATA / "motions.csv").open(newline="") as stream:
        rows = [row for row in csv.DictReader(stream) if row["activity"] == activity]
    usable = [row for row in rows if (row["format"], row["import_status"]) == (kind, "ok")]
    return [DATA / row["file"] for row in {row["motion_key"]: row for row in usable}.values()]


def make_library() -> Path:
    """Links to real clips in folders by activity."""
    library = OUT / "library"
    shutil.rmtree(library, ignore_errors=True)
    for activity in ACTIVITIES:
        (library / activity).mkdir(parents=True)
        for number, source in enumerate(real_clips(activity, "fbx")[:CLIPS_EACH], start=1):
            (library / activity / f"{source.stem} {number}.fbx").symlink_to(source)
    return library


play(
    prepare,
    step_body,
    step_motions,
    step_patches,
    step_signals,
    record_further,
    step_activities,
    step_utility,
    pick_and_compare,
    reshape,
    reopen,
    show_preferences,
)
