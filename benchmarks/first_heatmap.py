# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the panel takes from an empty scene to the first heatmap, on real clips.

    python -m benchmarks.first_heatmap [--clips 20] [--patches 512] [--data ../shared/data]

What the buttons start, as a window runs it, a slice of work a turn; a person's clicks between them are not
in it. Beside the seconds by the clock stand the processor's, the reader's included, which tell more on a busy
machine. The baseline is Blender's own importer, which reads the same files and does no more.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import bpy

import w2w as extension
from w2w.core.library.import_plan import plan_folder
from w2w.core.reading.guard import quiet_output
from w2w.ui.jobs import jobs, preferences
from w2w.ui.jobs.windows import BUDGET
from w2w.ui.steps.motion_import import import_items, import_steps
from w2w.ui.steps.run_all import run_all_steps
from w2w.ui.study.state import utility_of

from .longest_turn import make_library


@contextmanager
def timed(name: str) -> Iterator[list[float]]:
    """Print how long a part took; the list has the seconds by the clock afterwards."""
    clock, processor, took = time.perf_counter(), sum(os.times()[:4]), list[float]()
    yield took
    spent, worked = time.perf_counter() - clock, sum(os.times()[:4]) - processor
    took.append(spent)
    print(f"{name:28} {spent:6.1f} s ({worked:.1f} of the processor)", flush=True)


def until_heatmap(body: bpy.types.Object) -> None:
    """Run All, as far as the ranking that paints the body."""
    job = jobs.Job("Run All", run_all_steps(body))
    while utility_of(body.w2w) is None:
        jobs.advance(job, BUDGET)
    job.steps.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--data", type=Path, default=Path("../shared/data"))
    parser.add_argument("--clips", type=int, default=20)
    parser.add_argument("--patches", type=int, default=512)
    given = parser.parse_args()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        preferences.own_folder = lambda _name: folder
        library = make_library(given.data, folder / "library", given.clips)
        extension.register()
        with timed("all") as ours:
            with timed("add body"):
                bpy.ops.w2w.add_body()
            body = bpy.context.scene.w2w.body
            body.w2w.patch_count = given.patches
            clips = import_items(plan_folder(library))
            with timed(f"import, {len(clips)} clips"):
                job = jobs.Job("Import", import_steps(body, clips))
                while jobs.advance(job, BUDGET) is None:
                    pass
            with timed("run all, to the heatmap"):
                until_heatmap(body)
        with timed("Blender's own importer") as merely, quiet_output():
            for clip in clips:
                bpy.ops.import_scene.fbx(filepath=str(clip.path))
        print(f"ratio {ours[0] / merely[0]:.2f}")


if __name__ == "__main__":
    main()
