# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w place`: choose sensors again from a finished ranking, under a designer's constraints."""

import json
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import make_dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from rich.console import Console

from ...core.files import UNFINISHED, new_folder, write_json
from ...core.findings.advice_content import advice_content, needs_on, place_content, with_needs
from ...core.findings.cautions import Caution, cautions
from ...core.findings.summary import PLACEMENTS, map_content, write_map, write_placements
from ...core.imu.cover import cover_sentence
from ...core.parameters import parameters_at, with_values
from ...core.ranking.weights import check_counting
from ...core.selection.advice import Advice
from ...core.selection.headline import mean_caution
from ...core.study.choosing import Choices, compare_places, ranked_again
from ...core.study.clip_files import WORK, is_used, mark_changing, mark_whole
from ...core.study.config import StudyConfig
from ...core.study.results import REPORT, UTILITY, StudyResults
from .. import options
from ..console import USAGE, console_beside, ending, print_json
from ..options import AsJson, argument, option, with_options
from ..reports import draw
from ..reports.console_tables import show_answer, show_places, show_worn
from ..runs.folder import HEATMAPS, only_run, picture_files, remove_unfinished
from ..runs.monitor import RunMonitor
from ..runs.own_files import check, list_written, new_file
from ..study_options import declared, option_kind, values_of
from .report import write_report

REDRAW = "place --redraw"
"""Name of the command for the note in a folder that is being changed."""

CHOICE = parameters_at("choice", StudyConfig)
"""Parameters that can be chosen by again."""

CLEARED = "Activities not to count in the mean, comma-separated; '' for none.  [default: the run's]"

LEFT_BEHIND = ("lock", "holder", "running")
"""Parts of the work folder that belong to the process at work: they are not copied."""


Asked: Any = make_dataclass(
    "Asked",
    [
        (
            name,
            Annotated[
                option_kind(each) | None,
                declared(name, **{"help": CLEARED, "show_default": False} if name == "background" else {}),
            ],
            None,
        )
        for name, each in CHOICE.items()
    ],
    frozen=True,
)


class Wishes(Asked):
    """The options that choose again under other parameters; None is the run's own."""

    def over(self, study: StudyResults) -> StudyConfig:
        """A study's parameters under these wishes; a ValueError says which is wrong."""
        given = {name: getattr(self, name) for name in CHOICE if getattr(self, name) is not None}
        config = with_values(study.config(), values_of(given))
        check_counting({clip.activity for clip in study.clips}, config.background, config.weights)
        return config


