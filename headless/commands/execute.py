# SPDX-License-Identifier: GPL-3.0-or-later
"""A study from its library to its results, with its progress on the console and its exit code."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import typer
from rich.console import Console

from w2w.core.body.body import Body
from w2w.core.clip_files import WORK
from w2w.core.motion.library import Library
from w2w.core.results_folder import sensors_together
from w2w.core.study import StudyConfig

from ..console import BUSY, INTERRUPTED, NOTHING_TO_DO, USAGE, Progress
from ..needs_blender import NoBlenderError
from ..reports.console_tables import show_outcome, show_skipped, show_window_warning, skipped_files
from ..reports.draw import draw_study
from ..reports.html import REPORT, write_report
from ..reports.pictures import BLEND
from ..reports.summary import study_counts, write_failure, write_results
from ..runs.folder import FolderBusyError, make_folders, only_run, own_results
from ..runs.monitor import SILENT, EventLog, Watch
from ..runs.own_files import ForeignFileError
from ..runs.patch_mode import placeable
from ..runs.study import Study, StudyError, run_study, write_config
from ..runs.workers import Engine, EngineError
from ..stopping import STOPPED


def ended(text: str, code: int, console: Console, log: EventLog) -> typer.Exit:
    """Say why the run ends here; gives the exit to raise."""
    console.print(text, style="red", markup=False)
    log("finished", exit_code=code, problem=text)
    return typer.Exit(code)


def execute(
    library: Library,
    body: Body,
    config: StudyConfig,
    out: Path,
    engine: Engine,
    pictures: bool,
    console: Console,
    report: bool = True,
    log: EventLog = SILENT,
) -> Study:
    """Run a study with its progress on the console, and write everything down.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result.
    """
    config = placeable(config, console)
    try:
        make_folders(out)
        log("started", out=str(out), body=body.name, clips=len(library.clips), activities=library.activities)
        for file, reason in library.skipped:
            log("clip", file=file, used=False, reason=reason)
        watch = Watch(out, len(library.clips), log)
        more = [*([BLEND] if pictures else ()), *([REPORT] if report else ())]
        with only_run(out / WORK), own_results(out, library, more, pictures):
            study, failed = _execute(library, body, config, out, engine, pictures, console, watch, report)
    except ForeignFileError as error:
        raise ended(str(error), USAGE, console, log) from error
    except FolderBusyError as error:
        raise ended(str(error), BUSY, console, log) from error
    except OSError as error:
        text = f"No result: {out} cannot be written: {error}. What is finished is kept."
        raise ended(text, NOTHING_TO_DO, console, log) from error
    show_outcome(study, pictures, console, report, failed)
    for name, why in failed.items():
        log("not_drawn", what=name, reason=why)
    clips = study_counts(study)
    log("result", out=str(out), used=clips["used"], ranked=clips["ranked"], skipped=clips["skipped"])
    return study


def _execute(
    library: Library,
    body: Body,
    config: StudyConfig,
    out: Path,
    engine: Engine,
    pictures: bool,
    console: Console,
    watch: Watch,
    report: bool,
) -> tuple[Study, dict[str, str]]:
    progress, failed = Progress(console), {}
    try:
        study = run_study(library, body, config, out, engine, progress, watch)
        watch.step("testing the sensors together")
        with progress.spinner("Testing the sensors together"):
            tested = sensors_together(study.results, study.advice.subset.order)
        study = replace(study, together=tested)
        watch.step("writing results")
        write_config(study)
        write_results(study)
        if report:
            write_report(out)
        if pictures:  # last, for Blender may fail to draw where all else is well
            watch.step("drawing")
            failed = draw_study(study, progress)
    except (StudyError, EngineError, NoBlenderError) as error:
        watch.step("failed", str(error))
        if isinstance(error, StudyError):
            write_failure(out, library, error)
            show_skipped(skipped_files(error.clips, library), console)
            show_window_warning(error.clips, config.windows, console)
        raise ended(f"No result: {error}", NOTHING_TO_DO, console, watch.log) from error
    except KeyboardInterrupt as error:
        raise ended(f"\n{STOPPED}", INTERRUPTED, console, watch.log) from error
    watch.step("finished", "; ".join(f"no {name}: {why}" for name, why in failed.items()))
    return study, failed
