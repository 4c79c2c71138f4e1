# SPDX-License-Identifier: GPL-3.0-or-later
"""What people come for, task after task, from Blender's own first scene: run by `test_tasks.py`.

Environment: W2W_ZIP the extension, W2W_CLIPS a folder of motions, W2W_SCALE the scale of the interface,
W2W_OUT where the report and pictures go.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Generator
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np

sys.path.insert(0, str(Path(__file__).parent))
from driver import LABEL, MIDDLE, Driver, Script
from panel import OUT, idle, install, longest_freeze, module, open_tab, play, report, study, to_page

CLIPS = Path(os.environ["W2W_CLIPS"])
SCALE = float(os.environ["W2W_SCALE"])


def spot(driver: Driver, share: float = 0.5) -> tuple[int, int]:
    """Where a point on the body's trunk is in the window, with this share of the body below."""
    region = driver.region("WINDOW")
    with driver.in_view():
        seen = module("viewport.places").seen(bpy.context, [bpy.context.scene.w2w.body])
    x, y = np.median(seen[:, 0]), np.quantile(seen[:, 1], share)
    return region.x + round(float(x)), region.y + round(float(y))


def body_s_share(driver: Driver) -> float:
    """Height of the body in the view, in the view's heights."""
    area, body = driver.area, bpy.context.scene.w2w.body
    with driver.in_view():
        seen = module("viewport.places").seen(bpy.context, [body])
    free = module("viewport.framing").free_area(area, driver.region("WINDOW"))
    return float((seen[:, 1].max() - seen[:, 1].min()) / (free.top - free.bottom))


def cover(driver: Driver) -> list[int]:
    """How many points of the body each card covers that the view shows."""
    body, region = bpy.context.scene.w2w.body, driver.region("WINDOW")
    with driver.in_view():
        seen = module("viewport.places").seen(bpy.context, [body])
    cards = module("viewport.overlay").cards_at.get(region.as_pointer(), [])
    return [int(sum(box.holds(*point) for point in seen)) for _, box, _ in cards]


def try_the_example(driver: Driver) -> Script:
    """One click after installation gives the first map."""
    bpy.context.preferences.view.ui_scale = SCALE
    install()
    yield from open_tab(driver)
    yield from driver.look("1_empty")
    yield from driver.press("w2w.try_examples")
    yield from idle(driver)
    yield from driver.turns(30)
    yield from driver.look("1_map")
    answer, body = module("study.lists").answer_of(study()), bpy.context.scene.w2w.body
    with driver.in_view():
        patches = module("study.state").patches_of(body)
        surface = module("viewport.drawing").Surface(bpy.context, body, patches)
        is_marked = surface.in_sight(answer["patch"])
    found = {"patch": answer["patch"], "is_marked": is_marked, "share": body_s_share(driver)}
    report["example"] = {"clips": len(study().clips), **found}


def see_a_signal(driver: Driver) -> Script:
    """Preview a clip, click the body: its card has plots, and covers nothing of it."""
    yield from to_page(driver, "Clips")
    yield from driver.press("w2w.preview_clip")
    yield from driver.turns(10)
    yield from driver.key("ESC")
    yield from driver.click(*spot(driver))
    yield from driver.turns(10)
    yield from driver.look("2_signal")
    report["card"] = {"picked": study().picked, "covers": cover(driver)}
    ((_, _, corner),) = module("viewport.overlay").cards_at[driver.region("WINDOW").as_pointer()]
    region = driver.region("WINDOW")
    x, y = (corner.left + corner.right) / 2, (corner.bottom + corner.top) / 2
    yield from driver.click(region.x + round(x), region.y + round(y))
    yield from driver.turns(5)
    report["card"]["closed"] = study().picked


def find_the_best_watch_place(driver: Driver) -> Script:
    """Compare what is worn at a wrist, and a word that nobody knows."""
    yield from to_page(driver, "Answer")
    yield from driver.fill_in("w2w.compare", "watch, tail, ring")
    yield from driver.turns(20)
    yield from driver.look("3_compared")
    found, unknown = module("study.lists").comparison_of(study())
    report["compared"] = [sorted({row["name"] for row in found}), unknown]


def compare_two_spots(driver: Driver) -> Script:
    """Click two spots with the tool, the second with Shift: two cards, of which none covers the body."""
    yield from driver.key("W", ctrl=True, alt=True)
    yield from driver.click(*spot(driver))
    yield from driver.click(*spot(driver, 0.75), shift=True)
    yield from driver.turns(10)
    yield from driver.look("3_two_spots")
    report["two"] = {"picked": [study().picked, study().compared], "covers": cover(driver)}
    yield from driver.key("ESC")
    yield from driver.turns(5)
    report["two"]["closed"] = study().picked
    with driver.in_view():
        bpy.ops.wm.tool_set_by_id(name="builtin.select_box")


def forbid_the_head(driver: Driver) -> Script:
    """Open Sensors Together, add a wish by its menu, type where: the answer is elsewhere."""
    yield from driver.open_panel_below("w2w.export_presentation")
    yield from driver.open_menu_above("w2w.choose_sensors", "F")
    yield from driver.fill_in(".place", "head", MIDDLE)
    yield from driver.turns(10)
    report["wishes"] = [(wish.kind, wish.place) for wish in study().wishes]
    patch = module("study.lists").answer_of(study())["patch"]
    report["forbidden"] = module("study.state").patches_of(bpy.context.scene.w2w.body).regions[patch]
    yield from driver.look("4_forbidden")


