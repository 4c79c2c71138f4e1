# SPDX-License-Identifier: GPL-3.0-or-later
"""F1 in a stream of the clips next to F1 on windows of one clip, by the same classifier in the same folds."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, product
from typing import NamedTuple

import numpy as np
import scipy

from ..imu.recording import ImuRecording
from ..imu.sensor import SensorModel
from ..threads import chunks, for_each, unthreaded_products
from ..windows.features import window_features
from ..windows.stream import NO_CLIP, stream_windows
from ..windows.windows import WindowSpec, cut_windows
from .classifiers.ridge import Ridge
from .f1 import window_f1
from .utility import ExpectedF1, UtilityMap
from .weights import mean_over

FEWEST_ORDERS, MOST_ORDERS = 2, 8
"""Orders of the clips that are averaged, because F1 depends on the one that was drawn."""

ENOUGH_S = 2500.0
"""Seconds of clips, over all orders, beyond which no further order is drawn after the fewest."""

SENSORS_AT_ONCE = 512
"""Windows times sensors described at once."""

GRAVITY = 3
"""Features, the first, that tell the direction of gravity: means of the accelerometer."""

CONFIDENCE = 0.95
"""Confidence level of intervals."""

SMALLEST_VARIANCE = 0.95 * 0.05
"""Smallest variance p (1 - p) of F1 by clip, so that the interval of one near 1 stays bounded in a stream."""


class StreamF1(NamedTuple):
    """F1 of a set of patches by activity: on windows of one clip, and in a stream of all."""

    by_clip: np.ndarray  # (A,)
    orders: np.ndarray  # (O, A): in the stream, for each order of the clips; 0 where no window is of it

    @property
    def loss(self) -> np.ndarray:
        """F1 lost in the stream, shape (A,)."""
        return self.by_clip - self.orders.mean(axis=0)


class _Windows(NamedTuple):
    """Windows to train and test on, and what each patch that was read shows in them."""

    labels: np.ndarray  # (W,), int
    fold: np.ndarray  # (W,), int
    is_test: np.ndarray  # (W,), bool
    order: np.ndarray  # (W,), int: which order of the clips it is from
    features: dict[int, np.ndarray]  # of each patch, (W, D)

    def of(self, sets: Sequence[Sequence[int]]) -> np.ndarray:
        """Features of sets of equally many patches, those of a set side by side, shape (W, S, D)."""
        joined = np.concatenate([self.features[patch] for patch in chain.from_iterable(sets)], axis=1)
        return joined.reshape(len(joined), len(sets), -1)


class _Held(NamedTuple):
    """What a patch recorded."""

    number: int  # among the sensors of the windows
    cut: Sequence[np.ndarray]  # windows of each clip, (W, N, samples, 6): views, as a rule


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
    spots: Sequence[int] = ()  # where one sensor may sit; by default each is judged by itself
    _known: dict[tuple[int, ...], StreamF1] = field(default_factory=dict)
    _windows: dict[str, _Windows] = field(default_factory=dict)  # of single clips, and in the stream
    _held: dict[int, _Held] = field(default_factory=dict)  # by patch
    _ridges: dict[tuple[str, int | None], float] = field(
        default_factory=dict
    )  # chosen once: sets differ by signals alone

    def f1(self, sets: Iterable[Sequence[int]]) -> list[StreamF1]:
        """F1 of sets of patches worn together; one that was asked for before is not tried again."""
        wanted = [tuple(map(int, worn)) for worn in sets]
        due = [worn for worn in dict.fromkeys(wanted) if worn not in self._known]
        if due:
            with unthreaded_products():
                self._describe(sorted(set(chain.from_iterable(due))))
                self._known.update(zip(due, self._try(due), strict=True))
        return [self._known[worn] for worn in wanted]

    def losing(self, sets: Sequence[Sequence[int]]) -> list[StreamF1]:
        """F1 of sets, by whose loss in the stream other clips are judged.

        For one sensor it is the mean over the `spots`, which tells more than a spot's own loss does.
        """
        found = self.f1([*sets, *([spot] for spot in self.spots)])
        alone = [np.mean(values, axis=0) for values in zip(*found[len(sets) :], strict=True)]
        return [
            StreamF1(*alone) if alone and len(worn) == 1 else f1
            for worn, f1 in zip(sets, found, strict=False)
        ]

    def expected(self, worn: Sequence[int], by_clip: ExpectedF1) -> ExpectedF1:
        """What other clips would give in a stream, from what they would give one by one.

        The loss on these clips is taken off. The interval grows as binomial variance, p (1 - p), and by what
        the orders differ.
        """
        found = self.losing([worn])[0]
        mean = np.clip(by_clip.mean - mean_over(found.loss, self.weights), 0, 1)
        by_order = mean_over(found.orders, self.weights)
        error = scipy.special.ndtri((1 + CONFIDENCE) / 2) * by_order.std(ddof=1) / np.sqrt(len(by_order))
        variance = np.maximum(by_clip.mean * (1 - by_clip.mean), SMALLEST_VARIANCE)
        scale = np.maximum(1.0, np.sqrt(mean * (1 - mean) / variance))
        below, above = (
            np.hypot(scale * reach, error)
            for reach in (by_clip.mean - by_clip.low, by_clip.high - by_clip.mean)
        )
        return ExpectedF1(mean, np.maximum(mean - below, 0), np.minimum(mean + above, 1))

    @property
    def lost(self) -> np.ndarray:
        """F1 of each activity that one sensor loses in the stream, shape (A,)."""
        return self.losing([self.spots[:1]])[0].loss

    @cached_property
    def by_moving(self) -> np.ndarray:
        """F1 that each spot alone has beyond what directions of gravity tell, shape (S, A)."""
        alone = [(spot,) for spot in self.spots]
        whole = np.array([found.orders.mean(axis=0) for found in self.f1(alone)])
        return whole - self._by_order(alone, GRAVITY).mean(axis=1)

    def weighed(self, weights: np.ndarray) -> "Stream":
        """The same stream by other weights of activities: what is known of it stays known."""
        found = replace(self, weights=weights)
        vars(found)["by_moving"] = self.by_moving
        return found

    def on_map(self, utility: UtilityMap) -> UtilityMap:
        """The map of one sensor with F1 in the stream as what is expected; one that has it stays."""
        if utility.lost is not None:
            return utility
        found = self.expected(self.spots[:1], utility.expected)
        by_activity = np.clip(utility.expected_f1 - self.lost, 0, 1)
        posture = np.full_like(by_activity, np.nan)
        posture[self.spots] = np.clip(by_activity[self.spots] - self.by_moving, 0, 1)
        mean, low, high, f1, posture = (
            np.asarray(values, dtype=np.float32) for values in (*found, by_activity, posture)
        )
        return replace(
            utility, expected_f1=f1, expected_mean=mean, expected_low=low, expected_high=high,
            lost=self.lost, posture=posture,
        )  # fmt: skip

    def windows_at(self, patch: int) -> np.ndarray:
        """Windows of single clips at a patch, shape (W, samples, 6)."""
        self._describe([patch])
        held = self._held[patch]
        return np.concatenate([windows[:, held.number] for windows in held.cut])

    def _try(self, sets: Sequence[Sequence[int]]) -> list[StreamF1]:
        """Train and test sets of patches that are described."""
        n_activities = len(self.weights)
        cut = self._windows["by clip"]
        of_cut = [
            window_f1(one, cut.labels[cut.is_test], n_activities) for one in self._predicted("by clip", sets)
        ]
        return [StreamF1(*both) for both in zip(of_cut, self._by_order(sets), strict=True)]

    def _by_order(self, sets: Sequence[Sequence[int]], width: int | None = None) -> np.ndarray:
        """F1 in the stream of sets by the first features of their windows, or all; shape (S, O, A)."""
        n_activities, played = len(self.weights), self._windows["stream"]
        counted = [
            np.flatnonzero((played.order == order) & (played.labels < n_activities))
            for order in np.unique(played.order)
        ]
        of_orders = [
            [window_f1(one[rows], played.labels[rows], n_activities + 1)[:-1] for rows in counted]
            for one in self._predicted("stream", sets, width)
        ]
        return np.nan_to_num(of_orders)

    def _describe(self, patches: Sequence[int]) -> None:
        """Read the clips at the patches that were not read before, and describe their windows."""
        known = self._windows["stream"].features if self._windows else {}
        due = sorted({*patches} - {*known})
        if not due:
            return
        if self.sensor.drop_fraction and self.sensor.dropped == "nan":  # a window needs all that are read
            due = sorted({*due, *known})
            self._windows.clear()
        recordings = self.read(due)
        cut = [cut_windows(one, self.spec) for one in recordings]
        signals = [one.signals for one in cut]
        self._held.update((patch, _Held(number, signals)) for number, patch in enumerate(due))
        clip = np.repeat(np.arange(len(cut)), [len(one.is_test) for one in cut])
        duration = sum(one.n_samples / one.rate for one in recordings)
        n_orders = int(np.clip(ENOUGH_S // duration, FEWEST_ORDERS, MOST_ORDERS))
        found = {
            "by clip": _Windows(
                self.activity[clip],
                self.fold[clip],
                np.concatenate([one.is_test for one in cut]),
                np.zeros(len(clip), dtype=int),
                _by_patch(due, signals, recordings[0].rate),
            ),
            "stream": self._in_orders(recordings, due, n_orders),
        }
        for kind, windows in found.items():
            self._windows.setdefault(kind, windows).features.update(windows.features)

    def _in_orders(
        self, recordings: Sequence[ImuRecording], patches: Sequence[int], n_orders: int
    ) -> _Windows:
        """Windows of all folds' streams in drawn orders, all tested; the last label is standing."""
        standing = self.standing[patches]

        def played(order_and_fold: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
            order, fold = order_and_fold
            here = np.flatnonzero(self.fold == fold)
            some = [recordings[number] for number in here]
            draw = (self.seed, order, fold)
            signals, owner = stream_windows(some, standing, self.sensor, self.spec.length_s, draw)
            return signals, np.where(owner == NO_CLIP, len(self.weights), self.activity[here[owner]])

        drawn = list(product(range(n_orders), np.unique(self.fold).tolist()))
        signals, owners = zip(*for_each(played, drawn), strict=True)
        labels = np.concatenate(owners)
        orders, folds = np.repeat(np.array(drawn), [len(owner) for owner in owners], axis=0).T
        features = _by_patch(patches, signals, recordings[0].rate)
        return _Windows(labels, folds, np.ones(len(labels), dtype=bool), orders, features)

    def _predicted(self, kind: str, sets: Sequence[Sequence[int]], width: int | None = None) -> np.ndarray:
        """Activity that each set predicts for each tested window, shape (S, V).

        Patches enter as in `JointScores`: side by side, with the ridge multiplied by their number.
        """
        windows = self._windows[kind]
        how = windows.labels, windows.fold, windows.is_test
        if (kind, width) not in self._ridges:
            alone = [[patch] for patch in sorted(self.spots) or windows.features]  # whatever was asked for
            self._ridges[kind, width] = Ridge().choose_alpha(windows.of(alone)[..., :width], *how)
        predicted = np.empty((len(sets), int(windows.is_test.sum())), dtype=np.int16)

        def predict(size: int) -> None:
            rows = [row for row, worn in enumerate(sets) if len(worn) == size]
            model = Ridge(alphas=(self._ridges[kind, width] * size,))
            features = windows.of([sets[row] for row in rows])[..., :width]
            predicted[rows] = model.predict_folds(features, *how).T

        for_each(predict, sorted({len(worn) for worn in sets}))
        return predicted


def _by_patch(patches: Sequence[int], signals: Sequence[np.ndarray], rate: float) -> dict[int, np.ndarray]:
    """Features (W, D) by patch of windows (W, N, samples, 6), which come in parts."""
    parts = chunks(len(signals), max(1, SENSORS_AT_ONCE // signals[0][..., 0, 0].size))
    features = np.concatenate(for_each(lambda some: _described(np.concatenate(signals[some]), rate), parts))
    return {patch: features[:, number] for number, patch in enumerate(patches)}


def _described(signals: np.ndarray, rate: float) -> np.ndarray:
    """Features (W, N, D) of windows (W, N, samples, 6), many sensors at once: a fraction of the time."""
    n_windows, n_sensors = signals.shape[:2]
    by_channel = signals.transpose(0, 2, 3, 1)  # as they lie: the windows of all sensors side by side
    parts = [
        window_features(np.concatenate(by_channel[some], axis=2).transpose(2, 0, 1)[None], rate)[0]
        for some in chunks(n_windows, max(1, SENSORS_AT_ONCE // n_sensors))
    ]
    return np.concatenate(parts).reshape(n_windows, n_sensors, -1)
