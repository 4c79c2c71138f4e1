# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w demo`: the whole road on a motion library that W2W makes itself."""

from __future__ import annotations

import json
import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.body.body import Body
from w2w.core.files import write_json
from w2w.core.findings.finished_study import Study
from w2w.core.motion.library import Library, read_library
from w2w.core.study import StudyConfig

from ..reports.console_tables import show_labels
from ..runs.folder import code_sha256, versions
from ..runs.monitor import RunMonitor
from ..runs.own_files import check, claim, note
from ..runs.study import RunPlan
from ..runs.workers import Engine
from .demo_library import LABELS, Take, demo_takes, write_takes
from .execute import check_folder, execute, refused

MADE_BY = "made_by.json"
"""Beside a library that is whole: what made it."""

TARGET = 0.99
"""The exercises are easy to tell apart: one sensor would do for the usual 0.90, and no set would be seen."""


def demo(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the library and the results.")] = Path(
        "demo_output"
    ),
    clips: Annotated[int, typer.Option(min=2, help="Clips an activity.")] = 12,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the library and of the study.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Clips worked on at the same time.")] = os.cpu_count()
    or 1,
) -> None:
    """Make a library of four rehabilitation activities as FBX files and find the best spots for them."""
    config = StudyConfig(seed=seed, target=TARGET)
    rehabilitation_study(out, clips, config, Engine(workers), True, Console(highlight=False))


def rehabilitation_study(
    out: Path, clips: int, config: StudyConfig, engine: Engine, pictures: bool, console: Console
) -> Study:
    """Make the library in `out`/library, with the config's seed, and run the study in `out`/results.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result.
    """
    library, monitor = out / "library", RunMonitor(console)
    plan = RunPlan(Library(library, (), ""), config, engine, pictures)
    with refused(monitor):
        check_folder(plan, out / "results")
    write_library_once(library, demo_takes, clips, config.seed, monitor)
    clips_found = read_library(library, library / LABELS)
    show_labels(clips_found, console)
    return execute(replace(plan, library=clips_found), Body.bundled(), out / "results", monitor)


def write_library_once(
    library: Path, takes_of: Callable[[int], list[Take]], clips: int, seed: int, monitor: RunMonitor
) -> None:
    """Write a library, unless an earlier run of the same code and seed finished it.

    Raises
    ------
    typer.Exit
        With the exit code, where a file that W2W did not write stands in the way.
    """
    made_by = {"clips": clips, "seed": seed, "code_sha256": code_sha256(), "bpy": versions().get("bpy", "")}
    stamp = library / MADE_BY
    with suppress(OSError, ValueError):
        if json.loads(stamp.read_text(encoding="utf-8")) == made_by:
            return
    takes = takes_of(clips)
    with refused(monitor):
        check(library, [LABELS, *(take.file for take in takes)])
        claim(library, [MADE_BY])
    stamp.unlink(missing_ok=True)
    with monitor.bar("writing the library", len(takes)) as advance:
        write_takes(library, takes_of, clips, seed, advance)
    write_json(stamp, made_by)
    note(library, [MADE_BY])