def longest_of_job(driver: Driver) -> Generator[None, None, tuple[float, str]]:
    """Wait until a job has begun and ended; its longest standstill."""
    jobs = module("jobs.jobs")
    yield from driver.until(lambda: jobs.running is not None)
    freeze = yield from longest_freeze(driver.until(lambda: jobs.running is None, 600))
    yield from idle(driver)
    return freeze


def save_a_picture(driver: Driver) -> Script:
    """Press Picture, take the name that is offered: the file is there, and opens."""
    yield from to_page(driver, "Answer")
    yield from driver.press("w2w.export_presentation")
    yield from driver.choose_folder(OUT / "pictures", "5_picture.png")
    report["picture_freeze"] = yield from longest_of_job(driver)
    windows = bpy.context.window_manager.windows
    yield from driver.until(lambda: len(windows) > 1, 60)
    yield from driver.turns(60)
    driver.photograph("5_opened")
    report["picture"] = [
        (OUT / "pictures" / "5_picture.png").is_file(),
        windows[-1].screen.areas[0].type,
    ]
    with bpy.context.temp_override(window=windows[-1]):
        bpy.ops.wm.window_close()
    yield from driver.turns(10)


def film(driver: Driver) -> Script:
    """Press Film: Esc ends the first one, which leaves nothing; a short one is written and plays."""
    maker, jobs, folder = module("files.film"), module("jobs.jobs"), OUT / "films"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    played = []
    maker.subprocess = SimpleNamespace(Popen=lambda command: played.append(subprocess.Popen(command)))
    maker.SIZES = {"WIDE": (480, 270)}
    yield from driver.press("w2w.export_film", MIDDLE)
    yield from driver.choose_folder(folder, "stopped.mp4")
    yield from driver.until(lambda: jobs.running is not None and "frame 2" in jobs.running.text, 300)
    yield from driver.look("5_filming")
    yield from driver.key("ESC")
    yield from driver.turns(10)
    report["film"] = {"stopped": [jobs.running is None, [path.name for path in folder.iterdir()]]}
    maker.TURN = 6 / maker.RATE
    yield from driver.press("w2w.export_film", MIDDLE)
    yield from driver.choose_folder(folder, "film.mp4")
    freeze = yield from longest_of_job(driver)
    image = bpy.data.images.load(str(folder / "film.mp4"))
    report["film"] |= {
        "files": [path.name for path in folder.iterdir()],
        "frames": [image.frame_duration, *image.size],
        "freeze": freeze,
        "players": len(played),
    }
    bpy.data.images.remove(image)
    yield from driver.turns(200)
    driver.photograph("5_film")
    for player in played:
        player.terminate()


def mend_a_label(driver: Driver) -> Script:
    """Type another activity into the list's first row: the answer says that it is out of date."""
    yield from to_page(driver, "Clips")
    yield from driver.fill_in("w2w.clip_index", "mended", LABEL, ctrl=True)
    yield from driver.turns(10)
    yield from driver.look("6_label")
    report["mended"] = [
        [clip.activity for clip in study().clips].count("mended"),
        module("study.state").outdated(bpy.context.scene.w2w.body),
    ]
    yield from driver.key("Z", ctrl=True)
    yield from driver.turns(10)


def reopen(driver: Driver) -> Script:
    """Save, open another file, open it again: the answer is there."""
    before = module("study.lists").answer_of(study())["sentence"]
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.save_as_mainfile(filepath=str(OUT / "mine.blend"))
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=False)
    yield from driver.turns(20)
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.wm.open_mainfile(filepath=str(OUT / "mine.blend"))
    yield from driver.turns(60)
    yield from open_tab(driver)
    yield from driver.look("7_reopened")
    after = module("study.lists").answer_of(study())["sentence"]
    report["reopened"] = [module("study.pages").shown_page(), before == after]


def add_own_clips(driver: Driver) -> Script:
    """In a new scene: the second button, one click on the folder in the file browser, Return, Run All."""
    with bpy.context.temp_override(window=driver.window):
        bpy.ops.scene.new(type="NEW")
    yield from driver.turns(20)
    yield from driver.look("8_new_scene")
    yield from driver.press("w2w.import_folder", MIDDLE)
    yield from driver.choose_folder(CLIPS)
    yield from driver.turns(30)
    yield from driver.look("8_labels")
    yield from driver.key("RET")
    yield from idle(driver)
    yield from driver.look("8_clips")
    report["own"] = len(study().clips)
    yield from driver.scroll_sidebar_to_top()
    yield from driver.press("w2w.run_all")
    yield from idle(driver)
    yield from driver.turns(20)
    yield from driver.look("8_map")
    report["own_patch"] = module("study.lists").answer_of(study()).get("patch")


play(
    try_the_example,
    see_a_signal,
    find_the_best_watch_place,
    compare_two_spots,
    forbid_the_head,
    save_a_picture,
    film,
    mend_a_label,
    reopen,
    add_own_clips,
)
