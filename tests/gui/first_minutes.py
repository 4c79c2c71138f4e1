# SPDX-License-Identifier: GPL-3.0-or-later
"""The first ten minutes, by clicking in Blender's own first scene: run by `test_first_minutes.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_OUT where the report and pictures go,
W2W_RENDER which engines render ("" for none).
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from driver import MIDDLE, Driver, Script
from panel import OUT, idle, install, module, open_tab, play, report, study, to_page

EEVEE = "BLENDER_EEVEE" if bpy.app.version >= (5, 0) else "BLENDER_EEVEE_NEXT"
ENGINES = {"WORKBENCH": "BLENDER_WORKBENCH", "CYCLES": "CYCLES", "EEVEE": EEVEE}
COLOURED = 6
"""Difference of the channels of a pixel from which on it has a colour: Blender's own greys have less."""


def pixels(path: Path) -> np.ndarray:
    """A picture as an array (H, W, 3)."""
    from PIL import Image

    with Image.open(path) as picture:
        return np.array(picture.convert("RGB")).astype(int)


def coloured(picture: np.ndarray) -> np.ndarray:
    """Which pixels have a colour."""
    return np.ptp(picture, axis=-1) > COLOURED


def reach_the_map(driver: Driver) -> Script:
    """Add a body next to what is there, import a folder, run all."""
    install()
    yield from open_tab(driver)
    report["things"] = sorted(bpy.context.scene.objects.keys())
    yield from driver.look("0_start")
    yield from driver.press("w2w.add_body")
    yield from driver.turns(10)
    yield from driver.look("1_body")
    yield from driver.press("w2w.import_folder", MIDDLE)
    yield from driver.choose_folder(Path(os.environ["W2W_CLIPS"]))
    yield from driver.turns(30)
    yield from driver.key("RET")
    yield from idle(driver)
    yield from driver.scroll_sidebar_to_top()
    yield from driver.press("w2w.run_all")
    yield from idle(driver)
    yield from driver.turns(10)
    yield from driver.look("2_map")
    yield from look_at_the_map(driver)
    yield from read_the_sentence(driver)


def look_at_the_map(driver: Driver) -> Script:
    """By part of the body, how many of its patches in sight show the map, and how many there are."""
    body = bpy.context.scene.w2w.body
    patches, framing = module("study.state").patches_of(body), module("viewport.framing")
    region = driver.region("WINDOW")
    with driver.in_view():
        surface = module("viewport.drawing").Surface(bpy.context, body, patches)
        spots = {patch: surface.on_screen(patch) for patch in range(len(patches)) if surface.in_sight(patch)}
        free = framing.free_area(driver.area, region)
    picture = pixels(driver.pictures / "2_map.png")
    shown: dict[str, list[bool]] = {}
    for patch, spot in spots.items():
        row, column = picture.shape[0] - 1 - (region.y + int(spot.y)), region.x + int(spot.x)
        is_free = free.left < spot.x < free.right and free.bottom < spot.y < free.top
        has_colour = is_free and coloured(picture[row - 1 : row + 2, column - 1 : column + 2]).any()
        shown.setdefault(patches.regions[patch], []).append(bool(has_colour))
    report["shown"] = {part: [sum(seen), len(seen)] for part, seen in shown.items()}
    yield


def read_the_sentence(driver: Driver) -> Script:
    """Whether the answer's sentence is at the top of the panel, in lines that are not cut."""
    text, region = module("jobs.text"), driver.region("UI")
    said = module("jobs.jobs").message.text
    room = region.width - text.TABS_AND_MARGINS - text.ICON - 56
    lines = text.wrapped(said, room, text.in_panel)
    report["sentence"] = {
        "text": said,
        "answer": module("study.lists").answer_of(study())["sentence"],
        "scrolled": round(driver.in_panel(region.y + region.height)),
        "widest": max(module("viewport.drawing").width_of(line, text.PANEL_POINTS) for line in lines) / room,
        "height": 20 * len(lines) / region.height,
    }
    yield


def play_a_clip(driver: Driver) -> Script:
    """Preview plays; the same button stops it, and so does Esc."""
    screen, scene = driver.window.screen, bpy.context.scene
    yield from to_page(driver, "Clips")
    yield from driver.press("w2w.preview_clip")
    frames = set()
    for _ in range(60):
        frames.add(scene.frame_current)
        yield
    report["frames_played"] = len(frames)
    yield from driver.look("3_playing")
    playing = [screen.is_animation_playing]
    yield from driver.press("w2w.preview_clip")
    playing.append(screen.is_animation_playing)
    yield from driver.press("w2w.preview_clip")
    playing.append(screen.is_animation_playing)
    yield from driver.key("ESC")
    report["playing"] = [*playing, screen.is_animation_playing]


def compare_and_show(driver: Driver) -> Script:
    """Compare two products, render the picture to show."""
    study().compare = "ring, necklace"
    yield from to_page(driver, "Answer")
    yield from driver.look("4_compared")
    report["compared"] = [row["name"] for row in module("study.lists").comparison_of(study())[0]]
    with driver.in_view():
        bpy.ops.w2w.export_presentation(filepath=str(OUT / "pictures" / "5_presentation.png"))
    yield from idle(driver)
    yield from driver.until(lambda: len(bpy.context.window_manager.windows) > 1, 60)
    yield from driver.turns(30)
    report["windows"] = [window.screen.areas[0].type for window in bpy.context.window_manager.windows]
    driver.photograph("5_opened")
    with driver.in_view():
        bpy.ops.w2w.export_presentation(
            filepath=str(OUT / "pictures" / "5_alone.png"),
            pose="THIS_FRAME", seen="THIS_VIEW", content="BODY_ALONE", shape="SQUARE", light="FLAT",
        )  # fmt: skip
    yield from idle(driver)
    yield from driver.until(lambda: len(bpy.context.window_manager.windows) > 2, 60)
    yield from driver.turns(30)
    for window in bpy.context.window_manager.windows[1:]:
        with bpy.context.temp_override(window=window):
            bpy.ops.wm.window_close()
    alone = pixels(OUT / "pictures" / "5_alone.png")
    report["alone"] = {"size": alone.shape[:2], "colours": int(coloured(alone).sum())}
    picture = pixels(OUT / "pictures" / "5_presentation.png")
    legend = [
        len({*map(tuple, column.tolist())})
        for column in (picture * coloured(picture)[..., None]).swapaxes(0, 1)
    ]
    report["presentation"] = {
        "scenes": len(bpy.data.scenes),
        "shape": picture.shape[1] / picture.shape[0],
        "colours_of_legend": max(legend),
        "colours": int(coloured(picture).sum()),
        "ink": int((picture.max(axis=-1) < 70).sum()),
    }


def render(_driver: Driver) -> Script:
    """Render by F12's operator, through the scene's own camera."""
    scene = bpy.context.scene
    scene.frame_set(1)
    scene.render.resolution_x, scene.render.resolution_y = 480, 270
    scene.cycles.samples, scene.cycles.use_denoising, scene.eevee.taa_render_samples = 4, False, 1
    for name in os.environ["W2W_RENDER"].split():
        scene.render.engine, path = ENGINES[name], OUT / "pictures" / f"6_{name.lower()}.png"
        scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True)
        report.setdefault("rendered", {})[name] = int(coloured(pixels(path)).sum())
        yield


play(reach_the_map, play_a_clip, compare_and_show, render)
