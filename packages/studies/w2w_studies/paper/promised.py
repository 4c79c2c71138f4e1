# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sets that the paper's proxy chooses would reach on other clips, worn together."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from w2w.core.selection.constraints import Terms
from w2w.core.selection.promise import Choose, Promises, random_sets
from w2w.core.selection.set_tests import Tests

from .subsets import Subset, counted_columns, exact_order, greedy_order

FEW_SENSORS = 6
"""Sensors up to which all random sets are tried, with every number of sensors."""

LARGE_RANDOM_SETS = 4
"""Random sets that are tried with more sensors; on 826 clips such sets differ by an F1 of .01 to .03."""


class LargePromises(Promises):
    """Promises of sets of any size: beyond a few sensors some sizes are tested, by fewer random sets."""

    def level(self, tests: Tests, size: int) -> np.ndarray:
        """Mean F1 of sets drawn at random, by their size, shape (size, A)."""
        level = super().level(tests, min(size, FEW_SENSORS))
        if size <= FEW_SENSORS:
            return level
        level = self._levels[tests]
        if len(level) < size:
            sets = random_sets(self.terms, size, self.tests.seed)[:LARGE_RANDOM_SETS]
            level = np.concatenate([level, _level_beyond(tests, sets, level, size)])
            self._levels[tests] = level
        return level[:size]

    def delivered(self, order: Sequence[int], there: Tests) -> np.ndarray:
        """F1 of a set, by its size, shape (K, A); sizes that are not tested lie on straight lines."""
        sizes = _sizes_tried(len(order))
        return _between(there.f1_of_firsts([order], sizes)[0], sizes)


def map_of(half: Tests) -> np.ndarray:
    """F1 (N, A) of each patch alone to choose sets by, of the activities that count and can be tested."""
    shown = half.trial.testable
    return counted_columns(half.alone[shown].T, half.weights[shown])


def greedy_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose by the mean of maxima over a half's own map, as `greedy_subset` does."""
    return greedy_order(map_of(half), replace(terms, max_size=size))[:size]


def exact_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose the best set of a size over a half's own map, as `exact_subset` does."""
    return exact_order(map_of(half), terms, size)


def promised(subset: Subset, promises: Promises, expected: Sequence[np.ndarray], choose: Choose) -> Subset:
    """A set with what it would reach on other clips, worn together.

    `promises`: under the terms it was chosen under.
    `expected` (N,): expected macro F1 of each patch alone and its interval.
    `choose`: how it was chosen, from the tests of a half.
    """
    alone = tuple(float(values[subset.order[0]]) for values in expected)
    return replace(subset, promise=promises.of(subset.order, choose, alone))


def _level_beyond(tests: Tests, sets: Sequence[Sequence[int]], level: np.ndarray, size: int) -> np.ndarray:
    """The level of larger sets, by a few of them at some sizes: they differ less.

    Their lead over all random sets, at the largest size at which all are known, counts for the share that
    those patches have in a larger set.
    """
    known = len(level)
    sizes = [known, *(tried for tried in _sizes_tried(size) if tried > known)]
    found = tests.f1_of_firsts(sets, sizes).mean(axis=0)
    found = found + (level[-1] - found[0]) * (known / np.array(sizes))[:, None]
    return _between(found, sizes)[1:]


def _sizes_tried(size: int) -> list[int]:
    """Numbers of sensors up to a size: every one while they are few, then a third more each time."""
    sizes = list(range(1, min(size, FEW_SENSORS) + 1))
    while sizes[-1] < size:
        sizes.append(min(sizes[-1] + sizes[-1] // 3, size))
    return sizes


def _between(values: np.ndarray, sizes: Sequence[int]) -> np.ndarray:
    """Values (K, A) at some numbers of sensors and, on straight lines between, at all from the first on."""
    every = np.arange(sizes[0], sizes[-1] + 1)
    return np.stack([np.interp(every, sizes, of_activity) for of_activity in values.T], axis=1)
