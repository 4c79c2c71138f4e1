# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's messages on the console: the labels it understood, the clips it skipped, its findings."""

from collections.abc import Mapping, Sequence
from typing import Any

from rich.console import Console
from rich.table import Table

from ...core.findings import notes
from ...core.findings.advice_content import called, next_worn
from ...core.findings.cautions import KNOW, OPEN, STOPS, WEAKENS, Caution, below, head
from ...core.findings.summary import best_regions, own_scores, study_counts
from ...core.library.library import Library, not_read_sentence
from ...core.patches.patches import PatchSet
from ...core.ranking.costs import IS_AS_GOOD
from ...core.ranking.utility import UtilityMap
from ...core.selection import headline
from ...core.selection.advice import Advice
from ...core.selection.scored import PlaceScore
from ...core.study.results import REPORT, ClipResult, Study, StudyResults
from ...core.wording import capital, join_words
from ..runs.folder import HEATMAPS
from ..runs.study import RunPlan
from . import draw

STYLES = {STOPS: "bold yellow", WEAKENS: "yellow", KNOW: ""}
"""Styles of cautions by their weight."""

LISTED = 8
"""Most products, activities and reasons listed."""


def _table(title: str, headings: Sequence[str], right: Sequence[str] = ()) -> Table:
    """An empty table, its columns of figures to the right."""
    table = Table(title=title, title_justify="left")
    for heading in headings:
        table.add_column(heading, justify="right" if heading in right else "left", overflow="fold")
    return table


def _say(sentence: str, console: Console, style: str = "yellow") -> None:
    """Print a sentence, if there is one."""
    if sentence:
        console.print(f"{sentence}.", style=style)


def show_labels(library: Library, console: Console, verbose: bool = False) -> None:
    """Print the labelling that was understood."""
    counts = sorted(library.activities.items(), key=lambda entry: -entry[1])
    activities = [f"{activity} {count}" for activity, count in counts]
    title = f"{len(library.clips)} clips of {len(counts)} activities, labelled by {library.labelled_by}"
    console.print(f"{title}: {join_words(activities, len(counts) if verbose else LISTED)}.")
    _say(not_read_sentence(library.unread), console)
    for note in notes.label_notes(library.check):
        console.print(f"Labels: {note}", style="yellow")


def show_outcome(study: Study, plan: RunPlan, failed: Mapping[str, str], console: Console) -> None:
    """Print the answer, what it rests on, the files that hold it, and what could not be drawn."""
    out, utility, patches = study.results.out, study.results.utility, study.results.patches
    show_answer(
        study.advice, utility, [Caution(**each) for each in study.results.summary["cautions"]], console
    )
    placements, base = [name for name, _ in study.config.placements], study.advice.answer.base.under
    show_own_placements(own_scores(placements, utility, patches, base), console)
    show_worn(study.advice, patches, console)
    if plan.verbose:
        _show_regions(study.results, study.advice, console)
    console.print()
    show_skipped(study.clips, study.library, console, plan.verbose)
    console.print(f"{notes.counts_sentence(study_counts(study), utility)}.")
    console.print(f"\nTable:    {out / 'utility.csv'}\nSummary:  {out / 'summary.json'}")
    for title, name in (("Heatmaps:", HEATMAPS), ("Blender: ", draw.BLEND)):
        if plan.pictures and name not in failed:
            console.print(f"{title} {out / name}")
    if plan.report:
        console.print(f"Report:   {out / REPORT}")
    for name, why in failed.items():
        console.print(f"\nNo {name}: {why}.", style="red")
    if failed:
        console.print("Everything else is there; the same command goes on from here.")


def show_cautions(cautions: Sequence[Caution], console: Console) -> None:
    """Print what speaks against the answer, the heaviest first."""
    for caution in cautions[:OPEN]:
        console.print(caution.sentence(), style=STYLES[caution.weight], markup=False)
    if more := cautions[OPEN:]:
        console.print(f"{len(more)} more to know: see summary.json or the report.")


def _show_regions(results: StudyResults, advice: Advice, console: Console) -> None:
    figures = ("expected F1", "95 % interval", "as good", "on these clips")
    title = "Best regions (each by its best patch, mean over activities)"
    table = _table(title, ("patch", *figures), right=figures)
    utility = results.utility
    for row in best_regions(utility, results.patches, advice.answer.base.under, advice.allowed):
        interval = notes.interval_text(row["low"], row["high"], headline.mean_caution(utility))
        equal = "yes" if row["as_good"] else "no"
        table.add_row(row["name"], f"{row['expected']:.3f}", interval, equal, f"{row['f1']:.3f}")
    console.print(table)


def show_skipped(
    results: Sequence[ClipResult], library: Library, console: Console, verbose: bool = False
) -> None:
    """Print how many files were skipped for which reason; every file with `verbose`."""
    files_of: dict[str, list[str]] = {}
    unused = [(result.clip.file, result.reason) for result in results if not result.used]
    for file, reason in (*unused, *library.skipped):
        files_of.setdefault(reason, []).append(file)
    if not files_of:
        return
    console.print(f"{sum(map(len, files_of.values()))} clips skipped:", style="yellow")
    by_count = sorted(files_of.items(), key=lambda entry: -len(entry[1]))
    shown = by_count if verbose else by_count[:LISTED]
    for reason, files in shown:
        console.print(f"  {len(files)}: {reason} ({join_words(files, len(files) if verbose else 1)})")
    if len(by_count) > len(shown):
        console.print(f"  and {len(by_count) - len(shown)} more reasons: --verbose lists them")


