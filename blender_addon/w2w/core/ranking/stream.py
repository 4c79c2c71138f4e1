# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 in a stream of the clips beside F1 on the clips cut out, by the same classifier in the same folds."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import NamedTuple

import numpy as np
import scipy

from ..imu.recording import ImuRecording
from ..imu.sensor import SensorModel
from ..threads import unthreaded_products
from ..windows.features import window_features
from ..windows.stream import NO_CLIP, stream_windows
from ..windows.windows import WindowSpec, cut_windows
from .classifiers.ridge import Ridge
from .f1 import window_f1
from .weights import mean_over

FEWEST_ORDERS, MOST_ORDERS = 2, 8
"""Orders of the clips that are averaged, because F1 depends on the one that was drawn."""

ENOUGH_S = 2500.0
"""Seconds of clips, over all orders, beyond which no further order is drawn after the fewest."""

SENSORS_AT_ONCE = 512
"""Windows times sensors described at once."""

CONFIDENCE = 0.95
"""Confidence level of intervals."""


class StreamF1(NamedTuple):
    """F1 of a set of patches by activity: on clips cut out, and in a stream of them."""

    cut_out: np.ndarray  # (A,)
    orders: np.ndarray  # (O, A): in the stream, for each order of the clips; 0 where no window is of it

    @property
    def loss(self) -> np.ndarray:
        """F1 lost from clips cut out to the stream, shape (A,)."""
        return self.cut_out - self.orders.mean(axis=0)


class _Windows(NamedTuple):
    """Windows to train and test on."""

    features: np.ndarray  # (W, N, D)
    labels: np.ndarray  # (W,), int
    fold: np.ndarray  # (W,), int
    is_test: np.ndarray  # (W,), bool


