# SPDX-License-Identifier: GPL-3.0-or-later
"""How sure a comparison of skin and cloth is: performers drawn with replacement, then clips of each.

The models are not trained again: what varies is who is tested, by which of their clips.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from math import comb

import numpy as np

from w2w.core.ranking.agreement import spearman_rows
from w2w.core.ranking.f1 import ClipCounts, f1_scores

LEVEL = 0.95
"""Confidence of the intervals."""

MOST_WAYS = 200
"""Ways to halve the performers that are looked at."""

RESAMPLES = 2000


def performers_and_clips(
    performer: Sequence[str], activity: Sequence[str], resamples: int, rng: np.random.Generator
) -> np.ndarray:
    """How often each clip is drawn: as many performers as there are, then as many clips of each by activity.

    `performer`, `activity` length C: of each clip.
    Returns (resamples, C).
    """
    performer, activity = np.asarray(performer), np.asarray(activity)
    people = np.unique(performer)
    times = rng.multinomial(len(people), np.full(len(people), 1 / len(people)), size=resamples)
    weights = np.zeros((resamples, len(performer)))
    for own, name in zip(times.T, people, strict=True):
        for label in np.unique(activity):
            members = np.flatnonzero((performer == name) & (activity == label))
            if len(members):
                chances = np.full(len(members), 1 / len(members))
                weights[:, members] = rng.multinomial(own * len(members), chances)
    return weights


def halves(performer: Sequence[str]) -> np.ndarray:
    """Clips on one side, (H, C), bool, for each way to put half of the performers there, rounded down.

    Where there are more than `MOST_WAYS`, so many are drawn, always the same.
    """
    performer = np.asarray(performer)
    people = np.unique(performer)
    sides = combinations(people, len(people) // 2)
    if comb(len(people), len(people) // 2) > MOST_WAYS:
        rng = np.random.default_rng(0)
        sides = (rng.permutation(people)[: len(people) // 2] for _ in range(MOST_WAYS))
    return np.array([np.isin(performer, side) for side in sides])


def interval(samples: np.ndarray) -> tuple[float, float]:
    """Between which two values the middle samples lie; those that are not known (NaN) do not count."""
    low, high = np.nanquantile(samples, [(1 - LEVEL) / 2, (1 + LEVEL) / 2])
    return float(low), float(high)


def mean_f1(counts: ClipCounts, weights: np.ndarray) -> np.ndarray:
    """F1 of each patch, mean over the activities that are there, shape (B, N), by weights of clips (B, C)."""
    return np.nanmean(f1_scores(counts, weights), axis=2)


def median_rms(rms: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Median over patches of the RMS over clips, shape (B,), by RMS (C, N) and weights of clips (B, C)."""
    square = weights @ rms**2 / weights.sum(axis=1, keepdims=True)
    return np.median(np.sqrt(square), axis=1)


def between_halves(skin: ClipCounts, cloth: ClipCounts, sides: np.ndarray) -> dict[str, float]:
    """How far maps by some performers agree with maps by the others: rho, the mean over the ways to halve.

    Cloth that changed nothing would leave all three alike.

    `skin`, `cloth`: of the same clips and patches.
    `sides` bool (H, C): clips on one side, as from `halves`.
    """
    (a, b), (c, d) = ([mean_f1(own, side) for side in (sides, ~sides)] for own in (skin, cloth))
    rhos = {
        "skin by skin": spearman_rows(a, b),
        "cloth by cloth": spearman_rows(c, d),
        "cloth by skin": np.concatenate([spearman_rows(a, d), spearman_rows(b, c)]),
    }
    return {name: float(np.nanmean(values)) for name, values in rhos.items()}
