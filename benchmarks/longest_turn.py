# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the panel's work keeps Blender's window waiting: the longest turn of each job.

    python -m benchmarks.longest_turn [--clips 12] [--patches 512] [--data ../shared/data]

Jobs run as a window runs them, a slice of work a turn, on real clips. Beside the seconds by the clock stand
the processor's seconds in the same turn: of the main thread, and of all threads. Where the clock says much
more than these, the machine did other things.
"""

from __future__ import annotations

import argparse
import csv
import shutil
import tempfile
import time
from collections.abc import Callable
from itertools import chain, islice, zip_longest
from pathlib import Path
from typing import NamedTuple

import bpy

import w2w as extension
from w2w.core.library.import_plan import plan_folder
from w2w.ui.files.open_results import open_steps
from w2w.ui.files.save_results import save_steps
from w2w.ui.jobs import jobs, preferences
from w2w.ui.jobs.windows import BUDGET
from w2w.ui.steps.baking import bake_steps, rank_steps, to_bake
from w2w.ui.steps.body import load_steps
from w2w.ui.steps.choosing import choose_steps
from w2w.ui.steps.motion_import import import_items, import_steps
from w2w.ui.steps.patches import place_steps

ACTIVITIES = ("walking", "running", "crawling", "pivot_kick")


class Turn(NamedTuple):
    """One turn of a job."""

    clock: float
    main: float
    all: float
    text: str


def turns_of(steps: jobs.Steps) -> list[Turn]:
    """Run a job turn by turn, as `W2W_OT_run_job` does."""
    job, turns = jobs.Job("Job", steps), []
    over = None
    while over is None:
        clock, main, everything = time.perf_counter(), time.thread_time(), time.process_time()
        over = jobs.advance(job, BUDGET)
        spent = (time.perf_counter() - clock, time.thread_time() - main, time.process_time() - everything)
        turns.append(Turn(*spent, job.text))
    return turns


def at_once(work: Callable[[], object]) -> list[Turn]:
    """An operator that does all in one turn."""
    clock, main, everything = time.perf_counter(), time.thread_time(), time.process_time()
    work()
    spent = (time.perf_counter() - clock, time.thread_time() - main, time.process_time() - everything)
    return [Turn(*spent, "all of it")]


def show(name: str, turns: list[Turn]) -> None:
    """Print a job's longest turn."""
    longest = max(turns)
    print(
        f"{name:18} longest {longest.clock:6.2f} s (main thread {longest.main:5.2f}, all {longest.all:5.2f}) "
        f"in '{longest.text}'; {sum(turn.clock for turn in turns):6.1f} s in {len(turns)} turns",
        flush=True,
    )


FEWEST = 2
"""Clips of an activity that can be tested."""


def make_library(data: Path, folder: Path, clips: int) -> Path:
    """Copies of real clips, by activity: of fewer activities where there would be too few clips of each."""
    activities = ACTIVITIES[: max(clips // FEWEST, FEWEST)]
    with (data / "motions.csv").open(newline="") as stream:
        rows = [
            row for row in csv.DictReader(stream) if row["import_status"] == "ok" and row["format"] == "fbx"
        ]
    found: list[list[tuple[str, str]]] = []
    for activity in activities:
        (folder / activity).mkdir(parents=True)
        files = {row["motion_key"]: row["file"] for row in rows if row["activity"] == activity}
        found.append([(activity, file) for file in files.values()])
    in_turn = filter(None, chain.from_iterable(zip_longest(*found)))
    for number, (activity, file) in enumerate(islice(in_turn, max(clips, FEWEST * len(activities)))):
        shutil.copyfile(data / file, folder / activity / f"{number} {Path(file).name}")
    return folder


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--clips", type=int, default=12)
    parser.add_argument("--patches", type=int, default=512)
    given = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        preferences.own_folder = lambda _name: folder
        extension.register()
        measure(make_library(given.data, folder / "library", given.clips), folder, given.patches)
        obj = given.data / "smpl_body" / "m_smpl_average_A40.obj"
        show("load SMPL body", turns_of(load_steps(obj)))


def measure(library: Path, folder: Path, patches: int) -> None:
    """Take a body through all steps."""
    show("add body", at_once(lambda: bpy.ops.w2w.add_body()))
    body = bpy.context.scene.w2w.body
    body.w2w.patch_count = patches
    show("import", turns_of(import_steps(body, import_items(plan_folder(library)))))
    show("preview", at_once(lambda: bpy.ops.w2w.preview_clip(index=3)))
    show("place patches", turns_of(place_steps(body)))
    show("bake", turns_of(bake_steps(body, to_bake(body.w2w))))
    show("rank", turns_of(rank_steps(body)))
    show("look at a patch", at_once(lambda: bpy.ops.w2w.select_patch(patch=7)))
    show("untick", at_once(lambda: setattr(body.w2w.activities[0], "part", "LEFT_OUT")))
    body.w2w.activities[0].part = "COUNTED"
    show("choose", turns_of(choose_steps(body)))
    show("save results", turns_of(save_steps(body, folder / "saved")))
    bpy.ops.w2w.select_patch(patch=7)
    bpy.ops.w2w.add_placement(name="pod", vertex=1234)
    show("place with own", turns_of(place_steps(body)))
    show("shape slider", at_once(lambda: setattr(body.w2w.shape, "gender", 0.5)))
    show("open results", turns_of(open_steps(folder / "saved")))


if __name__ == "__main__":
    main()
