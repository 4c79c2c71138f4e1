# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w dsads`: rank the five real sensor sites of DSADS with the code that ranks virtual ones."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.utility import CLASSIFIERS, UtilityMap, inputs_of, utility_map
from w2w.core.windows.features import window_features
from w2w.headless.console import USAGE
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import new_file

from ..datasets.dsads import DSADS_RATE, DSADS_SITES, read_dsads
from ..placements.score_table import score_table
from ..placements.score_text import show_scores, write_scores
from .consoles import wide_console


def dsads(
    data: Annotated[
        Path, typer.Argument(metavar="DATA", help="DSADS as an npz file, or its own folder of a01 to a19.")
    ],
    out: Annotated[Path | None, typer.Option("--out", "-o", help="csv file to write the table to.")] = None,
    classifier: Annotated[str, typer.Option(help=f"One of: {', '.join(CLASSIFIERS)}.")] = "ridge",
) -> None:
    """Rank the real sensors of DSADS (19 activities, 8 people, 5 sites), one person left out at a time.

    Exit codes: 0 ranked, 2 wrong use.
    """
    console = wide_console()
    try:
        if classifier not in CLASSIFIERS:
            raise ValueError(f"'{classifier}' is no classifier; there are {', '.join(CLASSIFIERS)}")
        new_file(out)
        with RunMonitor(console).step("reading DSADS"):
            recordings = read_dsads(data)
        with RunMonitor(console).step("ranking its sites"):
            utility = rank_dsads(recordings, classifier)
    except (ValueError, OSError) as error:
        console.print(str(error), style="red")
        raise typer.Exit(USAGE) from error
    sites = range(len(DSADS_SITES))
    rows = score_table(utility, sites, {})
    show_scores(rows, DSADS_SITES, "F1 at DSADS's five sites", console)
    console.print(f"{utility.protocol}, {utility.classifier}, {len(utility.truth)} windows of 5 s.")
    if out is not None:
        write_scores(out, rows, DSADS_SITES, sites)
        console.print(f"Table: {out}")


def rank_dsads(recordings: tuple, classifier: str = "ridge") -> UtilityMap:
    """Leave-one-subject-out F1 of each site, the segments of DSADS as its windows.

    The segments of one person and activity were cut from one recording: they are one clip.

    `recordings`: from `read_dsads`.
    """
    windows = np.stack([np.concatenate([r.acc, r.gyr], axis=2) for r in recordings]).astype(np.float32)
    windows = windows.transpose(0, 2, 1, 3)
    wants_features = inputs_of(classifier) == "features"
    inputs = window_features(windows, DSADS_RATE) if wants_features else windows
    activity = np.array([recording.activity for recording in recordings])
    subject = np.array([recording.subject for recording in recordings])
    clip = np.array([f"{a}/{s}" for a, s in zip(activity, subject, strict=True)])
    everything = np.ones(len(recordings), dtype=bool)
    names = sorted(set(activity.tolist()))
    return utility_map(inputs, Protocol(activity, clip, subject, everything, names), classifier)
