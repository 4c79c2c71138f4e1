# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sweep found, on the screen and as csv files."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from w2w.core.csv_tables import csv_text
from w2w.core.files import DIGITS, write_text
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.utility import UtilityMap

from .cases import Case
from .sensitivity import Shift, resampled_clips

TOP = 3
"""Regions named as the best of a case."""


@dataclass(frozen=True, eq=False)
class SweptCase:
    """A case with its map, compared with the usual case."""

    case: Case
    utility: UtilityMap
    shift: Shift


def show_sweep(swept: Sequence[SweptCase], patches: PatchSet, console: Console) -> None:
    """Print a line a case, then the patches whose rank changed for sure."""
    table = Table(title=f"Macro F1 at {len(patches)} patches, against the study as run", title_justify="left")
    table.add_column("case")
    table.add_column("Spearman's rho", justify="right")
    table.add_column("mean F1", justify="right")
    table.add_column("change", justify="right")
    table.add_column("best patch", overflow="fold")
    table.add_column("usual best\nstill best", justify="center")
    table.add_column("flipped", justify="right")
    table.add_column("best regions", overflow="fold")
    for one in swept:
        shift, utility = one.shift, one.utility
        best = int(utility.mean.argmax())
        change = f"{shift.gain:+.3f}"
        if np.isfinite(shift.gain_low) and one is not swept[0]:
            change += f"\n{shift.gain_low:+.3f} to {shift.gain_high:+.3f}"
        table.add_row(
            one.case.title,
            "" if one is swept[0] else f"{shift.rho:.2f}\n{shift.low:.2f} to {shift.high:.2f}",
            f"{utility.mean.mean():.3f}",
            "" if one is swept[0] else change,
            f"{patches.names[best]} ({utility.mean[best]:.2f})",
            "yes" if shift.best_holds else "no",
            f"{len(shift.risen) + len(shift.fallen)}",
            ", ".join(top_regions(utility, patches)),
        )
    console.print(table)
    low, high = resampled_clips(swept[0].utility)
    console.print(
        f"These very clips resampled agree by a rho of {low:.2f} to {high:.2f} with nothing changed; "
        f"{_of_other_clips(swept[0].utility)}. 'still best': cannot be told from the case's best patch. "
        "'flipped': patches whose 95 % intervals of the rank do not overlap.",
        style="dim",
    )
    for one in swept:
        for word, flipped in (("rise", one.shift.risen), ("fall", one.shift.fallen)):
            if len(flipped):
                console.print(f"{one.case.title}: {_regions(flipped, patches)} {word}.")


def _of_other_clips(usual: UtilityMap) -> str:
    if np.isnan(usual.reliability):
        return "how far other clips would agree is not known"
    whole = usual.reliability
    halves = whole / (2 - whole) if whole > 0 else whole  # the inverse of `expected.of_all`
    return f"disjoint halves of them, whose maps are pooled over the skin, by {halves:.2f}"


def write_sweep(folder: Path, swept: Sequence[SweptCase], patches: PatchSet) -> None:
    """Write `sweep.csv`, a line a case, and `places.csv`, a line a patch and case."""
    rows = [
        [
            *("factor", "case", "rho", "rho_low", "rho_high", "mean_f1", "gain", "gain_low", "gain_high"),
            *("best_place", "best_f1", "best_low", "best_high", "usual_best_holds", "risen", "fallen"),
        ]
    ]
    for one in swept:
        shift, utility = one.shift, one.utility
        best = int(utility.mean.argmax())
        scores = [shift.rho, shift.low, shift.high, utility.mean.mean()]
        scores += [shift.gain, shift.gain_low, shift.gain_high]
        scores_best = [utility.mean[best], utility.mean_low[best], utility.mean_high[best]]
        rows.append(
            [
                *(one.case.factor, one.case.name, *map(_number, scores)),
                *(patches.names[best], *map(_number, scores_best), "yes" if shift.best_holds else "no"),
                "; ".join(patches.names[patch] for patch in shift.risen),
                "; ".join(patches.names[patch] for patch in shift.fallen),
            ]
        )
    write_text(folder / "sweep.csv", csv_text(rows))
    lines = [["factor", "case", "place", "region", "mean", "low", "high", "rank_low", "rank_high"]]
    for one in swept:
        u = one.utility
        for patch, name in enumerate(patches.names):
            scores = map(_number, (u.mean[patch], u.mean_low[patch], u.mean_high[patch]))
            lines.append(
                [
                    *(one.case.factor, one.case.name, name, patches.regions[patch], *scores),
                    *(int(u.rank_low[patch]), int(u.rank_high[patch])),
                ]
            )
    write_text(folder / "places.csv", csv_text(lines))


def top_regions(utility: UtilityMap, patches: PatchSet, count: int = TOP) -> list[str]:
    """The regions of the best patches, each once."""
    return [patches.regions[patch] for patch in patches.best_of_regions(utility.mean)[:count]]


def _regions(chosen: np.ndarray, patches: PatchSet) -> str:
    counts = Counter(patches.regions[patch] for patch in chosen.tolist())
    return ", ".join(f"{name} ({n})" if n > 1 else name for name, n in counts.most_common())


def _number(value: float) -> str:
    return f"{value:.{DIGITS}f}" if np.isfinite(value) else ""