@with_options(Wishes)
def place(
    results: Annotated[Path, argument("RESULTS", "Results folder of a finished run.")],
    asked: Wishes,
    compare: Annotated[
        str, option("Compare these, one sensor each, and choose nothing: 'ring, necklace, left thigh front'.")
    ] = "",
    out: Annotated[
        Path | None,
        option(
            "Where to write the choice: a json file, or a new folder, which becomes a copy of RESULTS "
            "with this choice in summary, report, pictures and study.blend.",
            "--out",
            "-o",
        ),
    ] = None,
    redrawn: Annotated[
        bool,
        option(
            "Put this choice in the place of the run's, in RESULTS itself: config, summary, report, "
            "pictures and study.blend.",
            "--redraw",
        ),
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Choose sensors from a finished ranking under constraints, without baking anything again.

    What is not given is as in the run; '' clears the run's constraint.

    RESULTS stays as it is unless --redraw is given.

    Exit codes: 0 chosen, 2 wrong use or constraints that cannot be met (and why), 4 a run is using
    RESULTS or was stopped there.
    """
    console = console_beside(as_json)
    folder = out if out is not None and out.suffix.lower() != ".json" else None
    with ending(USAGE, console):
        study = StudyResults.load(results, by=REDRAW if redrawn else "")
        if compare:
            if folder is not None or redrawn:
                raise ValueError("--compare chooses nothing: give --out a json file, and no --redraw")
            new_file(out)
            scores = compare_places(study, options.words(compare))
            show_places(scores, console, mean_caution(study.utility))
            content = [place_content(score, study.patches) for score in scores]
            if as_json:
                print_json(content)
            if out is not None:
                write_json(out, content)
            return
        config = asked.over(study)
        if folder is not None and folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
            raise ValueError(f"--out {folder} is not empty: give a new folder, or a json file")
        if folder is None:
            new_file(out)
        if redrawn or folder is not None:
            check_redraw(study)
        with console.status("Ranking"):
            study = ranked_again(study, config)
        with console.status("Choosing sensors"):
            choices = Choices(study, config)
            study, advice = choices.study, choices.under(config)
    found = _cautions(study, config, advice)
    show_answer(advice, study.utility, found, console)
    show_worn(advice, study.patches, console)
    if redrawn:
        _redraw(results, study, config, advice, console)
    if folder is not None:
        with ending(USAGE, console), copied(results, folder) as copy:
            _redraw(copy, study, config, advice, console)
    elif out is not None:
        write_json(out, advice_content(advice, study.utility, study.patches, found))
    if as_json:
        print_json(advice_content(advice, study.utility, study.patches, found))
    if out is not None:
        console.print(f"\nWritten to {out}")


def _cautions(study: StudyResults, config: StudyConfig, advice: Advice) -> list[Caution]:
    """The cautions on a folder's clips, ranked again."""
    on_cloth = cover_sentence(study.summary, len(study.patches))
    facts = (entry for entry in study.entries if is_used(entry))
    return cautions(study.utility, study.clips, facts, config, on_cloth, advice.answer.patch)


@contextmanager
def copied(results: Path, folder: Path) -> Iterator[Path]:
    """A copy of a results folder to work in; it gets its name when the block is done."""
    with new_folder(folder) as copy:
        left = shutil.ignore_patterns(*LEFT_BEHIND, f".*{UNFINISHED}")
        shutil.copytree(results, copy, symlinks=True, ignore=left)
        yield copy


def check_redraw(study: StudyResults) -> None:
    """Refuse a results folder, by a ForeignFileError, in which a foreign file is in the way of a drawing."""
    files = [f"{HEATMAPS}/{file}" for file in picture_files(study.utility.activities)]
    check(study.out, [draw.BLEND, REPORT, *files])


def chosen_content(
    study: StudyResults, ranked: StudyResults, config: StudyConfig, advice: Advice
) -> dict[str, Any]:
    """What `summary.json` says of a choice, made from a new ranking of a study."""
    found = _cautions(ranked, config, advice)
    content = advice_content(advice, ranked.utility, ranked.patches, found)
    if np.array_equal(ranked.utility.weights, study.utility.weights):
        content["cards"] = with_needs(content["cards"], needs_on(study.cards))
    content |= map_content(ranked, study.config().placements, advice.answer.base.under)
    return content | {"cautions": [caution._asdict() for caution in found]}


def _redraw(out: Path, ranked: StudyResults, config: StudyConfig, advice: Advice, console: Console) -> None:
    """Write a choice, made from a new ranking, into a results folder: its tables, report and pictures.

    Where another run or a foreign file is in the way, nothing is touched.
    """
    with ending(USAGE, console), only_run(out / WORK):
        study = StudyResults.load(out, by=REDRAW)
        utility, patches = ranked.utility, study.patches
        check_redraw(study)
        tables = ["config.json", "summary.json", PLACEMENTS, UTILITY, "utility.csv"]
        content = chosen_content(study, ranked, config, advice)
        remove_unfinished(out)
        mark_changing(out, by=REDRAW)
        with list_written(out, tables):
            write_map(out, utility, patches, advice.clusters)
            write_placements(out, content["cards"], patches)
            changes = {"config.json": {"parameters": config.as_dict()}, "summary.json": content}
            for name, change in changes.items():
                write_json(out / name, {**json.loads((out / name).read_text(encoding="utf-8")), **change})
        with draw.drawing(out) as pictures:
            pictures.save()
            write_report(out, by=None)
            failed = pictures.finish(study.utility.activities, RunMonitor(console))
        mark_whole(out)
    for name, why in failed.items():
        console.print(f"No {name}: {why}", style="yellow")
