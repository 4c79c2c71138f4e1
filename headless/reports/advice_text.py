# SPDX-License-Identifier: GPL-3.0-or-later
"""A choice of sensors in words on the screen and as plain values on file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

import numpy as np
from rich.console import Console
from rich.table import Table

from w2w.core.findings.advice_content import joint_of, next_worn
from w2w.core.findings.counts import interval_caution, interval_text
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection import headline
from w2w.core.selection.advice import Advice
from w2w.core.selection.joint import JointSet
from w2w.core.wording import capital

NOT_PROMISED = (
    "What the set by the paper's algorithm 2 would reach on other clips is not known: that takes the "
    "classifier ridge and a test together. What follows is of these very clips, which flatter it."
)

AT_MOST = 12
"""Sensors listed on the screen; the files have them all."""


def show_best_spot(advice: Advice, utility: UtilityMap, patches: PatchSet, console: Console) -> None:
    """Print where to wear one sensor, and how far these clips tell."""
    if caution := headline.spot_caution(advice.best, utility):
        console.print(f"{caution}.", style="bold yellow")
    console.print(
        f"[bold]{headline.best_spot_sentence(advice.best, utility, patches, advice.allowed)}.[/bold]"
    )
    if len(headline.as_good_as(advice.best, utility, advice.allowed)) > 1:
        console.print(f"The highest of them: {patches.names[advice.best]}.")
    if explained := headline.mean_sentence(utility):
        console.print(f"{explained}.", markup=False)
    console.print(f"{headline.confidence_sentence(utility, advice.best)}.")
    if warning := interval_caution(utility):
        console.print(f"Caution: {warning}.", style="yellow")


def show_worn(worn: JointSet, patches: PatchSet, console: Console) -> None:
    """Print the sensors to wear together, and what they would reach on other clips, what to add."""
    made = worn.promise
    console.print(f"[bold]{capital(worn.sentence())}.[/bold]")
    table = Table(title="Worn together, sensor by sensor", title_justify="left")
    for heading in ("", "patch", "expected F1", "95 % interval", "on these clips"):
        table.add_column(heading, justify="left" if heading == "patch" else "right", overflow="fold")
    for number, patch in enumerate(worn.order):
        table.add_row(
            str(number + 1),
            patches.names[patch],
            f"{made.mean[number]:.3f}",
            interval_text(made.low[number], made.high[number], ""),
            f"{worn.raw_mean[number]:.3f}",
        )
    console.print(table)
    if following := next_worn(worn, patches):
        console.print(f"{capital(following['sentence'])}.", markup=False)


def show_advice(
    advice: Advice,
    utility: UtilityMap,
    patches: PatchSet,
    together: Sequence[UtilityMap],
    console: Console,
) -> None:
    """Print the chosen set sensor by sensor, and what the choice rests on."""
    subset = advice.subset
    if subset.promise is None:
        console.print(NOT_PROMISED, style="yellow")
    else:
        console.print(f"By the paper's algorithm 2, {subset.expected_sentence()}.")
    console.print(_set_table(advice, utility, patches, together))
    joint = joint_of(advice, together)
    if joint is not None:
        console.print(f"{capital(joint['sentence'])}.")
    else:
        console.print("The sensors were not tested together.")
    console.print(f"By the best-of proxy: {subset.proxy_sentence()}; {advice.gap_sentence()}.")
    if advice.exact is not None and advice.exact.promise not in (None, subset.promise):
        console.print(f"The exact optimum: {advice.exact.expected_sentence()}.")
    if advice.next_patch >= 0:
        more = patches.names[advice.next_patch]
        console.print(f"By the proxy, one more sensor ({more}) would add {advice.next_gain:.3f}.")
    console.print(
        "'Expected F1', 'on these clips': one classifier on all sensors up to that line, on other clips by "
        "halves of these, and tested as the map is. 'Best-of "
        "proxy' (mean-max F1): for each activity the F1 of the sensor that is best at it; it never falls "
        "when sensors are added, which a real classifier's F1 can.",
        style="dim",
    )


def _set_table(
    advice: Advice, utility: UtilityMap, patches: PatchSet, together: Sequence[UtilityMap]
) -> Table:
    """The set sensor by sensor: what it would reach on other clips, then what it reached on these."""
    subset, caution = advice.subset, headline.mean_caution(utility)
    made, order = subset.promise, subset.order
    headings = ["expected F1", "95 % interval"] if made is not None else []
    if together:
        headings += ["on these clips"] if made is not None else ["F1 on these clips", "95 % interval"]
    table = Table(title="The set by the paper's algorithm 2, sensor by sensor", title_justify="left")
    table.add_column("")
    table.add_column("patch", overflow="fold")
    for heading in [*headings, "best-of proxy"]:
        table.add_column(heading, justify="right")
    table.add_column("would do as well", overflow="fold")
    for number, (patch, score) in enumerate(zip(order[:AT_MOST], subset.mean_max_after_each, strict=False)):
        cells = []
        if made is not None:
            cells += [f"{made.mean[number]:.3f}", interval_text(made.low[number], made.high[number], "")]
        if together:
            tested = _tested(together[number], caution) if number < len(together) else ["", ""]
            cells += tested if made is None else tested[:1]
        same = _regions(advice.alternatives[number], patches)
        table.add_row(str(number + 1), patches.names[patch], *cells, f"{score:.3f}", same)
    if len(order) > AT_MOST:
        table.add_row("", f"and {len(order) - AT_MOST} more")
    return table


def _tested(tested: UtilityMap, caution: str) -> list[str]:
    return [f"{tested.mean[0]:.3f}", interval_text(tested.mean_low[0], tested.mean_high[0], caution)]


def _regions(chosen: np.ndarray, patches: PatchSet) -> str:
    """Regions of patches with how many there are of each, the commonest first."""
    if not len(chosen):
        return "none"
    counts = Counter(patches.regions[patch] for patch in chosen.tolist()).most_common()
    shown = ", ".join(f"{region} ({count})" for region, count in counts[:4])
    return shown + (f" and {len(counts) - 4} regions more" if len(counts) > 4 else "")
