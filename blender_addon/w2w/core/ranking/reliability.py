# SPDX-License-Identifier: GPL-3.0-or-later
"""How far a map would come out the same with other clips, and how many clips would make it do so."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

WANTED = 0.85
"""Reliability at which a map may be read patch by patch."""


def agreement(pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
    """Mean correlation over patches of the maps (N,) of each pair; a flat map agrees with none."""
    found = [np.corrcoef(a, b)[0, 1] if np.ptp(a) > 0 and np.ptp(b) > 0 else 0.0 for a, b in pairs]
    return float(np.mean(found)) if found else np.nan


def of_all(of_halves: float) -> float:
    """Reliability of the map of all clips from the agreement of halves of them (Spearman 1910, Brown 1910).

    Halves that disagree stay as they are: no number of clips makes a map of what is not there.
    """
    return 2 * of_halves / (1 + of_halves) if of_halves > 0 else of_halves


def of_halves(reliability: float) -> float:
    """How far halves agree where all clips have this reliability: `of_all` the other way."""
    return reliability / (2 - reliability) if reliability > 0 else reliability


def clips_needed(reliability: float, wanted: float = WANTED) -> float:
    """How many times as many clips would give the wanted reliability, by the same formula.

    1 or less where these do; infinite where they show nothing that repeats; NaN where it is not known.
    """
    if reliability <= 0:
        return np.inf
    return wanted * (1 - reliability) / (reliability * (1 - wanted))
