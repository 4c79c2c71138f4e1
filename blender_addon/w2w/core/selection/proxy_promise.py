# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sets that the paper's proxy chooses would reach on other clips, worn together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .advice import Advice
from .promise import Choose, promise
from .set_tests import SetTests, Tests
from .subsets import Subset, exact_order, greedy_order
from .terms import Terms


def greedy_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose by the mean of maxima over a half's own map, as `greedy_subset` does."""
    return greedy_order(replace(terms, f1=half.map, max_size=size))[:size]


def exact_by_half(half: Tests, terms: Terms, size: int) -> list[int]:
    """Choose the best set of a size over a half's own map, as `exact_subset` does."""
    return exact_order(replace(terms, f1=half.map), size)


def promised(
    subset: Subset, tests: SetTests, terms: Terms, expected: Sequence[np.ndarray], choose: Choose
) -> Subset:
    """A set with what it would reach on other clips, worn together.

    Parameters
    ----------
    subset : Subset
    tests : SetTests
    terms : Terms
        Under which it was chosen.
    expected : three ndarrays, shape (N,)
        Expected macro F1 of each patch alone and its interval.
    choose : callable
        How it was chosen, from the tests of a half.
    """
    alone = tuple(float(values[subset.order[0]]) for values in expected)
    return replace(subset, promise=promise(tests, terms, subset.order, choose, alone))


def advice_promised(advice: Advice, tests: SetTests, terms: Terms, expected: Sequence[np.ndarray]) -> Advice:
    """Advice whose sets have what they would reach on other clips."""
    subset = promised(advice.subset, tests, terms, expected, greedy_by_half)
    exact = advice.exact
    if len(advice.sets) > 1:
        exact = promised(exact, tests, terms, expected, exact_by_half)
    elif exact is not None:
        exact = replace(exact, promise=subset.promise)  # one set, one promise
    return replace(advice, subset=subset, exact=exact)
