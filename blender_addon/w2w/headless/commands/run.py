# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run`: a folder of motion files in, heatmaps and a sensor recommendation out."""

import re
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

from ...core.body.body import Body
from ...core.findings.cautions import subjects_sentence
from ...core.library.labels import same_label
from ...core.library.library import Library, read_library
from ...core.ranking.weights import check_counting
from ...core.reading.look import lacking_rests, look_rests, look_up
from ...core.reading.reader import Reader
from ...core.study.ranking import known_motions
from ...core.threads import Spread
from ..config_file import take_options
from ..console import NOTHING_TO_DO, Terminal
from ..options import argument, option, with_options, words
from ..reports.console_tables import show_labels
from ..runs.monitor import RunMonitor
from ..runs.own_files import keep_apart
from ..runs.records import given_up_in, lists_in
from ..runs.study import RunPlan, placed_on
from ..study_options import RUN, StudyOptions
from .execute import check_folder, ended, execute_bodies, execute_shard, ready_for, refused


@with_options(StudyOptions)
def run(
    library: Annotated[
        Path,
        argument(
            "LIBRARY",
            "Folder of motion files (FBX, BVH, AMC, npz; csv, npy or json of joints), searched with "
            "its subfolders.",
        ),
    ],
    out: Annotated[Path, option("Folder for the results; made if missing.", "--out", "-o")],
    labels: Annotated[
        Path | None,
        option(
            "csv with columns file, activity[, subject, source, rate].  [default: labels.csv in LIBRARY, or "
            "names of folders or files]",
            show_default=False,
        ),
    ] = None,
    leave_out: Annotated[str, option("Activities to leave out, comma-separated, e.g. 'other,unknown'.")] = "",
    shard: Annotated[
        str,
        option(
            "Make only the signals of every 400th clip from the 17th (17/400), for job arrays; the same "
            "command without it then ranks all.",
            rich_help_panel=RUN,
        ),
    ] = "",
    config: Annotated[  # noqa: ARG001 - its callback has given all others their values
        Path | None,
        option(
            "TOML file with any of these options (`w2w init` writes one), or a run's config.json; those "
            "given here count more.",
            is_eager=True,
            callback=take_options,
        ),
    ] = None,
    *,
    asked: StudyOptions,
) -> None:
    """Find where on the body to wear a sensor, from a folder of motion files.

    OUT then holds `report.html`, `summary.json`, `clips.jsonl`, `utility.csv`, `heatmaps/*.png`,
    `study.blend`, `motions/*.npz`, `signals/*.npz` and `config.json`. Run the same command again to
    resume a run that was stopped.

    Exit codes: 0 success, 1 no result (the message says why), 2 wrong arguments, 3 clips were skipped
    and --strict was given, 4 another run is using OUT; 130, 143 and 129 stopped by Ctrl-C,
    SIGTERM and SIGHUP.
    """
    console = Terminal()
    monitor = asked.monitor(console)
    with refused(monitor):
        part, parts = part_of(shard) if shard else (1, 1)
        parameters = asked.config()
        keep_apart(library, out)
        found = without(read_library(library, labels, asked.exact_labels), leave_out)
        check_counting(found.activities, parameters.background, parameters.weights)
        engine = asked.engine()
        plan = RunPlan(found, parameters, engine, asked.pictures, asked.report, verbose=asked.verbose)
        bodies = ready_for(plan, asked, out)
        if len(bodies) == 1 and not shard and not lists_in(out):
            check_folder(plan, out)  # before workers start
    with closing(plan.crew), ThreadPoolExecutor(2) as beside:
        look = partial(_looked, bodies=bodies, out=out, beside=beside, monitor=monitor)
        plan = replace(plan, again=asked.strict or asked.verify or len(bodies) > 1)
        if shard:
            execute_shard(look(plan), bodies, out, (part, parts), monitor)
        else:
            show_labels(found, console, asked.verbose)
            if parameters.by_subject and (caution := subjects_sentence(known_motions(found.clips))):
                console.print(f"{caution}.", style="bold yellow", markup=False)
            plan = look(plan) if len(bodies) > 1 else replace(plan, look=look)
            execute_bodies(plan, bodies, out, asked.strict, monitor)
    monitor.log("finished", exit_code=0)


def _looked(
    plan: RunPlan, bodies: Sequence[tuple[str, Body]], out: Path, beside: Executor, monitor: RunMonitor
) -> RunPlan:
    """The plan with what a library's files tell together, which it says; a typer.Exit if a question is left.

    In a first run the crew looks, while patches are placed and skeletons read here; a resume may have nothing
    left to do for it.
    """
    found, engine, crew = plan.library, plan.engine, plan.crew
    first, body = (out, bodies[0][1]) if len(bodies) == 1 else (out / bodies[0][0], Body.bundled())
    spread: Spread = map
    if not engine.scheduler and not lists_in(first):
        crew.get_ready(engine, found.clips)
        spread = crew.spread
        if len(bodies) == 1:
            plan = replace(plan, placed=beside.submit(placed_on, body, plan.config))
    files = [(clip.file, clip.path) for clip in found.clips]
    lacking, limits = beside.submit(lacking_rests, files), engine.limits
    with refused(monitor), Reader(*limits, given_up_in(first, found, engine)) as reader:
        seen = look_up(reader, files, engine.pose, spread)
        rests = look_rests(reader, lacking.result(), body, engine.pose, seen.ups, engine.bone_maps, spread)
    for what, said in (("Up", seen.sentence()), ("Rest poses", rests.sentence())):
        if said:
            monitor.console.print(f"{what}: {said}.")
    if seen.question:
        raise ended(f"No result: {seen.question}.", NOTHING_TO_DO, monitor)
    return replace(plan, engine=replace(engine, ups=seen.ups, rests=rests), deadly=reader.deadly)


def part_of(text: str) -> tuple[int, int]:
    """A part and how many there are, from text such as "17/400"; otherwise a ValueError."""
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text.strip())
    part, parts = map(int, found.groups()) if found else (0, 0)
    if not 1 <= part <= parts:
        raise ValueError(f"--shard is a part and how many there are, such as 17/400, not {text!r}")
    return part, parts


def without(library: Library, activities: str) -> Library:
    """The library less comma-separated activities; a ValueError if one is unknown, or no clip is left."""
    given = {same_label(name): name for name in words(activities)}
    names = {name for name in library.activities if same_label(name) in given}
    unknown = set(given) - {same_label(name) for name in names}
    if unknown:
        raise ValueError(
            f"--leave-out: no clip is labelled {', '.join(sorted(given[name] for name in unknown))}"
        )
    kept = tuple(clip for clip in library.clips if clip.activity not in names)
    if not kept:
        raise ValueError("--leave-out leaves no clip")
    left_out = [clip for clip in library.clips if clip.activity in names]
    dropped = [(clip.file, f"{clip.activity} is left out (--leave-out)") for clip in left_out]
    return replace(library, clips=kept, skipped=(*library.skipped, *dropped))
