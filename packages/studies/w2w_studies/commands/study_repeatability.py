# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study repeatability`: what halves of a run's clips promise, and what the other halves deliver."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from w2w.core.imu.virtual import at_patches
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import SomePatches
from w2w.headless.console import USAGE, ending
from w2w.headless.study_options import declared

from ..comparisons.repeatability import FIGURES, choices
from .consoles import wide_console


def repeatability(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    halvings: Annotated[int, typer.Option(min=1, help="Ways to halve the clips; both halves choose.")] = 10,
    by_subject: Annotated[bool, typer.Option("--by-subject", help="Halve people instead of clips.")] = False,
    drawn: Annotated[
        bool, typer.Option("--drawn", help="Halve a library of three to eight of the activities each time.")
    ] = False,
    patches: Annotated[int | None, typer.Option(min=2, help="The first patches only.")] = None,
    classifier: Annotated[str | None, declared("classifier")] = None,
) -> None:
    """Let halves of a finished run's clips choose the best patch, and score the choice on the other half.

    Printed are means over all choices (docs/evidence/ranking.md says what the columns are).

    Exit codes: 0 printed, 2 wrong use or clips that cannot be halved.
    """
    console = wide_console()
    with ending(USAGE, console):
        study = StudyResults.load(results)
        usual = study.config()
        config = replace(usual, classifier=classifier or usual.classifier)
        first = at_patches(study.patches, list(range(len(study.patches)))[:patches])
        inputs = SomePatches(study.inputs(config.classifier), np.arange(len(first)))
        with console.status("Ranking halves of the clips"):
            found = choices(
                inputs, study.labels(), config, (first, study.body()), halvings, by_subject, drawn
            )
    console.print(f"{len(found)} choices among {len(first)} patches by {config.classifier}\n")
    known = np.flatnonzero(np.isfinite(found).any(axis=0))
    means = [f"{mean:.3f}" for mean in np.nanmean(found[:, known], axis=0)]
    for cells in ([FIGURES[number] for number in known], ["---"] * len(known), means):
        console.print(f"| {' | '.join(cells)} |")
