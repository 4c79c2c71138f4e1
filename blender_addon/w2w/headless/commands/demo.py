# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w demo`: a whole run on a motion library that comes with W2W."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

from ...core.body.body import Body
from ...core.csv_tables import csv_text
from ...core.files import write_text
from ...core.library.library import LABELS, Library, read_library
from ...core.motion.examples import DEMO_CLIPS, demo_motions
from ...core.study.config import StudyConfig
from ..console import Terminal
from ..options import CORES, option
from ..reports.console_tables import show_labels
from ..runs.clip_task import Engine
from ..runs.monitor import RunMonitor
from ..runs.own_files import claimed
from ..runs.study import RunPlan
from .execute import check_folder, execute, refused


def demo(
    out: Annotated[Path, option("Folder for the library and the results.", "--out", "-o")] = Path(
        "demo_output"
    ),
    clips: Annotated[int, option("Clips an activity.", min=2, max=DEMO_CLIPS)] = DEMO_CLIPS,
    seed: Annotated[int, option("Seed of the study.", min=0)] = 0,
    workers: Annotated[int, option("Clips worked on at the same time.", min=1)] = CORES,
) -> None:
    """Find the best spots for five gestures at a desk, from motions that come with W2W.

    They are written to OUT/library as AMASS-style npz files, the results to OUT/results.
    """
    console = Terminal()
    library, monitor = out / "library", RunMonitor(console)
    plan = RunPlan(Library(library, (), ""), StudyConfig(seed=seed), Engine(workers=workers))
    with refused(monitor):
        check_folder(plan, out / "results")
        write_library(library, clips)
    found = read_library(library, library / LABELS)
    show_labels(found, console)
    execute(replace(plan, library=found), Body.bundled(), out / "results", monitor)


def write_library(folder: Path, clips: int = DEMO_CLIPS) -> None:
    """Write the first clips of each activity, and their labels, unless a foreign file is in the way."""
    motions = demo_motions(clips)
    with claimed(folder, [LABELS, *motions]):
        for file, motion in motions.items():
            (folder / file).parent.mkdir(parents=True, exist_ok=True)
            motion.save(folder / file)
        rows = [(file, motion.activity, motion.subject) for file, motion in motions.items()]
        write_text(folder / LABELS, csv_text([("file", "activity", "subject"), *rows]))
