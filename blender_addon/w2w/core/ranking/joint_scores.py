# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches worn together: class scores of one classifier on a set of patches, for every next patch.

Where windows are many, a patch enters by its features (`_Primal`): products that trainings share are formed
once, and the part that patches worn explain is taken out by the inverse of a matrix in blocks. Where windows
are few for all features worn, it enters by its kernel between windows (`_Dual`; Saunders, Gammerman and Vovk
1998).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import chain, islice, pairwise, repeat
from typing import NamedTuple

import numpy as np
from scipy.linalg import cholesky, solve_triangular

from ..blas import add_square, multiply, multiply_lower, solve_positive
from ..threads import chunks, for_each, n_threads, unthreaded_products
from .classifiers.discriminant import averaging, deviation, few, summing, with_ridge

KERNEL_VALUES = 2**20
"""Values of kernels that are held at a time."""

KEPT_VALUES = 2**21
"""Values of kernels that a training keeps: in memory, 8 MB."""


class Training(NamedTuple):
    """Windows trained on, and windows tested on what was trained."""

    trained: np.ndarray
    tested: np.ndarray


class JointScores:
    """Ridge discriminant analysis on several patches' features side by side.

    It is the classifier of `Ridge` with the ridge multiplied by the number of patches, so that the
    kernel of a set is the mean of its patches' kernels and a wide set is held back no less than a
    single patch.

    Takes features (N, W, D), float32, about their means over windows, labels (W,), 0 to A - 1, and a ridge in
    units of a feature's variance within classes.
    `windows` (V,) are those tested, in the order of the scores: training by training.
    """

    def __init__(
        self,
        features: np.ndarray,
        labels: np.ndarray,
        trainings: Sequence[Training],
        ridge: float,
    ) -> None:
        self.n_patches, _, self._width = features.shape
        self._duals = [_Dual(features, labels, training, ridge) for training in trainings]
        self._primal = _Primal(features, labels, self._duals)
        self.windows = np.concatenate([training.tested for training in trainings])

    def of_added(
        self, worn: Sequence[int], candidates: Iterable[int], judge: Callable[[np.ndarray], np.ndarray]
    ) -> list[np.ndarray]:
        """Judge the patches worn and one more, for each candidate.

        `judge` is given scores (V, A), float32: logarithms of the classes' probabilities, but for a term that
        all classes share. It is called from several threads.
        """
        candidates, wide = list(candidates), self._is_wide(len(worn))
        with unthreaded_products():
            add = self.adding_by_kernels(worn) if wide else self.adding_by_features(worn)
        at_once = min(self._at_once, len(candidates) // n_threads() + 1) if wide else 1
        parts = [candidates[rows] for rows in chunks(len(candidates), at_once)]
        return list(chain.from_iterable(for_each(lambda part: list(map(judge, add(part))), parts)))

    def _is_wide(self, worn: int) -> bool:
        """Whether some training has few windows, or fewer than features worn."""
        fewest = np.array(min(len(dual.training.trained) for dual in self._duals))
        return bool(few(fewest, self._width) or worn * self._width > fewest)

    def adding_by_features(self, worn: Sequence[int]) -> Callable[[Sequence[int]], Iterable[np.ndarray]]:
        """Scores (V, A) by the patches worn and one more, for each of some."""
        alone = self._primal.scores
        return partial(map, partial(self._primal.add, self._primal.wear(worn)) if len(worn) else alone)

    def adding_by_kernels(self, worn: Sequence[int]) -> Callable[[Sequence[int]], Iterable[np.ndarray]]:
        """Scores (V, A) by the patches worn and one more, for each of some, if windows are few."""
        bases = for_each(lambda dual: dual.kernels(worn).summed(), self._duals)

        def add(candidates: Sequence[int]) -> np.ndarray:
            pairs = zip(self._duals, bases, strict=True)
            sums = ((dual, dual.kernels(candidates).plus(base)) for dual, base in pairs)
            return np.concatenate([dual.scores(kernels, len(worn) + 1) for dual, kernels in sums], axis=1)

        return add

    def each_first_of(
        self, orders: Sequence[Sequence[int]], sizes: Sequence[int]
    ) -> Iterator[tuple[np.ndarray, ...]]:
        """Scores (V, A) by the first patches of each of some ascending sizes, of one order after another."""
        wide = [size for size in sizes if self._is_wide(size - 1)]
        few = [order[:size] for order in orders for size in sizes if size not in wide]
        by_features = iter(for_each(lambda worn: self._primal.scores(*worn), few))
        for by_kernels in self._each_by_kernels(orders, wide) if wide else repeat((), len(orders)):
            yield (*islice(by_features, len(sizes) - len(wide)), *by_kernels)

    def _each_by_kernels(
        self, orders: Sequence[Sequence[int]], sizes: Sequence[int]
    ) -> Iterator[tuple[np.ndarray, ...]]:
        def scores(orders_and_dual: tuple[Sequence[Sequence[int]], _Dual]) -> list[np.ndarray]:
            some, dual = orders_and_dual
            return list(dual.of_firsts(some, sizes))

        parts = [orders[part] for part in chunks(len(orders), self._at_once)]
        found = for_each(scores, [(some, dual) for some in parts for dual in self._duals])
        for rows in chunks(len(found), len(self._duals)):
            of_sizes = (np.concatenate(of_size, axis=1) for of_size in zip(*found[rows], strict=True))
            yield from zip(*of_sizes, strict=True)

    @property
    def _at_once(self) -> int:
        """Sets whose kernels are held at a time."""
        most = max(len(dual.training.trained) for dual in self._duals)
        return max(1, KERNEL_VALUES // most**2)


class _Kernels(NamedTuple):
    """Products of features in units of their deviation within classes, for each of S patches or sets of them.

    Between n windows trained on about their class means (within), A class means, and v windows tested.
    """

    within_within: np.ndarray  # (S, n, n): the upper triangle
    means_within: np.ndarray  # (S, A, n)
    tested_within: np.ndarray  # (S, v, n)
    tested_means: np.ndarray  # (S, v, A)
    means_means: np.ndarray  # (S, A): of each class mean with itself

    def copy(self) -> _Kernels:
        """These in memory of their own."""
        return _Kernels(*(products.copy() for products in self))

    def plus(self, others: _Kernels) -> _Kernels:
        """These, with others added in place: sets with one more patch."""
        for own, other in zip(self, others, strict=True):
            own += other
        return self

    def summed(self) -> _Kernels:
        """Kernels of all patches as one set."""
        return _Kernels(*(products.sum(axis=0, keepdims=True) for products in self))


class _Dual:
    """One training, solved for its windows."""

    def __init__(self, features: np.ndarray, labels: np.ndarray, training: Training, ridge: float) -> None:
        self._features, self.training = features, training
        self.n_activities = int(labels.max()) + 1
        self._labels = labels[training.trained]
        self._counts = np.bincount(self._labels, minlength=self.n_activities).astype(np.float32)
        self._average = averaging(self._labels, self.n_activities).toarray()
        self.ridge = np.float32(ridge * len(self._labels))
        self._kept: dict[int, _Kernels] = {}

    def kernels(self, patches: Sequence[int]) -> _Kernels:
        """Kernels of each patch; those found first are kept, as the next step wants most of them again."""
        due = [patch for patch in patches if patch not in self._kept]
        found = self._found(due)
        of_due = dict(zip(due, map(_Kernels._make, zip(*found, strict=True)), strict=True))
        room = max(KEPT_VALUES // len(self._labels) ** 2 - len(self._kept), 0)
        self._kept.update({patch: of_due[patch].copy() for patch in due[:room]})
        if len(due) == len(patches):
            return found
        every = [of_due.get(patch) or self._kept[patch] for patch in patches]
        return _Kernels(*map(np.stack, zip(*every, strict=True)))

    def _found(self, patches: Sequence[int]) -> _Kernels:
        rows = np.asarray(patches, dtype=int)[:, None]
        seen = self._features[rows, self.training.trained]
        means = self._average @ seen
        within = seen - means[:, self._labels]
        variances = (np.einsum("pnd,pnd->pd", some, some) / seen.shape[1] for some in (within, seen))
        scale = deviation(*variances).astype(np.float32)[:, None]
        within /= scale
        means /= scale
        tested = self._features[rows, self.training.tested] / scale
        columns = within.swapaxes(1, 2)
        squares = np.zeros((len(within), *(within.shape[1],) * 2), dtype=np.float32)
        for square, of_patch in zip(squares, columns, strict=True):
            add_square(square, of_patch)
        return _Kernels(
            squares, means @ columns, tested @ columns, tested @ means.swapaxes(1, 2),
            np.einsum("pad,pad->pa", means, means),
        )  # fmt: skip

    def of_firsts(self, orders: Sequence[Sequence[int]], sizes: Iterable[int]) -> Iterator[np.ndarray]:
        """Scores (S, v, A) by the first patches of S orders, for each of the ascending `sizes`."""
        kernels = None
        for before, count in pairwise([0, *sizes]):
            for place in range(before, count):
                own = self.kernels([order[place] for order in orders])
                kernels = own.plus(kernels) if kernels else own
            if kernels:
                yield self.scores(kernels, count)

    def scores(self, kernels: _Kernels, count: int) -> np.ndarray:
        """Scores (S, v, A) by sets of `count` patches."""
        ridge = self.ridge * count
        pairs = zip(kernels.within_within, kernels.means_within, strict=True)
        solved = [solve_positive(with_ridge(within.copy(), ridge), means) for within, means in pairs]
        means = np.stack(solved)
        products = kernels.tested_means - kernels.tested_within @ means.swapaxes(1, 2)
        norms = kernels.means_means - np.einsum("san,san->sa", kernels.means_within, means)
        return self.offset(products / ridge, norms / ridge)

    def offset(self, products: np.ndarray, norms: np.ndarray) -> np.ndarray:
        """Scores (..., v, A) from products with the class means and the squared lengths (..., A) of these."""
        offset = np.where(self._counts > 0, norms / 2, np.inf).astype(np.float32)[..., None, :]
        return (products - offset) * np.float32(len(self._labels))


class _FeatureSums(NamedTuple):
    """Features (W, D) of a patch or of several side by side, and sums over each of T trainings."""

    about: np.ndarray  # (W, D): about the class means of all windows, part by part
    apart: np.ndarray  # (T, A, D): the trainings' class means about these, times the roots of their windows
    scale: np.ndarray  # (T, D): deviation within classes; infinite for features that never vary
    gram: np.ndarray  # (T, D, D): of windows about their class means over `scale`, the upper triangle
    means: np.ndarray  # (T, A, D): class means over `scale`


class _Base(NamedTuple):
    """Scores by the K features of patches worn in one training of A classes, tested on v windows."""

    inverse: np.ndarray  # (K, K): of the Cholesky factor of their Gram matrix
    means: np.ndarray  # (A, K): by that inverse
    tested: np.ndarray  # (v, K): by that inverse
    scores: np.ndarray  # (v, A)
    norms: np.ndarray  # (A,)


class _Primal:
    """All trainings at once, solved for features.

    The windows are dealt to parts that every training has whole or not at all, such as folds. Products of
    features are formed once per part; those of a training are sums of them. Features are taken about the
    class means of all windows, which are close to those of a training, so that single precision is enough.
    """

    def __init__(self, features: np.ndarray, labels: np.ndarray, duals: Sequence[_Dual]) -> None:
        self._features, self._duals = features, duals
        has = np.zeros((len(duals), len(labels)), dtype=bool)
        for row, dual in zip(has, duals, strict=True):
            row[dual.training.trained] = True
        used = np.flatnonzero(has.any(axis=0))
        kinds, part = np.unique(has[:, used], axis=1, return_inverse=True)
        self._of_part = kinds.astype(np.float32)
        order = np.lexsort((labels[used], part.ravel()))
        self._windows, part = used[order], part.ravel()[order]
        self._labels = labels[self._windows]
        n_parts, n_activities = kinds.shape[1], duals[0].n_activities
        self._parts = [slice(*pair) for pair in pairwise(np.searchsorted(part, np.arange(n_parts + 1)))]
        self._of_cell = summing(part * n_activities + self._labels, n_parts * n_activities)
        self._summed_parts = summing(part, n_parts)
        self._counts = self._summed(np.ones((len(self._windows), 1), dtype=np.float32))[..., 0]
        self._average = averaging(self._labels, n_activities)

    def wear(self, patches: Sequence[int]) -> tuple[_FeatureSums, list[_Base]]:
        """The patches' sums, and their scores in each training, where one more will be worn."""
        features = np.concatenate([self._features[patch] for patch in patches], axis=1)
        worn = self._sums(features)
        return worn, [self._base(features, worn, number, len(patches)) for number in range(len(self._duals))]

    def add(self, worn: tuple[_FeatureSums, list[_Base]], patch: int) -> np.ndarray:
        """Scores (V, A) by the patches worn and one more, training by training."""
        features, scores = self._features[patch], []
        count = worn[0].scale.shape[1] // features.shape[1] + 1
        own = self._sums(features)
        trainings = zip(self._duals, worn[1], self._shared(worn[0], own), *own[2:], strict=True)
        for dual, base, shared, scale, gram, means in trainings:
            crossed = multiply_lower(base.inverse, shared)
            add_square(with_ridge(gram, dual.ridge * count), crossed, -1.0)
            apart = means - multiply(base.means, crossed)
            slopes = solve_positive(gram, apart)
            products = multiply(features[dual.training.tested], (slopes / scale).T)
            products += base.scores - multiply(base.tested, multiply(crossed, slopes.T))
            scores.append(dual.offset(products, base.norms + (apart * slopes).sum(axis=1)))
        return np.concatenate(scores)

    def scores(self, *patches: int) -> np.ndarray:
        """Scores (V, A) by patches worn together, training by training."""
        features, scores = np.concatenate([self._features[patch] for patch in patches], axis=1), []
        for dual, scale, gram, means in zip(self._duals, *self._sums(features)[2:], strict=True):
            slopes = solve_positive(with_ridge(gram, dual.ridge * len(patches)), means)
            products = multiply(features[dual.training.tested], (slopes / scale).T)
            scores.append(dual.offset(products, (means * slopes).sum(axis=1)))
        return np.concatenate(scores)

    def _sums(self, features: np.ndarray) -> _FeatureSums:
        inputs = features[self._windows]
        centre = self._average @ inputs
        about = inputs - centre[self._labels]
        roots = np.sqrt(np.maximum(self._counts, 1))[..., None]
        apart = self._summed(about) / roots
        gram = np.zeros((len(self._parts), *(features.shape[1],) * 2), dtype=np.float32)
        for of_part, rows in zip(gram, self._parts, strict=True):
            add_square(of_part, about[rows])
        gram = self._of_trainings(gram)
        for of_training, means in zip(gram, apart, strict=True):
            add_square(of_training, means, -1.0)
        trained = self._counts.sum(axis=1)[:, None]
        whole = self._of_trainings(self._summed_parts @ np.square(inputs)) / trained
        scale = deviation(np.einsum("tdd->td", gram) / trained, whole).astype(np.float32)
        gram /= scale[:, :, None]
        gram /= scale[:, None]
        return _FeatureSums(about, apart, scale, gram, (centre + apart / roots) / scale[:, None])

    def _shared(self, worn: _FeatureSums, own: _FeatureSums) -> np.ndarray:
        """Products (T, K, D) of the features worn with a patch's, as in `_FeatureSums.gram`."""
        shared = np.empty((len(self._parts), worn.about.shape[1], own.about.shape[1]), dtype=np.float32)
        for of_part, rows in zip(shared, self._parts, strict=True):
            multiply(worn.about[rows].T, own.about[rows], out=of_part)
        shared = self._of_trainings(shared)
        for of_training, means_worn, means in zip(shared, worn.apart, own.apart, strict=True):
            of_training -= multiply(means_worn.T, means)
        shared /= worn.scale[:, :, None]
        shared /= own.scale[:, None]
        return shared

    def _base(self, features: np.ndarray, worn: _FeatureSums, number: int, count: int) -> _Base:
        """Scores by `count` patches' features (W, K) in a training, where one more will be worn."""
        dual = self._duals[number]
        upper = with_ridge(worn.gram[number].copy(), dual.ridge * (count + 1))
        lower = cholesky(upper, overwrite_a=True, check_finite=False).T
        identity = np.eye(len(lower), dtype=np.float32)
        inverse = solve_triangular(lower, identity, lower=True, check_finite=False)
        means = multiply(worn.means[number], inverse.T)
        tested = multiply(features[dual.training.tested] / worn.scale[number], inverse.T)
        return _Base(inverse, means, tested, multiply(tested, means.T), np.einsum("ak,ak->a", means, means))

    def _summed(self, rows: np.ndarray) -> np.ndarray:
        """Sums (T, A, D) of rows (W, D) over each training's windows of each class."""
        return self._of_trainings((self._of_cell @ rows).reshape(len(self._parts), -1, rows.shape[1]))

    def _of_trainings(self, of_parts: np.ndarray) -> np.ndarray:
        """Sums (T, ...) over each training's parts, of sums (P, ...) over the windows of each part."""
        sums = multiply(self._of_part, of_parts.reshape(len(of_parts), -1))
        return sums.reshape(-1, *of_parts.shape[1:])