class ExpectedF1(NamedTuple):
    """Macro F1 expected on other clips, and its interval."""

    mean: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Stream:
    """C clips of which F1 in a stream is found, set by set.

    Each fold of clips is a stream by itself, so people and copies are kept apart as in the folds. Standing
    is a class of its own to train against, and windows of it are not counted.
    """

    read: Callable[[Sequence[int]], Sequence[ImuRecording]]  # recordings of all clips at some patches
    standing: np.ndarray  # (N, 6): what the patches read while standing
    sensor: SensorModel
    spec: WindowSpec
    activity: np.ndarray  # (C,), int: 0 to A - 1
    fold: np.ndarray  # (C,), int
    weights: np.ndarray  # (A,): what each activity counts
    seed: int
    _known: dict[tuple[int, ...], StreamF1] = field(default_factory=dict)
    _ridges: dict[str, float] = field(default_factory=dict)  # chosen once: sets differ by signals alone

    def f1(self, sets: Iterable[Sequence[int]]) -> list[StreamF1]:
        """F1 of sets of patches worn together; one that was asked for before is not tried again."""
        wanted = [tuple(map(int, worn)) for worn in sets]
        due = [worn for worn in dict.fromkeys(wanted) if worn not in self._known]
        if due:
            patches = sorted(set(chain.from_iterable(due)))
            with unthreaded_products():
                found = self._try(patches, [[patches.index(patch) for patch in worn] for worn in due])
            self._known.update(zip(due, found, strict=True))
        return [self._known[worn] for worn in wanted]

    def expected(self, worn: Sequence[int], cut_out: ExpectedF1) -> ExpectedF1:
        """What other clips would give in a stream, from what they would give cut out.

        The loss on these clips is taken off. The interval grows as binomial variance, p (1 - p), and by what
        the orders differ.
        """
        found = self.f1([worn])[0]
        mean = float(np.clip(cut_out.mean - mean_over(found.loss, self.weights), 0, 1))
        by_order = mean_over(found.orders, self.weights)
        error = scipy.special.ndtri((1 + CONFIDENCE) / 2) * by_order.std(ddof=1) / np.sqrt(len(by_order))
        variance = max(cut_out.mean * (1 - cut_out.mean), 1e-6)
        scale = max(1.0, np.sqrt(mean * (1 - mean) / variance))
        below, above = (
            np.hypot(scale * reach, error)
            for reach in (cut_out.mean - cut_out.low, cut_out.high - cut_out.mean)
        )
        return ExpectedF1(mean, float(max(mean - below, 0)), float(min(mean + above, 1)))

    def _try(self, patches: Sequence[int], sets: Sequence[Sequence[int]]) -> list[StreamF1]:
        """Train and test sets of the patches, given by their places among these."""
        recordings, n_activities = self.read(patches), len(self.weights)
        cut = [cut_windows(one, self.spec) for one in recordings]
        clip = np.repeat(np.arange(len(cut)), [len(one.is_test) for one in cut])
        is_test, labels = np.concatenate([one.is_test for one in cut]), self.activity[clip]
        features = np.concatenate([_described(one.signals, recordings[0].rate) for one in cut])
        predicted = self._predicted("cut out", _Windows(features, labels, self.fold[clip], is_test), sets)
        cut_out = [window_f1(one, labels[is_test], n_activities) for one in predicted]

        duration = sum(one.n_samples / one.rate for one in recordings)
        n_orders = int(np.clip(ENOUGH_S // duration, FEWEST_ORDERS, MOST_ORDERS))
        parts = [self._in_order(recordings, patches, order) for order in range(n_orders)]
        order = np.repeat(np.arange(n_orders), [len(one.labels) for one in parts])
        everything = _Windows(*(np.concatenate(values) for values in zip(*parts, strict=True)))
        predicted, labels = self._predicted("stream", everything, sets), everything.labels
        counted = [np.flatnonzero((order == o) & (labels < n_activities)) for o in range(n_orders)]
        orders = [
            [window_f1(one[rows], labels[rows], n_activities + 1)[:-1] for rows in counted]
            for one in predicted
        ]
        return [StreamF1(*both) for both in zip(cut_out, np.nan_to_num(orders), strict=True)]

    def _in_order(self, recordings: Sequence[ImuRecording], patches: Sequence[int], order: int) -> _Windows:
        """Windows of all folds' streams in a drawn order, all tested; the last label is standing."""
        standing, parts = self.standing[patches], []
        for fold in np.unique(self.fold).tolist():
            here = np.flatnonzero(self.fold == fold)
            draw = (self.seed, order, fold)
            some = [recordings[number] for number in here]
            signals, owner = stream_windows(some, standing, self.sensor, self.spec.length_s, draw)
            labels = np.where(owner == NO_CLIP, len(self.weights), self.activity[here[owner]])
            features, tested = _described(signals, recordings[0].rate), np.ones(len(labels), dtype=bool)
            parts.append(_Windows(features, labels, np.full(len(labels), fold), tested))
        return _Windows(*(np.concatenate(values) for values in zip(*parts, strict=True)))

    def _predicted(self, kind: str, windows: _Windows, sets: Sequence[Sequence[int]]) -> np.ndarray:
        """Activity that each set predicts for each tested window, shape (S, V).

        Patches enter as in `JointScores`: side by side, with the ridge multiplied by their number.
        """
        if kind not in self._ridges:
            self._ridges[kind] = Ridge().choose_alpha(*windows)
        features, labels, fold, is_test = windows
        predicted = np.empty((len(sets), int(is_test.sum())), dtype=np.int16)
        for size in {len(worn) for worn in sets}:
            rows = [row for row, worn in enumerate(sets) if len(worn) == size]
            joined = [features[:, list(sets[row])].reshape(len(features), -1) for row in rows]
            model = Ridge(alphas=(self._ridges[kind] * size,))
            predicted[rows] = model.predict_folds(np.stack(joined, axis=1), labels, fold, is_test).T
        return predicted


def _described(signals: np.ndarray, rate: float) -> np.ndarray:
    """Features (W, N, D) of windows (W, N, samples, 6), many sensors at once: a fraction of the time."""
    n_windows, n_sensors, samples, _ = signals.shape
    step = max(1, SENSORS_AT_ONCE // n_sensors)
    parts = [
        window_features(signals[first : first + step].reshape(1, -1, samples, 6), rate)[0]
        for first in range(0, n_windows, step)
    ]
    return np.concatenate(parts).reshape(n_windows, n_sensors, -1)
