# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sets that the paper's proxy chooses would reach on other clips, worn together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from w2w.core.selection.constraints import Terms
from w2w.core.selection.promise import Choose, Promises
from w2w.core.selection.set_tests import Tests

from .subsets import Subset, exact_order, greedy_order


def greedy_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose by the mean of maxima over a half's own map, as `greedy_subset` does."""
    return greedy_order(half.map, replace(terms, max_size=size))[:size]


def exact_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose the best set of a size over a half's own map, as `exact_subset` does."""
    return exact_order(half.map, terms, size)


def promised(subset: Subset, promises: Promises, expected: Sequence[np.ndarray], choose: Choose) -> Subset:
    """A set with what it would reach on other clips, worn together.

    `promises`: under the terms it was chosen under.
    `expected` (N,): expected macro F1 of each patch alone and its interval.
    `choose`: how it was chosen, from the tests of a half.
    """
    alone = tuple(float(values[subset.order[0]]) for values in expected)
    return replace(subset, promise=promises.of(subset.order, choose, alone))
