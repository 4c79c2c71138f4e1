# SPDX-License-Identifier: GPL-3.0-or-later
"""A study from its library to its results, with its progress on the console and its exit code."""

import json
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any

import typer

from ...core.body.body import Body
from ...core.files import json_number, write_json
from ...core.findings.advice_content import patch_content
from ...core.findings.cautions import Caution, below, window_caution
from ...core.findings.summary import study_counts, write_failure, write_results
from ...core.given import ForeignFileError, inside
from ...core.ranking.agreement import rank_agreement
from ...core.ranking.folds import check_testable
from ...core.study.clip_files import CLIP_LIST, WORK, mark_changing, mark_whole
from ...core.study.results import REPORT, Study
from ...core.wording import restated
from ..blender import NoBlenderError, check_installed
from ..console import BUSY, NOTHING_TO_DO, SKIPPED, USAGE, sentence_of
from ..options import parse_bodies
from ..reports import console_tables, draw
from ..runs import folder
from ..runs.cluster import EngineError
from ..runs.current import is_current, is_untouched, looks_of_inputs, note_current
from ..runs.monitor import RunMonitor
from ..runs.own_files import check, claimed, remove_written
from ..runs.study import RunPlan, StudyError, choose_in_study, make_signals, rank_study, write_config
from ..study_options import StudyOptions
from .report import write_report

COMPARISON = "bodies.json"

NO_RESULT = (StudyError, EngineError, NoBlenderError, MemoryError)
"""Errors that end a run of which all that is finished is kept."""


def ended(text: str, code: int, monitor: RunMonitor) -> typer.Exit:
    """Say why the run ends here; returns the exit to raise."""
    monitor.console.print(text, style="red")
    monitor.log("finished", exit_code=code, problem=text)
    return typer.Exit(code)


@contextmanager
def refused(monitor: RunMonitor) -> Iterator[None]:
    """End the command with a sentence and an exit code if the block raises, before any work."""
    try:
        yield
    except NoBlenderError as error:
        raise ended(f"No result: {error}", NOTHING_TO_DO, monitor) from error
    except (ValueError, OSError) as error:
        raise ended(sentence_of(error), USAGE, monitor) from error


