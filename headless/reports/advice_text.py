# SPDX-License-Identifier: GPL-3.0-or-later
"""A choice of sensors in words on the screen and as plain values on file."""

from __future__ import annotations

from collections import Counter

import numpy as np
from rich.console import Console
from rich.table import Table

from w2w.core.findings.advice_content import next_worn
from w2w.core.findings.counts import interval_caution, interval_text
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap
from w2w.core.selection import headline
from w2w.core.selection.advice import Advice
from w2w.core.wording import capital

ONLY_RIDGE = "Sets to wear together are chosen by the classifier ridge only."


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


def show_worn(advice: Advice, patches: PatchSet, console: Console) -> None:
    """Print the sensors to wear together, what they would reach on other clips, and what to add."""
    worn = advice.worn
    if worn is None:
        console.print(ONLY_RIDGE, style="yellow")
        return
    made = worn.promise
    console.print(f"[bold]{capital(worn.sentence())}.[/bold]")
    table = Table(title="Worn together, sensor by sensor", title_justify="left")
    headings = ("", "patch", "expected F1", "95 % interval", "on these clips", "as good alone")
    for heading in headings:
        left = heading in ("patch", "as good alone")
        table.add_column(heading, justify="left" if left else "right", overflow="fold")
    for number, (patch, others) in enumerate(zip(worn.order, advice.alternatives, strict=True)):
        table.add_row(
            str(number + 1),
            patches.names[patch],
            f"{made.mean[number]:.3f}",
            interval_text(made.low[number], made.high[number], ""),
            f"{worn.raw_mean[number]:.3f}",
            _regions(others, patches),
        )
    console.print(table)
    if following := next_worn(worn, patches):
        console.print(f"{capital(following['sentence'])}.", markup=False)


def _regions(chosen: np.ndarray, patches: PatchSet) -> str:
    """Regions of patches with how many there are of each, the commonest first."""
    if not len(chosen):
        return "none"
    counts = Counter(patches.regions[patch] for patch in chosen.tolist()).most_common()
    shown = ", ".join(f"{region} ({count})" for region, count in counts[:4])
    return shown + (f" and {len(counts) - 4} regions more" if len(counts) > 4 else "")
