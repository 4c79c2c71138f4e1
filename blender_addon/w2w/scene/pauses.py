# SPDX-License-Identifier: GPL-3.0-or-later
"""Work that pauses, so that a window stays alive, done at once where there is no window."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, TypeVar

Result = TypeVar("Result")


def without_pauses(steps: Generator[Any, None, Result]) -> Result:
    """Run a generator through; what it comes to."""
    while True:
        try:
            next(steps)
        except StopIteration as stop:
            return stop.value