def execute(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> Study | None:
    """Run a study and write everything down; without a result, a typer.Exit has the exit code.

    None if everything was there already, unless the plan has it made `again`.
    """
    with _in_folder(out, monitor):
        check(out, ())
        inputs = looks_of_inputs(plan)
        # a program that reads events is told of every clip
        done = not (plan.again or monitor.log.stream) and is_untouched(body, out, inputs)
        if not done:
            plan = plan.look(plan)
            check_folder(plan, out)
            folder.make_folders(out, len(plan.library.clips))
        monitor.begin(plan.library, body.name, out, kept=not done)
        with folder.only_run(out / WORK), closing(plan.crew):
            study, failed = (None, {}) if done else _execute(plan, body, out, inputs, monitor)
            mark_whole(out)
    if study is None:
        clips = _say_unchanged(out, monitor)
    else:
        console_tables.show_outcome(study, plan, failed, monitor.console)
        clips = study_counts(study)
    for name, why in failed.items():
        monitor.log("not_drawn", what=name, reason=why)
    monitor.log("result", out=str(out), used=clips["used"], ranked=clips["ranked"], skipped=clips["skipped"])
    return study


def execute_shard(
    plan: RunPlan, bodies: Sequence[tuple[str, Body]], out: Path, shard: tuple[int, int], monitor: RunMonitor
) -> None:
    """Make the signals of a part of a study, such as (17, 400), on each body; a typer.Exit if that fails."""
    (part, parts), whole = shard, plan.library
    plan = replace(plan, library=replace(whole, clips=whole.clips[part - 1 :: parts]))
    called = f"{part}-of-{parts}"
    for name, body in bodies:
        place = out if len(bodies) == 1 else out / name
        with _in_folder(place, monitor):
            folder.check_results(place, plan.library, ())
            folder.make_folders(place, len(whole.clips))
            monitor.begin(plan.library, body.name, place, kept=False)
            with folder.only_shard(place / WORK, called), closing(plan.crew):
                clips = make_signals(plan, body, place, monitor, called).clips
        console_tables.show_skipped(clips, plan.library, monitor.console, plan.verbose)
        used = sum(result.used for result in clips)
        text = f"{used} of {len(clips)} clips are done. Without --shard, the same command ranks all."
        monitor.console.print(text)


@contextmanager
def _in_folder(out: Path, monitor: RunMonitor) -> Iterator[None]:
    """End the command with a sentence and an exit code if a run has no result."""
    try:
        yield
    except NO_RESULT as error:
        raise ended(f"No result: {sentence_of(error)}", NOTHING_TO_DO, monitor) from error
    except ForeignFileError as error:
        raise ended(str(error), USAGE, monitor) from error
    except folder.FolderBusyError as error:
        raise ended(str(error), BUSY, monitor) from error
    except OSError as error:
        text = f"No result: {out} cannot be written: {error.strerror or error}. What is finished is kept."
        raise ended(text, NOTHING_TO_DO, monitor) from error


def _execute(
    plan: RunPlan, body: Body, out: Path, inputs: str, monitor: RunMonitor
) -> tuple[Study | None, dict[str, str]]:
    """The study, or None if its results are all there, and what could not be drawn, with the reason."""
    try:
        baked = make_signals(plan, body, out, monitor)
        if not plan.again and is_current(plan, baked, out):
            note_current(plan, baked, out, inputs)
            monitor.announce("finished")
            return None, {}
        with claimed(out, _written_by(plan)), draw.drawing(out) as pictures:
            if plan.pictures:  # maps are drawn as soon as there is a ranking
                pictures.get_ready()
            ranked = rank_study(plan, baked, out, monitor)
            mapped = pictures.begin if plan.pictures else lambda _: None
            study = choose_in_study(plan, baked, ranked, monitor, mapped)
            with monitor.step("writing results"):
                mark_changing(out)
                write_results(study)
                write_config(study)
                if plan.pictures:
                    pictures.save()
                if plan.report:
                    write_report(out, by=None)
            # last, for Blender may fail to draw where all else is well
            failed = pictures.finish(study.results.utility.activities, monitor) if plan.pictures else {}
    except NO_RESULT as error:
        monitor.announce("failed", sentence_of(error))
        mark_changing(out)
        clips = error.clips if isinstance(error, StudyError) else ()
        if isinstance(error, StudyError):  # an earlier run's results would contradict the summary
            results = {*folder.TABLES, draw.BLEND, REPORT, *plan.more} - {folder.SUMMARY, CLIP_LIST}
            remove_written(out, lambda name: name in results or name.startswith(f"{folder.HEATMAPS}/"))
        with claimed(out, [folder.SUMMARY, CLIP_LIST]):
            write_failure(out, plan.library, sentence_of(error), clips)
        if isinstance(error, StudyError):
            mark_whole(out)
            console_tables.show_skipped(clips, plan.library, monitor.console, plan.verbose)
            durations = [result.details["duration_s"] for result in clips if result.used]
            found = window_caution(plan.config.windows.length_s, durations)
            console_tables.show_cautions([found] if found.text else [], monitor.console)
        raise
    if not failed:
        note_current(plan, baked, out, inputs)
    monitor.announce("finished", "; ".join(f"no {name}: {why}" for name, why in failed.items()))
    return study, failed


def _say_unchanged(out: Path, monitor: RunMonitor) -> dict[str, int]:
    """Say that an earlier run's results are those of this one, too; returns the counts of its clips."""
    summary = json.loads((out / folder.SUMMARY).read_text(encoding="utf-8"))
    monitor.console.print(f"\n{summary['answer']['sentence']}", style="bold")
    console_tables.show_cautions(below([Caution(**each) for each in summary["cautions"]]), monitor.console)
    monitor.console.print(f"Nothing has changed since the last run, whose results are in {out} as they were.")
    return summary["clips"]


def check_folder(plan: RunPlan, out: Path) -> None:
    """Refuse a results folder, by a ForeignFileError, in which a foreign file is in the run's way."""
    pictures = folder.picture_files(plan.library.activities) if plan.pictures else []
    drawn = [f"{folder.HEATMAPS}/{file}" for file in pictures]
    folder.check_results(out, plan.library, [*_written_by(plan), *drawn, *plan.more])


def ready_for(plan: RunPlan, asked: StudyOptions, out: Path) -> list[tuple[str, Body]]:
    """The bodies asked for, after all checks that can refuse the run.

    A ValueError or NoBlenderError says that a body is not understood, fewer than two activities can be
    tested, a foreign file is in the way, or Blender's module is missing.
    """
    clips = plan.library.clips
    subjects = [clip.subject for clip in clips] if plan.config.by_subject else None
    keys = [clip.motion_key or clip.name for clip in clips]
    with restated(lambda error: f"--by-subject: {error} (--labels)" if subjects else str(error), ValueError):
        check_testable([clip.activity for clip in clips], keys, subjects)
    if any(clip.needs_blender for clip in clips):
        check_installed()
    bodies = parse_bodies(asked.bodies)
    if len(bodies) > 1:
        check(out, [COMPARISON])
        for name, _ in bodies:  # one folder is checked when its run begins
            check_folder(plan, inside(out, name))
    return bodies


def _written_by(plan: RunPlan) -> list[str]:
    """All that a run writes into its folder but clips, heatmaps and what its command adds."""
    return [*folder.TABLES, *([draw.BLEND] if plan.pictures else ()), *([REPORT] if plan.report else ())]


def execute_bodies(
    plan: RunPlan, bodies: Sequence[tuple[str, Body]], out: Path, strict: bool, monitor: RunMonitor
) -> list[tuple[str, Study]]:
    """Run a study on each body, each of several in a folder of its own, and compare them.

    A typer.Exit has the exit code where there is no result, or clips were skipped and `strict` forbids it.
    """
    places = [(name, body, out if len(bodies) == 1 else out / name) for name, body in bodies]
    done = [(name, execute(plan, body, place, monitor)) for name, body, place in places]
    studies = [(name, study) for name, study in done if study is not None]
    if len(bodies) > 1:
        console_tables.show_comparison(write_comparison(studies, out), monitor.console)
    if strict and any(len(study.used) < len(study.clips) + len(plan.library.skipped) for _, study in studies):
        raise ended("Clips were skipped, and --strict was given.", SKIPPED, monitor)
    return studies


def write_comparison(studies: Sequence[tuple[str, Study]], out: Path) -> dict[str, Any]:
    """Write and return `bodies.json`: each body's best spot and set to wear, and how far their maps agree."""
    bodies = {}
    for name, study in studies:
        advice, patches = study.advice, study.results.patches
        worn = None if advice.worn is None else [patches.names[patch] for patch in advice.worn.order]
        bodies[name] = {
            "body": study.body.name,
            "height_m": round(study.body.height, 3),
            "best_single_patch": patch_content(advice.best, study.results.utility, patches),
            "worn_together": worn,
        }
    pairs = combinations(studies, 2)
    agreement = [{"bodies": [first, second], **_agreement(a, b)} for (first, a), (second, b) in pairs]
    content = {"bodies": bodies, "agreement": agreement}
    with claimed(out, [COMPARISON]):
        write_json(out / COMPARISON, content)
    return content


def _agreement(first: Study, second: Study) -> dict[str, Any]:
    """Spearman's rho of two maps over the same patches, of the mean and by activity."""
    a, b = first.results.utility, second.results.utility
    mean = rank_agreement(a.mean, b.mean, a.mean_samples, b.mean_samples)
    by_activity = {}
    for name in (name for name in a.activities if name in b.activities):
        maps = a.f1[:, a.activities.index(name)], b.f1[:, b.activities.index(name)]
        by_activity[name] = json_number(rank_agreement(*maps).spearman)
    return {
        "spearman_mean": json_number(mean.spearman),
        "interval": [json_number(mean.low), json_number(mean.high)],
        "spearman_by_activity": by_activity,
    }
