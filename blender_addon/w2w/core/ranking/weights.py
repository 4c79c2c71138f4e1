# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights of activities in means over them: background is trained against and weighs 0.

Equal weights take the plain mean, to the last bit.
"""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ..csv_tables import read_table
from ..library.labels import by_label, same_label
from ..wording import clean, restated

BACKGROUND = 0.0
"""Weight of an activity that sensors must not confuse with the others, but need not recognise."""


def counting(
    activities: Sequence[str], background: Iterable[str] = (), weights: Iterable[tuple[str, float]] = ()
) -> dict[str, float]:
    """Weights of the activities that do not weigh 1: those given, and 0 for background.

    Names match in any case and spelling of spaces.
    """
    given = by_label(dict(weights) | dict.fromkeys(background, BACKGROUND), activities)
    return {name: float(weight) for name, weight in given.items() if weight != 1}


def weights_of(activities: Sequence[str], counts: Mapping[str, float] | None) -> np.ndarray:
    """Weights (A,) of activities, 1 for those without; a ValueError if none of them counts."""
    weights = np.array([(counts or {}).get(name, 1.0) for name in activities], dtype=np.float64)
    if not weights.any():
        raise ValueError(
            f"none of the activities that can be tested counts ({', '.join(activities)}): all are background "
            "or have the weight 0"
        )
    return weights


def alike(weights: np.ndarray) -> bool:
    """Whether all activities count the same."""
    return bool((weights == weights[0]).all())


def mean_over(values: np.ndarray, weights: np.ndarray, axis: int = -1) -> np.ndarray:
    """Weighted mean over activities, which lie along an axis; of the values' dtype."""
    if alike(weights):
        return values.mean(axis=axis)
    counted = np.flatnonzero(weights)
    return np.average(values.take(counted, axis), axis=axis, weights=weights[counted]).astype(values.dtype)


def known_mean(values: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Weighted mean over the last axis of the values that are not NaN."""
    if alike(weights):
        return np.nanmean(values, axis=-1)
    counted = np.flatnonzero(weights)
    values, weights = values[..., counted], weights[counted]
    known = np.isfinite(values)
    with np.errstate(invalid="ignore"):
        return (np.where(known, values, 0) * weights).sum(axis=-1) / (known * weights).sum(axis=-1)


def check_counting(
    activities: Iterable[str], background: Sequence[str], weights: Sequence[tuple[str, float]]
) -> None:
    """Refuse names of no activity, and weights that leave nothing to count, with a ValueError."""
    activities, without = list(activities), {same_label(name) for name in background}
    both = [name for name, weight in weights if weight and same_label(name) in without]
    if both:
        raise ValueError(f"{', '.join(both)}: background has no weight; say one or the other")
    there = {same_label(name) for name in activities}
    for what, names in (("background", background), ("weights", [name for name, _ in weights])):
        strangers = [name for name in names if same_label(name) not in there]
        if strangers:
            known = ", ".join(sorted(activities))
            raise ValueError(f"{what}: no clip is labelled {', '.join(strangers)}; there are {known}")
    weights_of(activities, counting(activities, background, weights))


def read_weights(path: str | Path) -> tuple[tuple[str, float], ...]:
    """Read weights from a csv file with columns ``activity``, ``weight``.

    A ValueError says which line is bad.
    """
    weights: dict[str, float] = {}
    for line, row in read_table(path, ("activity", "weight")).rows:
        name, text = row["activity"], row["weight"]
        with restated(f"{clean(path)}, line {line}: '{text}' is no number", ValueError):
            weight = float(text)
        if not (np.isfinite(weight) and weight >= 0):
            raise ValueError(f"{clean(path)}, line {line}: a weight is 0 (background) or more, not {text}")
        if not name:
            raise ValueError(f"{clean(path)}, line {line}: no activity")
        if weights.get(name, weight) != weight:
            raise ValueError(f"{clean(path)}, line {line}: '{name}' is listed twice with different weights")
        weights[name] = weight
    return tuple(weights.items())
