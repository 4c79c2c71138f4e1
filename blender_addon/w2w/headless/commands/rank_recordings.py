# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w rank-recordings`: where worn sensors recognise activities best, from their recordings alone."""

import warnings
from pathlib import Path
from typing import Annotated

from ...api.rank import rank
from ...api.ranking import Ranking
from ...core.files import write_json
from ...core.findings.advice_content import advice_content
from ...core.imu.recordings import Recordings
from ...core.selection.headline import repeat_sentence
from ...core.study.results import REPORT
from .. import options
from ..console import USAGE, console_beside, ending, print_json, show_left_out
from ..options import AsJson, argument, option
from ..reports.console_tables import show_answer, show_worn
from ..runs.own_files import published
from ..study_options import declared


def rank_recordings(
    folder: Annotated[
        Path, argument("FOLDER", "Folder of recordings: npz, csv, phone apps' exports, Xsens, x-IMU3.")
    ],
    labels: Annotated[
        Path | None,
        option(
            "csv with columns file, activity and if known subject, clip, place; a file may be a folder.  "
            "[default: labels.csv in FOLDER, else what the files hold, else ACTIVITY/CLIP/PLACE.csv]",
            show_default=False,
        ),
    ] = None,
    places: Annotated[str, option("Rank these places alone, comma-separated: 'left wrist,belt'.")] = "",
    out: Annotated[
        Path | None, option("Folder for report.html, f1.csv and summary.json.", "--out", "-o")
    ] = None,
    window: Annotated[float, declared("window")] = 2.0,
    classifier: Annotated[str, declared("classifier")] = "ridge",
    folds: Annotated[int, declared("folds")] = 5,
    by_subject: Annotated[bool, declared("by_subject")] = False,
    seed: Annotated[int, declared("seed")] = 0,
    as_json: AsJson = False,
) -> None:
    """Rank the places of worn sensors by their recordings alone: no motion and no body is needed.

    All places are compared on the same clips; those that lack a sensor are left out.

    Exit codes: 0 ranked, 2 wrong use or recordings that cannot be used (and why).
    """
    console = console_beside(as_json)
    with ending(USAGE, console):
        recordings = Recordings.read(folder, labels)
        if places:
            recordings = recordings.at(*options.words(places))
        with console.status("Ranking"), warnings.catch_warnings(action="ignore"):  # all is said below
            found = rank(recordings, classifier, window, None, folds, by_subject, seed, lambda _: None)
            advice = found.advice
        if out is not None:
            with published(out, [labels]) as new:
                found.report(new / REPORT)
                found.to_csv(new / "f1.csv")
                write_json(new / "summary.json", _content(found))
    if as_json:
        print_json(_content(found))
    show_answer(advice, found.utility, found.cautions, console, simulated=False)
    show_left_out(found.left_out, console)
    show_worn(advice, found.patches, console)
    for clip, why in found.skipped:
        console.print(f"Left out: {clip}: {why}", style="yellow")
    if out is not None:
        console.print(f"\nReport: {out / REPORT}")


def _content(found: Ranking) -> dict[str, object]:
    """The findings as plain values."""
    return {
        "activities": list(found.activities),
        "left_out": found.left_out,
        "skipped": [list(each) for each in found.skipped],
        "protocol": found.utility.protocol,
        "classifier": found.utility.classifier,
        "cautions": [caution._asdict() for caution in found.cautions],
        **advice_content(found.advice, found.utility, found.patches, found.cautions),
        "map_sentence": repeat_sentence(found.utility, simulated=False),
    }
