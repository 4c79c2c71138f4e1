# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study rehab`: the paper's use case, four rehabilitation activities, and its figure."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from w2w.core.colours import patch_colours, score_range
from w2w.core.results_folder import StudyResults
from w2w.core.selection.subsets import Subset, best_single
from w2w.core.study import StudyConfig

from ..needs_blender import needs_blender
from ..reports.console_tables import wide_console
from ..reports.draw import draw_alone
from ..reports.pictures import MAX_LISTED
from ..reports.report_data import title
from ..runs.workers import Engine
from .demo import rehabilitation_study

FIGURE = "figure.png"


def rehab(
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the library and the results.")] = Path(
        "rehab_study"
    ),
    clips: Annotated[int, typer.Option(min=2, help="Clips an activity.")] = 12,
    target: Annotated[
        float, typer.Option(min=0.01, max=1, help="F1 that the set of sensors shall reach.")
    ] = 0.90,
    patches: Annotated[int, typer.Option(min=2, max=6890, help="Places on the body.")] = 512,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the library and of the study.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Clips worked on at the same time.")] = os.cpu_count()
    or 1,
    pictures: Annotated[bool, typer.Option(help="Draw single heatmaps and save study.blend, too.")] = True,
) -> None:
    """The paper's use case on W2W's own library: sit to stand, stairs, arm raise, one-leg stand.

    Finds the map of each activity, the mean map, the best single place and the smallest set that
    reaches the target, and draws them as the paper's figure: `OUT/results/figure.png`.

    Exit codes: as `w2w run`.
    """
    console = wide_console()
    config = StudyConfig(patches=patches, target=target, seed=seed)
    study = rehabilitation_study(out, clips, config, Engine(workers), pictures, console)
    with console.status("Drawing the figure"):
        failed = draw_alone(draw_figure, study.results.out, study.advice.subset)
    if failed:
        console.print(f"No figure: {failed}.", style="red", markup=False)
    else:
        console.print(f"Figure:   {study.results.out / FIGURE}")


def draw_figure(out: Path, subset: Subset) -> None:
    """Draw a finished study's maps by activity, mean map and set on one page, all in the same colours."""
    with needs_blender():
        from w2w.scene.render import BodyRenderer

    from ..reports.panel_figure import Map, panel_figure  # matplotlib is slow to import

    study = StudyResults.load(out)
    utility, patches, body = study.utility, study.patches, study.body()
    scale = score_range(utility.expected_f1, utility.colour_span)
    order = list(subset.order[:MAX_LISTED])

    with BodyRenderer(body) as renderer:

        def drawn(scores: np.ndarray, heading: str, best: int) -> Map:
            note = f"best: {patches.names[best]} ({scores[best]:.2f})"
            return Map(renderer.render(patch_colours(patches, scores, *scale)), heading, note)

        activities = [
            drawn(scores, title(name), int(scores.argmax()))
            for name, scores in zip(utility.activities, utility.expected_f1.T, strict=True)
        ]
        mean = drawn(utility.expected_mean, "Expected mean F1", best_single(utility))
        corners = body.vertices[patches.triangles[order]]
        normals = body.vertex_normals[patches.triangles[order]].mean(axis=1)
        places = renderer.locate(corners.mean(axis=1), normals)
    count = f"{len(subset.order)} sensor{'' if len(subset.order) == 1 else 's'}"
    panel_figure(
        out / FIGURE,
        activities,
        mean,
        Map(mean.views, count, subset.sentence()),
        places,
        [patches.names[patch] for patch in order],
        subset.mean_max_after_each[: len(order)],
        scale,
        subset.target,
    )
