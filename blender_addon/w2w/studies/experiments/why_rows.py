# SPDX-License-Identifier: GPL-3.0-or-later
"""How a ranking agrees with its judges': rows of `why_truth` and `why_vigour`, and their tables."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.csv_tables import csv_text
from w2w.core.files import write_text
from w2w.core.ranking.agreement import spearman_rows

from ..validation.regret import lost
from ..validation.site_scores import TAIL, SiteScores
from ..validation.sites import mean_rho


class Row(NamedTuple):
    """How a step's ranking agrees with its judges'; each (value, low, high)."""

    step: str
    f1: float  # mean over sites and activities
    of_mean: tuple[float, float, float]
    by_activity: tuple[float, float, float]
    regret: tuple[float, float, float]
    against: tuple[float, float, float]
    """Rho by activity less that of the first step of its kind: worn by other people, simulated as fixed."""


NONE = (np.nan,) * 3

Agreed = tuple[tuple[np.ndarray, np.ndarray], ...]
"""rho of mean F1, rho by activity and regret: as they are, and with performers resampled, each (judges,)."""


def agreement(judges: SiteScores, stands: SiteScores, people: bool) -> Agreed:
    """What stands in for half of the people, by the other half."""
    judged = np.concatenate([judges.halves[0], judges.halves[1]])
    if people:
        seen = np.concatenate([stands.halves[1], stands.halves[0]])
        drawn = seen
    else:
        seen, drawn = np.broadcast_to(stands.f1, judged.shape), stands.samples[: len(judged)]
    return tuple(zip(three(judged, seen), three(judged, drawn), strict=True))


def three(judged: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """rho of mean F1, mean rho by activity and regret of scores (..., S, A)."""
    means = [np.nanmean(side, axis=-1) for side in (judged, seen)]
    regret = lost(*(mean[..., None] for mean in means))
    return np.nan_to_num(spearman_rows(*means)), mean_rho(judged, seen), regret


def row_of(step: str, stands: SiteScores, agreed: Agreed, first: tuple[np.ndarray, np.ndarray]) -> Row:
    """A step's row; `first` is the rho by activity it is compared with."""
    against = tuple(one - other for one, other in zip(agreed[1], first, strict=True))
    return Row(step, float(stands.f1.mean()), *(estimate(*one) for one in (*agreed, against)))


def estimate(values: np.ndarray, drawn: np.ndarray) -> tuple[float, float, float]:
    """The mean of values and the 95 % interval of those drawn."""
    return (float(values.mean()), *(float(one) for one in np.quantile(drawn, TAIL)))


def tell(path: Path, title: str, rows: Sequence[Row]) -> None:
    """Print rows and write their csv."""
    columns = ("of_mean", "by_activity", "regret", "against")
    head = ["step", "f1", *(f"{column}{end}" for column in columns for end in ("", "_low", "_high"))]
    table = [
        [row.step, *(round(value, 3) for value in (row.f1, *(v for c in columns for v in getattr(row, c))))]
        for row in rows
    ]
    write_text(path, csv_text([head, *table]))
    print(f"\n{title}\n| step | F1 | rho of mean F1 | mean rho by activity | regret | against |")
    print("|---" * 6 + "|")
    for row in rows:
        cells = [f"{value:.3f} ({low:.3f} to {high:.3f})" for value, low, high in row[2:]]
        print(f"| {row.step} | {row.f1:.3f} | {' | '.join(cells)} |", flush=True)
