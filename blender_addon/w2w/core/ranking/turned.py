# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sensor loses that is strapped on turned, when its classifier learnt from one that was not."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from ..windows.features import window_features
from .classifiers.ridge import Ridge
from .f1 import window_f1
from .halves import Named, Protocol, Split
from .weights import mean_over

TURNS = (5, 10, 15, 20, 30, 45, 90)
"""Degrees about the outward normal that are tried, either way."""


def may_turn(windows: np.ndarray, rate: float, protocol: Protocol, drop: float) -> int:
    """How far a sensor may be turned about its outward normal before macro F1 falls by more than `drop`.

    A ridge learns from the windows as they are and names turned ones, never of a clip that it learnt from.

    Parameters
    ----------
    windows : ndarray, shape (W, samples, 6)
        Specific force (m/s2) and angular velocity (rad/s) of one sensor, z outward.
    rate : float
        Samples per second.
    protocol : Protocol
        Of the windows.
    drop : float

    Returns
    -------
    int
        The largest of `TURNS` up to which F1 falls by no more, the mean of both directions; 0 if the
        smallest costs more.
    """
    f1 = _f1_of_turned(windows, rate, protocol, (0, *TURNS, *(-turn for turn in TURNS)))
    enough = f1[1:].reshape(2, -1).mean(axis=0) >= f1[0] - drop - 1e-9
    return (0, *TURNS)[int(np.logical_and.accumulate(enough).sum())]


def _f1_of_turned(windows: np.ndarray, rate: float, protocol: Protocol, turns: tuple[int, ...]) -> np.ndarray:
    """Macro F1 with the tested windows turned by each of some angles, degrees; shape (K,)."""
    trial = protocol.planned(halvings=0)
    whole, tested = trial.plan.splits, np.flatnonzero(trial.is_test)
    seen = windows[trial.used]
    shown = [seen, *(_turned(seen[tested], turn) for turn in turns)]
    described = [window_features(part[None], rate)[0] for part in shown]  # as sensors of one window: faster
    features = np.concatenate(described)[:, None]
    labels = np.concatenate([trial.labels, np.tile(trial.labels[tested], len(turns))])
    never = np.full(len(labels) - len(seen), trial.plan.block.max() + 1)
    place = np.cumsum(trial.is_test) - 1
    splits = [
        Split(split.train, len(seen) + number * len(tested) + place[split.tested])
        for number in range(len(turns))
        for split in whole
    ]
    named = np.zeros(len(labels), dtype=np.int16)

    def receive(_sensor: int, found: Iterable[Named]) -> None:
        for _, rows, activities in found:
            named[rows] = activities[0]

    ridge = Ridge()
    alpha = ridge.choose_alpha(features[: len(seen)], trial.labels, trial.fold, trial.is_test)
    ridge.name_splits(features, labels, np.concatenate([trial.plan.block, never]), splits, alpha, receive)
    names = named[len(seen) :].reshape(len(turns), -1)
    f1 = [window_f1(row, trial.labels[tested], len(trial.activities)) for row in names]
    return mean_over(np.array(f1), trial.weights)


def _turned(windows: np.ndarray, degrees: float) -> np.ndarray:
    """What a sensor reads that is turned about its z axis."""
    turn = Rotation.from_euler(
        "z", degrees, degrees=True
    ).as_matrix()  # rows of readings times it: its inverse
    return np.concatenate([windows[..., :3] @ turn, windows[..., 3:] @ turn], axis=-1).astype(np.float32)
