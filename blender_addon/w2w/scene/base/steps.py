# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that pauses after each step so that the window stays alive, and says how far it has come."""

from collections.abc import Callable, Generator
from contextlib import closing
from typing import Any, TypeVar

Step = TypeVar("Step")
Other = TypeVar("Other")
Result = TypeVar("Result")


def without_pauses(steps: Generator[Any, None, Result]) -> Result:
    """Run work through to its result."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return stop.value


def each_as(
    steps: Generator[Step, None, Result], change: Callable[[Step], Other]
) -> Generator[Other, None, Result]:
    """The same work, with a function applied to each step."""
    with closing(steps):
        while True:
            try:
                step = next(steps)
            except StopIteration as stop:
                return stop.value
            yield change(step)


def scaled(shares: Generator[float, None, Result], low: float, high: float) -> Generator[float, None, Result]:
    """Work as a part of other work, from one share of that to the next."""
    return each_as(shares, lambda share: low + (high - low) * share)