def show_comparison(comparison: dict[str, Any], console: Console) -> None:
    """Print how far the maps of several bodies agree."""
    figures = ("rho", "95 % interval")
    title = "How far the maps agree (Spearman's rho of mean F1 over patches)"
    table = _table(title, ("bodies", *figures), right=figures)
    for pair in comparison["agreement"]:
        low, high = pair["interval"]
        table.add_row(" and ".join(pair["bodies"]), f"{pair['spearman_mean']}", f"{low} to {high}")
    console.print(table)


def show_answer(
    advice: Advice,
    utility: UtilityMap,
    cautions: Sequence[Caution],
    console: Console,
    simulated: bool = True,
) -> None:
    """Print where to wear one sensor, on which products, how sure that is and what speaks against it."""
    sentence = head(advice.answer.sentence(), cautions)
    console.print(f"\n{sentence}", style="bold", markup=False)
    _say(advice.answer.detail().removesuffix("."), console, "")
    _say(advice.answer.measured(), console, "")
    recommended = advice.answer.differs and sentence == advice.answer.sentence()
    products = advice.answer.products
    habit = [each for each in products[LISTED:] if each == advice.answer.habit]
    show_places(
        [*products[:LISTED], *habit], console, advice.answer.caution, "recommended" if recommended else ""
    )
    _say(headline.mean_sentence(utility), console, "")
    _say(headline.repeat_sentence(utility, simulated), console, "")
    show_cautions(below(cautions), console)


def show_places(
    scores: Sequence[PlaceScore], console: Console, caution: str = "", first: str = "recommended"
) -> None:
    """Print one sensor on each of some products, or at places by name; `first` is said of the best.

    A `caution` stands in place of all intervals.
    """
    if not scores:
        return

    def with_interval(value: float, low: float, high: float) -> str:
        about = "" if caution else f" ({headline.short(low)} to {headline.short(high)})"
        return headline.short(value) + about

    title = f"One sensor on ({caution or 'in brackets: 95 % intervals'})"
    table = _table(title, ("", "F1", "costs", ""), ("F1", "costs"))
    for score in scores:
        apart = score.cost.low < score.cost.high  # from the recommended place
        table.add_row(
            f"{score.side} {score.name}".strip(),
            with_interval(*score.f1),
            with_interval(*score.cost) if apart else "",
            score.cost.verdict() if apart else first,
        )
        first = first if apart else IS_AS_GOOD
    console.print(table)


def show_need(need: Mapping[str, Any], console: Console) -> None:
    """Print how cheap the sensor at a place may be (`advice_content.need_content`)."""
    console.print(f"\n{capital(need['place'])}: F1 {headline.short(need['f1'])} as run.", style="bold")
    _say(need["sentence"], console, "bold")
    if not need["rows"]:
        return
    table = _table(NEED, ("", "as run", "works down to", "costs", "next", "costs"), ("as run", "costs"))
    for row in need["rows"]:
        cells = []
        for value in (row.get("cheapest"), row.get("next")):
            name = value["value"] if value and value["value"] != row["parameter"] else ""
            cells += [name, headline.short(max(0.0, value["costs"])) if value else ""]
        table.add_row(row["parameter"], row["as_run"], *cells)
    console.print(table)
    parts = [f"{part['value']} at {part['rate_hz']:g} Hz" for part in need["parts"]]
    _say(f"Parts that do: {', '.join(parts)}" if parts else "", console, "")


NEED = "Trained and tested with a cheaper part, one thing at a time"


def show_worn(advice: Advice, patches: PatchSet, console: Console) -> None:
    """Print the sensors to wear together, what they would reach on other clips, and what to add."""
    worn = advice.worn
    if worn is None:
        console.print("Only the classifier ridge chooses sets to wear together.", style="yellow")
        return
    console.print(f"{capital(worn.sentence())}.", style="bold")
    for number, (patch, others) in enumerate(zip(worn.order, advice.alternatives, strict=True)):
        f1 = headline.short(worn.promise.mean[number])
        instead = " or ".join(called(other, advice, patches) for other in others)
        so_far = " so far" if number else ""
        text = f"  {number + 1}. {called(patch, advice, patches)}: F1 {f1}{so_far}"
        console.print(f"{text}; instead: {instead}" if instead else text)
    if following := next_worn(worn, advice, patches):
        console.print(f"{capital(following['sentence'])}.")


def show_own_placements(placements: Sequence[dict[str, Any]], console: Console) -> None:
    """Print the placements, if there are any (`findings.summary.own_scores`)."""
    if not placements:
        return
    figures = ("expected F1", "rank", "costs")
    table = _table("Your placements", ("placement", "region", *figures, ""), right=figures)
    for placement in placements:
        rank = f"{placement['rank']} of {placement['of']}"
        f1, costs = headline.short(placement["expected_f1"]), headline.short(placement["costs"])
        table.add_row(placement["name"], placement["region"], f1, rank, costs, placement["verdict"])
    console.print(table)
