# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w study mixamo`: six groups of activities at eleven placements, usual and unusual."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, NamedTuple

import typer
from rich.console import Console
from rich.table import Table

from w2w.core.csv_tables import csv_text
from w2w.core.files import write_text
from w2w.core.library.labels import same_label
from w2w.core.library.library import Library, read_library
from w2w.core.ranking.weights import check_counting
from w2w.core.study.results import StudyResults
from w2w.core.study.signals import place_patches
from w2w.headless.commands.execute import execute_bodies, ready_for, refused
from w2w.headless.options import with_options
from w2w.headless.runs.own_files import claimed, keep_apart
from w2w.headless.runs.study import RunPlan
from w2w.headless.study_options import StudyOptions

from ..placements.activity_groups import (
    FEWEST_MOTIONS,
    PAPER_GROUPS,
    PER_GROUP,
    choose_activities,
    named_by_paper,
)
from ..placements.comparison import PatchDifference, compare_patches
from ..placements.placement_patches import UNUSUAL, placement_patches
from ..placements.placement_study import CLAIMS, PAGES, write_placement_study
from ..placements.score_table import score_table
from ..placements.score_text import show_scores, write_scores
from ..placements.trends import check_claims, read_claims
from .consoles import show_caution, wide_console
from .tables import TABLES, read_groups

COMPARISON = "unusual_places.csv"
WRITTEN = (TABLES, COMPARISON, *PAGES)
VERDICTS = {1: "better", 0: "cannot be told", -1: "worse"}


@with_options(StudyOptions)
def mixamo(
    library: Annotated[Path, typer.Argument(metavar="LIBRARY", help="Folder of motion files.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; made if missing.")],
    labels: Annotated[
        Path | None,
        typer.Option(
            help="csv with columns file, activity and, unless --groups, group.  [default: the paper's "
            "activities, by Mixamo's names of clips]",
            show_default=False,
        ),
    ] = None,
    groups: Annotated[Path | None, typer.Option(help="csv with columns activity, group.")] = None,
    activities: Annotated[
        str,
        typer.Option(
            help="Activities to take, comma-separated, where the library has them.  "
            "[default: those with the most motions]"
        ),
    ] = "",
    per_group: Annotated[int, typer.Option(min=1, help="Activities of each group.")] = PER_GROUP,
    side: Annotated[str, typer.Option(help="Side of the placements on both sides: left or right.")] = "left",
    claims: Annotated[
        Path,
        typer.Option(
            help="csv with columns claim, group, regions, against: sentences about parts of the body to be "
            "held against the ranking.  [default: the paper's]",
            show_default=False,
        ),
    ] = CLAIMS,
    *,
    asked: StudyOptions,
) -> None:
    """The paper's main study on your own library: six groups of four activities at 11 placements.

    Prints F1 by activity and by group at the 8 common and 3 unusual placements (`tables.csv`), and
    compares each unusual one with each common one (`unusual_places.csv`), holds claims against the
    ranking (`trends.csv`) and draws the paper's figure 4 (`activities_by_placement.png`, in `study.md`),
    besides all that `w2w run` writes; it takes every option of `w2w run`. The activities of a group are
    those with the most motions, or those of --activities.

    Exit codes: as `w2w run`.
    """
    console = wide_console()
    monitor = asked.monitor(console)
    with refused(monitor):
        config = asked.config()
        keep_apart(library, out)
        if side not in ("left", "right"):
            raise ValueError(f"--side is left or right, not {side}")
        found = read_library(library, labels, asked.exact_labels, own_labels=False)
        every = len(found.clips)
        if labels is None:
            found, group_of = named_by_paper(found)
        if groups or labels:
            group_of = read_groups(groups or labels, found.activities)
        check_counting(found.activities, config.background, config.weights)
        without = set(map(same_label, config.background))
        group_of = {name: group for name, group in group_of.items() if same_label(name) not in without}
        named = named_activities(activities, found, group_of)
        chosen = choose_activities(found, named.group_of, named.per_group or per_group)
        said = read_claims(claims)
        taken = only(found, chosen, config.background)
        plan = RunPlan(taken, config, asked.engine(), asked.pictures, asked.report, WRITTEN)
        bodies = ready_for(plan, asked, out)
        check_claims(said, PAPER_GROUPS, bodies[0][1])
        for _, body in bodies:
            placement_patches(body, place_patches(body, config), side, lambda _: None)
    show_groups(chosen, 0 if activities else per_group, console)
    for sentence in named.missing:
        console.print(sentence, style="yellow")
    left = every - len(plan.library.clips)
    if left:
        console.print(f"Clips of other activities, which take no part: {left}.")
    studies = execute_bodies(plan, bodies, out, asked.strict, monitor)
    group_of = {name: group for group, names in chosen.items() for name in names}
    for _, study in studies:
        results = StudyResults.load(study.results.out)
        with claimed(results.out, WRITTEN):
            show_placements(results, group_of, side, console)
            write_placement_study(results, group_of, side, said, named.missing, console)
    monitor.log("finished", exit_code=0)


class Named(NamedTuple):
    """Activities that were asked for by name."""

    group_of: dict[str, str]  # group of each activity that may be taken
    per_group: int  # most activities of a group; 0 where none was asked for by name
    missing: list[str]  # what was asked for and cannot be taken, in sentences


