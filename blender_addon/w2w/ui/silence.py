# SPDX-License-Identifier: GPL-3.0-or-later
"""Set properties without their update functions answering, for code that does their work itself."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

_depth = 0


@contextmanager
def without_updates() -> Iterator[None]:
    """Inside, `is_silent` holds and update functions do nothing."""
    global _depth
    _depth += 1
    try:
        yield
    finally:
        _depth -= 1


def is_silent() -> bool:
    """Whether updates shall do nothing."""
    return _depth > 0
