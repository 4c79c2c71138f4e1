# SPDX-License-Identifier: GPL-3.0-or-later
"""Ridge discriminant analysis for all sensors: closed form, all folds from one set of Gram matrices."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import chain
from threading import local
from typing import ClassVar, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from ...blas import add_square, multiply
from ...threads import Spread, chunks, unthreaded_products
from ...windows.inputs import BLOCK_BYTES, PatchBlocks, SomePatches, as_blocks, for_each_patch
from ..halves import Predictions, Split, plan
from .discriminant import Discriminant, few, summing

ALPHAS = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0)
"""Ridges on a logarithmic grid, in units of a feature's variance within classes."""
INNER_FOLDS = 4
"""Parts into which a fold's training windows are dealt to choose its ridge."""
TASK_SENSORS = 4
"""Sensors for which another process tries ridges at a time."""
WINDOWS_AT_ONCE = 4096
"""Windows of a patch added up or scored at once, so that memory does not grow with the library."""
SCORES_AT_ONCE = 2**17
"""Scores of windows compared at once, by all ridges and classes: they stay in the processor's cache."""
KEPT = 32
"""Times so many windows of which it is kept how they are added up: finding it for each patch is slow."""
VALUES_AT_ONCE = 2**20
"""Features of several patches that are trained on together, where windows are few."""


