# SPDX-License-Identifier: GPL-3.0-or-later
"""A study from its library to its results, with its progress on the console and its exit code."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import typer

from w2w.core.body.body import Body
from w2w.core.clip_files import WORK
from w2w.core.findings.finished_study import Study
from w2w.core.findings.summary import study_counts, write_failure, write_results
from w2w.core.motion.library import BLENDER_SUFFIXES, Library
from w2w.core.ranking.folds import check_testable

from ..console import BUSY, INTERRUPTED, NOTHING_TO_DO, SKIPPED, USAGE, too_little_memory
from ..needs_blender import NoBlenderError, check_installed
from ..reports import comparison, console_tables, draw, html, pictures
from ..runs.folder import SUMMARY, TABLES, FolderBusyError, check_results, make_folders, only_run
from ..runs.monitor import RunMonitor
from ..runs.own_files import ForeignFileError, check, claimed, remove_written
from ..runs.picture_names import HEATMAPS, picture_files
from ..runs.study import RunPlan, StudyError, run_study, write_config
from ..runs.workers import EngineError
from ..stopping import STOPPED
from ..study_options import StudyOptions


def ended(text: str, code: int, monitor: RunMonitor) -> typer.Exit:
    """Say why the run ends here; gives the exit to raise."""
    monitor.console.print(text, style="red", markup=False)
    monitor.log("finished", exit_code=code, problem=text)
    return typer.Exit(code)


@contextmanager
def refused(monitor: RunMonitor) -> Iterator[None]:
    """End with a sentence and an exit code what the block finds wrong before any work.

    Raises
    ------
    typer.Exit
    """
    try:
        yield
    except NoBlenderError as error:
        raise ended(f"No result: {error}", NOTHING_TO_DO, monitor) from error
    except (ValueError, OSError) as error:
        raise ended(str(error), USAGE, monitor) from error


def execute(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> Study:
    """Run a study, with its progress on the monitor, and write everything down.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result.
    """
    try:
        check_folder(plan, out)
        make_folders(out)
        monitor.begin(plan.library, body.name, out)
        with only_run(out / WORK), claimed(out, _written_by(plan)):
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
        with monitor.step("writing results"):
            write_config(study)
            write_results(study)
            if plan.report:
                html.write_report(out)
        if plan.pictures:  # last, for Blender may fail to draw where all else is well
            failed = draw.draw_study(study, monitor)
    except (StudyError, EngineError, NoBlenderError, MemoryError) as error:
        why = too_little_memory(error) if isinstance(error, MemoryError) else str(error)
        monitor.announce("failed", why)
        if isinstance(error, StudyError):
            _remove_results(plan, out)
        write_failure(out, plan.library, why, error.clips if isinstance(error, StudyError) else ())
        if isinstance(error, StudyError):
            console_tables.show_skipped(
                console_tables.skipped_files(error.clips, plan.library), monitor.console
            )
            console_tables.show_window_warning(error.clips, plan.config.windows, monitor.console)
        raise ended(f"No result: {why}", NOTHING_TO_DO, monitor) from error
    except KeyboardInterrupt as error:
        raise ended(f"\n{STOPPED}", INTERRUPTED, monitor) from error
    monitor.announce("finished", "; ".join(f"no {name}: {why}" for name, why in failed.items()))
    return study, failed


def check_folder(plan: RunPlan, out: Path) -> None:
    """Refuse a results folder in which a file that W2W did not write is in the run's way; changes nothing.

    Raises
    ------
    ForeignFileError
    """
    drawn = _drawn(plan.library) if plan.pictures else []
    check_results(out, plan.library, [*_written_by(plan), *drawn, *plan.more])


def ready_for(plan: RunPlan, asked: StudyOptions, out: Path) -> list[tuple[str, Body]]:
    """The bodies asked for, once nothing is left that would have the run refused.

    Raises
    ------
    ValueError
        If a body is not understood, no two activities can be told apart, or a file that W2W did not write is
        in the way.
    NoBlenderError
        If clips need Blender's module, and it is not installed.
    """
    clips = plan.library.clips
    check_testable([clip.activity for clip in clips], [clip.motion_key or clip.name for clip in clips])
    if any(clip.path.suffix.lower() in BLENDER_SUFFIXES for clip in clips):
        check_installed()
    bodies = asked.chosen_bodies()
    if len(bodies) > 1:
        check(out, [comparison.COMPARISON])
    for name, _ in bodies:
        check_folder(plan, out if len(bodies) == 1 else out / name)
    return bodies


def _remove_results(plan: RunPlan, out: Path) -> None:
    """Remove what an earlier run found: it would stand beside a summary that says there is no result."""
    results = {*TABLES, pictures.BLEND, html.REPORT, *plan.more} - {SUMMARY}
    remove_written(out, lambda name: name in results or name.startswith(f"{HEATMAPS}/"))


def _written_by(plan: RunPlan) -> list[str]:
    """What a run writes into its folder beside clips, heatmaps and what its command adds."""
    return [*TABLES, *([pictures.BLEND] if plan.pictures else ()), *([html.REPORT] if plan.report else ())]


def _drawn(library: Library) -> list[str]:
    return [f"{HEATMAPS}/{file}" for file in picture_files(list(library.activities))]


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
