# SPDX-License-Identifier: GPL-3.0-or-later
"""Which values of a parameter are tested by day."""

from collections.abc import Iterable, Sequence
from itertools import cycle, islice, product

import pytest


def by_day(some: Iterable, every: Iterable) -> list:
    """Every value, or tuple of values; those that are not among some run by night."""
    some = list(some)
    return [value if value in some else _by_night(value) for value in every]


def _by_night(value: object):
    return pytest.param(*(value if isinstance(value, tuple) else (value,)), marks=pytest.mark.slow)


def each_by_day(*parameters: Sequence) -> list:
    """Every combination of some parameters' values; by day as many as have each value once."""
    some = islice(zip(*map(cycle, parameters), strict=True), max(map(len, parameters)))
    return by_day(some, product(*parameters))
