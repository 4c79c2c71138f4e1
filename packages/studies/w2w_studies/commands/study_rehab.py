# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study rehab`: the paper's use case, four rehabilitation exercises, done well and badly."""

import os
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from w2w.core.body.body import Body
from w2w.core.colours import Scale
from w2w.core.library.library import Library, read_library
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection.scored import best_single
from w2w.core.study.config import StudyConfig
from w2w.core.study.results import StudyResults
from w2w.headless.commands.execute import check_folder, execute, refused
from w2w.headless.options import sensor_settings
from w2w.headless.reports.console_tables import show_labels
from w2w.headless.reports.draw import MAX_LISTED, draw_alone
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import claimed
from w2w.headless.runs.study import RunPlan
from w2w.headless.runs.workers import Engine
from w2w.headless.study_options import declared
from w2w.report.page import title

from ..paper.sets import paper_sets
from ..paper.subsets import Subset
from ..rehab.background import BACKGROUND
from ..rehab.executions import FAULTS, WELL
from .consoles import wide_console
from .demo_library import LABELS, Take, write_library_once

FIGURE = "figure.png"

SOURCE = "generated"
"""Source of all clips, though each exercise lies in a folder of its own."""

AGES = (22.0, 85.0)
"""Years between which people's ages are drawn."""


def rehab(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the library and the results.")] = Path(
        "rehab_study"
    ),
    clips: Annotated[
        int, typer.Option(min=2, help="People; each does every exercise well and badly, and what is between.")
    ] = 12,
    target: Annotated[float, declared("target", help="F1 that the set of sensors shall reach.")] = 0.90,
    every_activity: Annotated[float, declared("every_activity")] = 0.9,
    sensor: Annotated[str, declared("sensor")] = "watch",
    quality: Annotated[
        bool, typer.Option(help="Ask the second question, too: which exercise was done well, which badly.")
    ] = True,
    patches: Annotated[int, declared("patches", help="Patches on the body.")] = 512,
    seed: Annotated[int, declared("seed", help="Seed of the library and of the study.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Clips worked on at the same time.")] = os.cpu_count()
    or 1,
    pictures: Annotated[bool, typer.Option(help="Draw single heatmaps and save study.blend, too.")] = True,
) -> None:
    """The paper's use case on W2W's own library: sit to stand, stairs, arm raise, one-leg stand.

    People of several builds and ages do each exercise well and once with a fault (compensating trunk,
    half range, slow, shaky, one-sided); standing, sitting, reaching and walking are background. One person at
    a time is left out. Finds the map of each exercise, the mean map, the best single patch and the smallest
    set that reaches the target for the mean and for every exercise: `OUT/results`, drawn as the paper's
    figure in `figure.png`. `OUT/quality` answers the second question: done well or badly.

    Exit codes: as `w2w run`.
    """
    console = wide_console()
    library, monitor = out / "library", RunMonitor(console)
    with refused(monitor):
        config = StudyConfig(
            patches=patches,
            target=target,
            every_activity=every_activity,
            **sensor_settings(sensor),
            by_subject=True,
            background=tuple(BACKGROUND),
            seed=seed,
        )
        plan = RunPlan(Library(library, (), ""), config, Engine(workers=workers), pictures, more=(FIGURE,))
        check_folder(plan, out / "results")
        if quality:
            check_folder(plan, out / "quality")
    write_library_once(library, rehab_takes, clips, seed, monitor)
    found = read_library(library, library / LABELS)
    show_labels(found, console)
    plan = replace(plan, library=found)
    study = execute(plan, Body.bundled(), out / "results", monitor)
    with console.status("Drawing the figure"), claimed(study.results.out, [FIGURE]):
        failed = ""
        if pictures:
            subset = paper_sets(study.results, config).greedy
            failed = draw_alone(partial(draw_figure, study.results.out, subset=subset))
    if failed:
        console.print(f"No figure: {failed}.", style="red")
    elif pictures:
        console.print(f"Figure:   {study.results.out / FIGURE}")
    if quality:
        console.print("\nDone well or badly?", style="bold")
        asked = replace(plan, library=by_quality(found, clips), config=replace(config, background=()))
        execute(asked, Body.bundled(), out / "quality", monitor)


def rehab_takes(clips: int) -> list[Take]:
    """Every exercise, done well and badly by so many people, the faults in turn, and the background."""
    takes = []
    for number in range(clips):
        for activity, faults in FAULTS.items():
            fault = faults[number % len(faults)]
            takes += [
                Take(_file(activity, WELL, number), activity, number, WELL, AGES),
                Take(_file(activity, fault, number), activity, number, fault, AGES),
            ]
        takes += [Take(_file(name, "", number), name, number, WELL, AGES) for name in BACKGROUND]
    return takes


def by_quality(library: Library, clips: int) -> Library:
    """The exercises of a library, each as two activities: done well, and done badly."""
    done = {
        take.file: f"{take.activity} {WELL if take.execution == WELL else 'badly'}"
        for take in rehab_takes(clips)
        if take.activity in FAULTS
    }
    kept = [clip for clip in library.clips if clip.file in done]
    asked = tuple(replace(clip, activity=done[clip.file], source=SOURCE) for clip in kept)
    return replace(library, clips=asked)


def _file(activity: str, execution: str, number: int) -> str:
    words = " ".join(f"{activity} {execution}".replace("_", " ").split())
    return f"{activity}/{words.title()} ({number + 1}).fbx"


def draw_figure(out: Path, subset: Subset) -> None:
    """Draw a finished study's maps by activity, mean map and set on one page, all in the same colours."""
    from w2w.drawing.body import BodyPictures

    from ..rehab.panel_figure import Map, panel_figure  # matplotlib is slow to import

    study = StudyResults.load(out)
    utility, patches, body = study.utility, study.patches, study.body()
    scale = Scale.of(utility.expected_f1)
    order = list(subset.order[:MAX_LISTED])

    shaded = BodyPictures(body)

    def drawn(scores: np.ndarray, heading: str, best: int) -> Map:
        note = f"best: {patches.names[best]} ({scores[best]:.2f})"
        return Map(shaded.coloured(scale.colours(patches, scores)), heading, note)

    activities = []
    for number, heading in headings(utility):
        scores = utility.expected_f1[:, number]
        activities.append(drawn(scores, heading, int(scores.argmax())))
    mean = drawn(utility.expected_mean, "Expected mean F1 of the exercises", best_single(utility))
    corners = body.vertices[patches.triangles[order]]
    normals = body.vertex_normals[patches.triangles[order]].mean(axis=1)
    markers = shaded.locate(corners.mean(axis=1), normals)
    count = f"{len(subset.order)} sensor{'' if len(subset.order) == 1 else 's'}"
    panel_figure(
        out / FIGURE,
        activities,
        mean,
        Map(mean.views, count, subset.expected_sentence()),
        markers,
        [patches.names[patch] for patch in order],
        subset.mean_max_after_each[: len(order)],
        (scale.low, scale.high),
        subset.target,
    )


def headings(utility: UtilityMap) -> list[tuple[int, str]]:
    """Number and heading of each activity: exercises first, then the background."""
    names = [title(name) for name in utility.activities]
    exercises = [(number, name) for number, name in enumerate(names) if utility.weights[number]]
    background = [(number, name) for number, name in enumerate(names) if not utility.weights[number]]
    return exercises + [(number, f"{name} (background)") for number, name in background]