@dataclass(frozen=True)
class Ridge:
    """Linear discriminant analysis with a ridge and equal priors.

    Least squares onto class indicators with a ridge finds the same directions, but predicting
    the largest output masks classes that lie between others when there are many; the
    discriminant rule does not (Hastie, Tibshirani and Buja 1994,
    doi:10.1080/01621459.1994.10476866; Hastie, Buja and Tibshirani 1995,
    doi:10.1214/aos/1176324456).

    Every feature is scaled by its deviation within classes in the training windows. Gram
    matrices and class sums are formed once a block of windows; those of any training set
    are sums of them. Trainings on few windows solve for these instead.

    Parameters
    ----------
    alphas : tuple of float
        Ridges to choose from, in units of a feature's variance within classes. One is chosen for
        all folds and sensors, so that patches differ by their signals alone and folds do not differ
        by which of two like ridges they took: the largest within one standard error of the best
        (Breiman et al. 1984) in cross-validations within every fold's training windows.
    tuning_sensors : int
        Sensors, evenly taken, on which the choice rests.
    """

    alphas: tuple[float, ...] = ALPHAS
    tuning_sensors: int = 24
    seed: int = 0  # nothing is drawn; other classifiers need one
    workers: int = 2  # threads
    block_bytes: int = BLOCK_BYTES  # features held at a time; changes nothing but memory

    name: ClassVar[str] = "ridge"
    inputs: ClassVar[str] = "features"

    def predict_folds(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Predict every test window by the model of the folds it does not belong to.

        `features` (W, N, D) are of order one, as `window_features` gives them; `labels` (W,) from 0 to A - 1;
        `fold` (W,) is -1 for windows that every fold trains on; `progress` is given the fraction done. The
        predictions have the shape (sum of `is_test`, N), int16.
        """
        work = plan(labels, np.arange(len(labels)), fold, is_test, halvings=0)
        position = np.cumsum(is_test) - 1
        predictions = np.empty((int(is_test.sum()), as_blocks(features).shape[1]), dtype=np.int16)

        def receive(sensor: int, of_sensor: Iterable[Predictions]) -> None:
            for _, windows, activities in of_sensor:
                predictions[position[windows], sensor] = activities[0]

        alpha = self.choose_alpha(features, labels, fold, is_test)
        self.predict_splits(features, labels, work.block, work.splits, alpha, receive, progress)
        return predictions

    def predict_splits(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        block: np.ndarray,
        splits: Sequence[Split],
        alpha: float,
        receive: Callable[[int, Iterable[Predictions]], None],
        progress: Callable[[float], None] | None = None,
    ) -> None:
        """Predict the tested windows of each split by a ridge.

        `block` (W,) is as `halves.plan` gives it. `receive` is given a sensor's number and its predictions,
        for sensors in any order and from several threads.
        """
        sums, alphas = _Splits(labels, block, splits), np.full((len(splits), 1), alpha)
        source = as_blocks(features)
        n_windows, n_patches, width = source.shape
        share = -(-n_patches // (2 * self.workers))  # each thread has two parts or more
        at_once = max(1, min(VALUES_AT_ONCE // (n_windows * width), share))

        def predict(first: int, inputs: np.ndarray) -> None:
            for sensor, found in enumerate(sums.predicted(inputs, alphas), start=first):
                receive(sensor, found)

        with unthreaded_products():
            for_each_patch(source, predict, self.workers, self.block_bytes, progress, at_once)

    def choose_alpha(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        spread: Spread | None = None,
    ) -> float:
        """The ridge of all folds, chosen by cross-validations among the others of each.

        `spread` tries sensors elsewhere.
        """
        if len(np.unique(fold[is_test])) < 3 or len(self.alphas) == 1:
            return self.alphas[len(self.alphas) // 2]
        source = as_blocks(features)
        sensors = np.unique(np.linspace(0, source.shape[1] - 1, self.tuning_sensors).astype(int))
        model, at_once = (replace(self, workers=1), TASK_SENSORS) if spread else (self, len(sensors))
        try_some = partial(model._try_alphas, source, (labels, fold, is_test))
        tried = (spread or map)(try_some, [sensors[some] for some in chunks(len(sensors), at_once)])
        scores = np.concatenate([*tried]).mean(axis=0)
        lag = scores[:, [int(scores.mean(axis=0).argmax())]] - scores  # behind the best, by part and ridge
        error = lag.std(axis=0, ddof=1) / np.sqrt(len(scores))  # of at least three folds' parts
        return self.alphas[int(np.flatnonzero(lag.mean(axis=0) <= error).max())]

    def _try_alphas(
        self, source: PatchBlocks, dealt: tuple[np.ndarray, ...], sensors: np.ndarray
    ) -> np.ndarray:
        """Macro recall of some sensors, by part left out and ridge; windows are `dealt` as for the choice."""
        labels, fold, is_test = dealt
        folds = np.unique(fold[is_test])
        names, block = np.unique(fold, return_inverse=True)
        n_parts = min(INNER_FOLDS, len(folds) - 1)
        parts = np.array(
            [np.isin(names, folds[folds != f][first::n_parts]) for f in folds for first in range(n_parts)]
        )
        left_out = parts | np.repeat(folds[:, None] == names, n_parts, axis=0)
        without, training = np.unique(left_out, axis=0, return_inverse=True)
        training = training.ravel()  # of each part: folds that leave out each other share one
        splits = [Split(np.flatnonzero(~out), np.flatnonzero(is_test & out[block])) for out in without]
        sums = _Splits(labels, block, splits)
        alphas = np.tile(self.alphas, (len(splits), 1))
        shape = len(self.alphas), len(names), sums.n_classes
        counts = [np.bincount(labels[is_test & part[block]], minlength=sums.n_classes) for part in parts]
        windows = np.where(np.array(counts) > 0, counts, np.nan)
        by_sensor = np.empty((len(sensors), len(parts), len(self.alphas)))

        def score(number: int, inputs: np.ndarray) -> None:
            correct = np.zeros((shape[0], *windows.shape))  # by ridge, part and class
            for split, rows, activities in sums.predicted(inputs, alphas)[0]:
                ridge, right = np.nonzero(activities == labels[rows])
                cell = np.ravel_multi_index((ridge, block[rows[right]], labels[rows[right]]), shape)
                by_fold = np.bincount(cell, minlength=math.prod(shape)).reshape(shape)
                correct[:, training == split] += parts[training == split] @ by_fold
            by_sensor[number] = np.nanmean(correct / windows, axis=2).T

        with unthreaded_products():
            for_each_patch(SomePatches(source, sensors), score, self.workers, self.block_bytes // 4, None)
        return by_sensor


class _Sums(NamedTuple):
    """Sums over P sets of windows, of features taken about the class means of all windows."""

    gram: np.ndarray  # (P, D, D): the upper triangle
    of_class: np.ndarray  # (P, A, D)


class _Shared(NamedTuple):
    """Splits whose training sets are made of the same few parts, such as the folds of one trial."""

    splits: slice  # their numbers
    of_parts: np.ndarray  # (splits, parts), float32: 1 for each part that a split trains on
    part: np.ndarray  # (W,), int: of each window


class _Splits:
    """Sums over windows, from which every split's training set is made.

    Those of splits that follow each other and share parts are made from sums over these: of a trial's folds
    each window is added once. So that single precision does for them, features are taken about the class
    means of all windows, which those of a split lie close to.
    """

    def __init__(self, labels: np.ndarray, block: np.ndarray, splits: Sequence[Split]) -> None:
        self.n_classes = int(labels.max()) + 1
        self.labels = labels
        self.tested = [split.tested for split in splits]
        self._blocks = block
        blocks = np.arange(block.max() + 1)
        self.trained = np.array([np.isin(blocks, split.train) for split in splits])
        counts = np.zeros((self.trained.shape[1], self.n_classes), dtype=np.float32)
        np.add.at(counts, (block, labels), 1)
        self._windows = self.trained @ counts
        self.n_trained = self._windows.sum(axis=1)
        self._share = (1 / np.maximum(np.bincount(labels), 1)).astype(np.float32)[:, None]
        self._shared = [*_shared(self.trained, block)]
        self._adding = lru_cache(KEPT)(self._found_adding)
        self._few: dict[int, tuple[np.ndarray, np.ndarray]] = {}
        self._rooms = local()

    def predicted(self, inputs: np.ndarray, alphas: np.ndarray) -> list[list[Predictions]]:
        """Predictions for each patch of some (P, W, D), by each ridge of the split in `alphas`."""
        found: list[list[Predictions]] = [[] for _ in inputs]
        centre = inputs.mean(axis=1, keepdims=True)
        is_few = few(self.n_trained, inputs.shape[2])
        for number in np.flatnonzero(is_few).tolist():
            if number not in self._few:  # the windows it trains on, and their classes as ones and zeros
                some = np.flatnonzero(self.trained[number][self._blocks])
                self._few[number] = some, np.eye(self.n_classes, dtype=np.float32)[self.labels[some]]
            some, member = self._few[number]
            trained = Discriminant.by_windows(_single(inputs[:, some] - centre), member, alphas[number])
            for patch, of_patch in enumerate(found):
                of_patch += self._scored(trained, patch, number, inputs[patch], centre[patch])
        if not is_few.all():
            for patch, of_patch in enumerate(found):
                of_patch += self._by_features(~is_few, inputs[patch], centre[patch], alphas)
        return found

    def _by_features(
        self, chosen: np.ndarray, inputs: np.ndarray, centre: np.ndarray, alphas: np.ndarray
    ) -> Iterator[Predictions]:
        """Predictions for one patch (W, D) in splits that train on many windows."""
        class_means = self._share * sum(
            summing(self.labels[windows], self.n_classes) @ inputs[windows]
            for windows in chunks(len(self.labels), WINDOWS_AT_ONCE)
        )
        about_centre = _single(class_means - centre)
        for numbers, sums in self._of_splits(chosen, inputs, class_means):
            trained = _by_features(sums, about_centre, self._windows[numbers], alphas[numbers])
            for training, number in enumerate(numbers.tolist()):
                yield from self._scored(trained, training, number, inputs, centre)

    def _scored(
        self, trained: Discriminant, training: int, number: int, inputs: np.ndarray, centre: np.ndarray
    ) -> Iterator[Predictions]:
        """A patch's predictions, by one of some trainings, of the windows that a split tests."""
        rows, of_window = self.tested[number], trained.offsets[training].size
        for part in chunks(len(rows), max(1, min(WINDOWS_AT_ONCE, SCORES_AT_ONCE // of_window))):
            some = rows[part]
            scores = trained.scores(training, _single(inputs[some] - centre))
            yield Predictions(number, some, scores.argmax(axis=0).astype(np.int16))

    def _of_splits(
        self, chosen: np.ndarray, inputs: np.ndarray, class_means: np.ndarray
    ) -> Iterator[tuple[np.ndarray, _Sums]]:
        """Numbers of some splits that share parts, and sums over the windows that each of them trains on."""
        shares = {number: each for number, each in enumerate(self._shared) if chosen[each.splits].any()}
        rooms = [self._room(str(n), each.of_parts.shape[1], inputs.shape[1]) for n, each in shares.items()]
        for sums in chain.from_iterable(rooms):
            sums[...] = 0
        for windows in chunks(len(inputs), WINDOWS_AT_ONCE):
            about = _single(inputs[windows] - class_means[self.labels[windows]])
            for number, (grams, of_class) in zip(shares, rooms, strict=True):
                of_part, by_class = self._adding(number, windows.start)
                for rows, gram in zip(of_part, grams, strict=True):
                    if len(rows):
                        add_square(gram, about[rows])
                of_class += (by_class @ about).reshape(of_class.shape)
        for each, of_parts in zip(shares.values(), rooms, strict=True):
            here = chosen[each.splits]
            member = each.of_parts[here]
            of_splits = self._room("of splits", len(member), inputs.shape[1])
            for sums, out in zip(of_parts, of_splits, strict=True):
                multiply(member, sums.reshape(len(sums), -1), out=out.reshape(len(out), -1))
            yield each.splits.start + np.flatnonzero(here), of_splits

    def _found_adding(self, number: int, first: int) -> tuple[list[np.ndarray], csr_array]:
        """Of some windows those of each part that splits share, and what adds up all by part and class."""
        shared, windows = self._shared[number], slice(first, first + WINDOWS_AT_ONCE)
        part, n_parts = shared.part[windows].astype(int), shared.of_parts.shape[1]
        of_class = summing(part * self.n_classes + self.labels[windows], n_parts * self.n_classes)
        return [np.flatnonzero(part == each) for each in range(n_parts)], of_class

    def _room(self, name: str, count: int, width: int) -> _Sums:
        """Memory of this thread for `count` sums; allocated per patch it would take a tenth more time."""
        rooms = self._rooms.__dict__
        if name not in rooms or len(rooms[name].gram) < count:
            shapes = ((count, width, width), (count, self.n_classes, width))
            rooms[name] = _Sums(*(np.empty(shape, dtype=np.float32) for shape in shapes))
        return _Sums(*(sums[:count] for sums in rooms[name]))


def _shared(trained: np.ndarray, block: np.ndarray) -> Iterator[_Shared]:
    """Neighbouring splits, by the blocks (S, B) that each trains on, with hardly more parts than splits."""
    first, part = 0, np.zeros(trained.shape[1], dtype=int)
    for number, row in enumerate(trained):
        finer = np.unique(2 * part + row, return_inverse=True)[1]
        if finer.max() > number - first + 2:
            yield _of_parts(trained, slice(first, number), part, block)
            first, finer = number, np.unique(row, return_inverse=True)[1]
        part = finer
    yield _of_parts(trained, slice(first, len(trained)), part, block)


def _of_parts(trained: np.ndarray, splits: slice, part: np.ndarray, block: np.ndarray) -> _Shared:
    """Splits by the part of each block (B,)."""
    one = np.unique(part, return_index=True)[1]  # a block of each part
    return _Shared(
        splits, trained[splits, one].astype(np.float32), part[block].astype(np.min_scalar_type(len(one)))
    )


def _by_features(
    sums: _Sums, class_means: np.ndarray, windows: np.ndarray, ridges: np.ndarray
) -> Discriminant:
    """The discriminant of P splits from their sums, with the class means (A, D) that features are about."""
    within, seen = sums.gram, windows[..., None]
    about = sums.of_class / np.maximum(seen, 1)
    # all windows' squares: those about the class means, and those of the class means
    squares = np.einsum("pad,ad->pd", 2 * sums.of_class + seen * class_means, class_means)
    whole = np.einsum("pdd->pd", within) + squares
    for of_split, means in zip(within, about * np.sqrt(seen), strict=True):
        add_square(of_split, means, -1.0)
    return Discriminant.by_features(within, whole, about + class_means, windows, ridges)


def _single(features: np.ndarray) -> np.ndarray:
    """Features in single precision, which is enough once they are taken about a mean."""
    return features.astype(np.float32, copy=False)
