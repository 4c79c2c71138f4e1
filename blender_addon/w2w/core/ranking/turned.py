# SPDX-License-Identifier: GPL-3.0-or-later
"""How much F1 drops if a sensor is strapped on rotated and its classifier was trained on one that was not."""

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from ..patches.card import FARTHEST_DEG
from ..windows.features import window_features
from .classifiers.ridge import Ridge
from .f1 import window_f1
from .halves import CrossValidation, Predictions, Split
from .weights import mean_over

TURNS = (5, 10, 15, 20, 30, 45, FARTHEST_DEG)
"""Rotations about the outward normal, degrees, tried in both directions."""


def may_turn(windows: np.ndarray, rate: float, protocol: CrossValidation, drop: float) -> int:
    """How far a sensor may be turned about its outward normal before macro F1 falls by more than `drop`.

    A ridge is trained on the windows as they are and predicts rotated windows of clips it was not trained on.

    Parameters
    ----------
    windows : ndarray, shape (W, samples, 6)
        Specific force (m/s2) and angular velocity (rad/s) of one sensor, z outward.
    rate : float
        Samples per second.
    protocol : CrossValidation
        Training and testing on these windows.
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


def _f1_of_turned(
    windows: np.ndarray, rate: float, protocol: CrossValidation, turns: tuple[int, ...]
) -> np.ndarray:
    """Macro F1 with the tested windows turned by each of some angles, degrees; shape (K,)."""
    planned = protocol.plan(halvings=0)
    whole, tested = planned.plan.splits, np.flatnonzero(planned.is_test)
    seen = windows[planned.used]
    shown = [seen, *(_turned(seen[tested], turn) for turn in turns)]
    described = [window_features(part[None], rate)[0] for part in shown]  # as sensors of one window: faster
    features = np.concatenate(described)[:, None]
    labels = np.concatenate([planned.labels, np.tile(planned.labels[tested], len(turns))])
    never = np.full(len(labels) - len(seen), planned.plan.block.max() + 1)
    place = np.cumsum(planned.is_test) - 1
    splits = [
        Split(split.train, len(seen) + number * len(tested) + place[split.tested])
        for number in range(len(turns))
        for split in whole
    ]
    predicted = np.zeros(len(labels), dtype=np.int16)

    def receive(_sensor: int, predictions: Iterable[Predictions]) -> None:
        for _, rows, activities in predictions:
            predicted[rows] = activities[0]

    ridge = Ridge()
    alpha = ridge.choose_alpha(features[: len(seen)], planned.labels, planned.fold, planned.is_test)
    ridge.predict_splits(
        features, labels, np.concatenate([planned.plan.block, never]), splits, alpha, receive
    )
    by_turn = predicted[len(seen) :].reshape(len(turns), -1)
    f1 = [window_f1(row, planned.labels[tested], len(planned.activities)) for row in by_turn]
    return mean_over(np.array(f1), planned.weights)


def _turned(windows: np.ndarray, degrees: float) -> np.ndarray:
    """Windows as a sensor that is turned about its z axis would record them."""
    turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()  # times rows of readings: its inverse
    return np.concatenate([windows[..., :3] @ turn, windows[..., 3:] @ turn], axis=-1).astype(np.float32)
