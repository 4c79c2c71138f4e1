# SPDX-License-Identifier: GPL-3.0-or-later
"""Which values of a parameter are tested by day."""

from collections.abc import Iterable

import pytest


def by_day(some: Iterable, every: Iterable) -> list:
    """Every value; those that are not among some run by night."""
    some = list(some)
    return [value if value in some else pytest.param(value, marks=pytest.mark.slow) for value in every]
