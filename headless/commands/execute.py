# SPDX-License-Identifier: GPL-3.0-or-later
"""A study from its library to its results, with its progress on the console and its exit code."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import typer

from w2w.core.body.body import Body
from w2w.core.clip_files import WORK
from w2w.core.findings.finished_study import Study
from w2w.core.findings.summary import study_counts, write_failure, write_results
from w2w.core.results_folder import sensors_together

from ..console import BUSY, INTERRUPTED, NOTHING_TO_DO, SKIPPED, USAGE
from ..needs_blender import NoBlenderError
from ..reports import comparison, console_tables, draw, html, pictures
from ..runs.folder import FolderBusyError, make_folders, only_run, own_results
from ..runs.monitor import RunMonitor
from ..runs.own_files import ForeignFileError
from ..runs.patch_mode import placeable
from ..runs.study import RunPlan, StudyError, run_study, write_config
from ..runs.workers import EngineError
from ..stopping import STOPPED
from ..study_options import StudyOptions


def ended(text: str, code: int, monitor: RunMonitor) -> typer.Exit:
    """Say why the run ends here; gives the exit to raise."""
    monitor.console.print(text, style="red", markup=False)
    monitor.log("finished", exit_code=code, problem=text)
    return typer.Exit(code)


def execute(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> Study:
    """Run a study, with its progress on the monitor, and write everything down.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result.
    """
    plan = replace(plan, config=placeable(plan.config, monitor.console))
    try:
        make_folders(out)
        monitor.begin(plan.library, body.name, out)
        more = [*([pictures.BLEND] if plan.pictures else ()), *([html.REPORT] if plan.report else ())]
        with only_run(out / WORK), own_results(out, plan.library, more, plan.pictures):
            study, failed = _execute(plan, body, out, monitor)
    except ForeignFileError as error:
        raise ended(str(error), USAGE, monitor) from error
    except FolderBusyError as error:
        raise ended(str(error), BUSY, monitor) from error
    except OSError as error:
        text = f"No result: {out} cannot be written: {error}. What is finished is kept."
        raise ended(text, NOTHING_TO_DO, monitor) from error
    console_tables.show_outcome(study, plan, failed, monitor.console)
    for name, why in failed.items():
        monitor.log("not_drawn", what=name, reason=why)
    clips = study_counts(study)
    monitor.log("result", out=str(out), used=clips["used"], ranked=clips["ranked"], skipped=clips["skipped"])
    return study


def _execute(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> tuple[Study, dict[str, str]]:
    failed = {}
    try:
        study = run_study(plan, body, out, monitor)
        with monitor.step("testing the sensors together"):
            tested = sensors_together(study.results, study.advice.subset.order)
        study = replace(study, together=tested)
        with monitor.step("writing results"):
            write_config(study)
            write_results(study)
            if plan.report:
                html.write_report(out)
        if plan.pictures:  # last, for Blender may fail to draw where all else is well
            failed = draw.draw_study(study, monitor)
    except (StudyError, EngineError, NoBlenderError) as error:
        monitor.announce("failed", str(error))
        write_failure(out, plan.library, str(error), error.clips if isinstance(error, StudyError) else ())
        if isinstance(error, StudyError):
            console_tables.show_skipped(
                console_tables.skipped_files(error.clips, plan.library), monitor.console
            )
            console_tables.show_window_warning(error.clips, plan.config.windows, monitor.console)
        raise ended(f"No result: {error}", NOTHING_TO_DO, monitor) from error
    except KeyboardInterrupt as error:
        raise ended(f"\n{STOPPED}", INTERRUPTED, monitor) from error
    monitor.announce("finished", "; ".join(f"no {name}: {why}" for name, why in failed.items()))
    return study, failed


def ready_for(asked: StudyOptions, out: Path) -> list[tuple[str, Body]]:
    """The bodies asked for; of several the comparison's name must be free.

    Raises
    ------
    ValueError
        If a body is not understood.
    ForeignFileError
        If a file that W2W did not write stands where the comparison goes.
    """
    bodies = asked.chosen_bodies()
    if len(bodies) > 1:
        comparison.keep_foreign_comparison(out)
    return bodies


def execute_bodies(
    plan: RunPlan, bodies: Sequence[tuple[str, Body]], out: Path, strict: bool, monitor: RunMonitor
) -> list[tuple[str, Study]]:
    """Run a study on each body, in `out` or, of several, in a folder each, and compare them.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result, or clips were skipped and that must not be.
    """
    studies = []
    for name, body in bodies:
        folder = out if len(bodies) == 1 else out / name
        studies.append((name, execute(plan, body, folder, monitor)))
    if len(bodies) > 1:
        console_tables.show_comparison(comparison.write_comparison(studies, out), monitor.console)
    skipped = plan.library.skipped
    if strict and any(len(study.used) < len(study.clips) + len(skipped) for _, study in studies):
        raise ended("Clips were skipped, and --strict was given.", SKIPPED, monitor)
    return studies