def named_activities(text: str, library: Library, group_of: Mapping[str, str]) -> Named:
    """The activities that `--activities` names, in any case and spelling of spaces.

    Raises ValueError if the library has none of them.
    """
    given = {same_label(name): name.strip() for name in text.split(",") if name.strip()}
    if not given:
        return Named(dict(group_of), 0, [])
    there = {same_label(name): name for name in library.activities}
    found = [there[key] for key in given if key in there]
    absent = [name for key, name in given.items() if key not in there]
    if not found:
        raise ValueError(f"--activities: the library has none of {', '.join(given.values())}")
    loose = [name for name in found if name not in group_of]
    motions = {name: _motions(library, name) for name in found}
    few = [name for name, count in motions.items() if count < FEWEST_MOTIONS and name not in loose]
    missing = [
        f"{what}: {', '.join(names)}."
        for what, names in (
            ("Asked for, but not in the library", absent),
            ("Asked for, but in no group (see --groups)", loose),
            (f"Asked for, but with fewer than {FEWEST_MOTIONS} motions", few),
        )
        if names
    ]
    return Named({name: group_of[name] for name in found if name in group_of}, len(found), missing)


def _motions(library: Library, activity: str) -> int:
    return len({clip.motion_key or clip.name for clip in library.clips if clip.activity == activity})


def only(library: Library, chosen: Mapping[str, tuple[str, ...]], background: Iterable[str] = ()) -> Library:
    """The library's clips of the chosen activities, and of those to be told from them."""
    names = {name for members in chosen.values() for name in members}
    names |= {name for name in library.activities if same_label(name) in set(map(same_label, background))}
    return replace(library, clips=tuple(clip for clip in library.clips if clip.activity in names))


def show_groups(chosen: Mapping[str, tuple[str, ...]], per_group: int, console: Console) -> None:
    """Print the activities of each group, and which groups have fewer than asked for."""
    table = Table(title="Groups of activities", title_justify="left")
    table.add_column("group")
    table.add_column("activities", overflow="fold")
    for group, names in chosen.items():
        short = "" if len(names) >= per_group else f" (of {per_group} asked for: the library has no more)"
        table.add_row(group.replace("_", " "), (", ".join(names) or "none") + short)
    console.print(table)


def show_placements(study: StudyResults, group_of: Mapping[str, str], side: str, console: Console) -> None:
    """Print and write both tables and the comparison of unusual placements with common ones."""
    found = placement_patches(study.body(), study.patches, side, lambda text: show_caution(text, console))
    patch_of = {name: near.patch for name, near in found.items()}
    columns, patches = list(patch_of), list(patch_of.values())
    rows = score_table(study.utility, patches, group_of)
    show_scores(rows, columns, f"F1 at the placements, {side} side", console)
    write_scores(study.out / TABLES, rows, columns, patches, study.utility)
    unusual = [name for name in found if name in UNUSUAL]
    common = [name for name in found if name not in UNUSUAL]
    tested = [name for name in dict.fromkeys(group_of.values()) if name]
    members = {
        group: [name for name in study.utility.activities if group_of.get(name) == group] for group in tested
    }
    compared = {
        group: compare_patches(
            study.utility, [patch_of[name] for name in unusual], [patch_of[name] for name in common], names
        )
        for group, names in {**members, "": list(study.utility.activities)}.items()
        if names and unusual and common
    }
    _show_comparison(compared, unusual, common, console)
    write_text(study.out / COMPARISON, _as_csv(compared, unusual, common))
    console.print(f"Tables: {study.out / TABLES}, {study.out / COMPARISON}")


def _show_comparison(
    compared: Mapping[str, PatchDifference], unusual: list[str], common: list[str], console: Console
) -> None:
    table = Table(title="Unusual placements against the common ones", title_justify="left")
    for name in ("activities", "unusual placement"):
        table.add_column(name)
    table.add_column("mean F1", justify="right")
    for name in ("better than", "cannot be told from", "worse than"):
        table.add_column(name, overflow="fold")
    for group, found in compared.items():
        verdicts = found.verdicts()
        for number, name in enumerate(unusual):
            lists = [
                ", ".join(
                    f"{other} ({found.difference[number, column]:+.2f})"
                    for column, other in enumerate(common)
                    if verdicts[number, column] == verdict
                )
                for verdict in (1, 0, -1)
            ]
            table.add_row(group.replace("_", " ") or "all", name, f"{found.f1[number]:.2f}", *lists)
    console.print(table)
    console.print(
        "In brackets the difference of mean F1. 'Better' and 'worse': the 95 % interval of the difference, "
        "by a bootstrap over clips that both placements share, does not hold 0; of 24 such comparisons about "
        "one comes out so by chance.",
        style="dim",
    )


def _as_csv(compared: Mapping[str, PatchDifference], unusual: list[str], common: list[str]) -> str:
    lines = [["group", "unusual", "f1", "common", "common_f1", "difference", "low", "high", "verdict"]]
    for group, found in compared.items():
        verdicts = found.verdicts()
        for row, name in enumerate(unusual):
            for column, other in enumerate(common):
                numbers = (found.difference[row, column], found.low[row, column], found.high[row, column])
                scores = (f"{found.f1[row]:.6f}", other, f"{found.other_f1[column]:.6f}")
                verdict = VERDICTS[int(verdicts[row, column])]
                lines.append([group or "all", name, *scores, *(f"{value:.6f}" for value in numbers), verdict])
    return csv_text(lines)
