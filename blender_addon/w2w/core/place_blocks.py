# SPDX-License-Identifier: GPL-3.0-or-later
"""A library's windows, served some places at a time, so that ranking never holds all of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

BLOCK_BYTES = 256 * 2**20
"""Memory for the places held at a time."""

ITEM_BYTES = np.dtype(np.float32).itemsize


@runtime_checkable
class PlaceBlocks(Protocol):
    """What classifiers train on: W windows of N places, in single precision."""

    @property
    def shape(self) -> tuple[int, ...]:
        """(W, N, D) for features, (W, N, samples, 6) for windows."""

    def places(self, first: int, last: int) -> np.ndarray:
        """All windows of the places from `first` to before `last`, shape (W, last - first, ...)."""


@dataclass(frozen=True, eq=False)
class ArrayBlocks:
    """An array in memory as `PlaceBlocks`.

    Parameters
    ----------
    array : ndarray, shape (W, N, ...)
    """

    array: np.ndarray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the array."""
        return self.array.shape

    def places(self, first: int, last: int) -> np.ndarray:
        """A view of some places."""
        return self.array[:, first:last]


@dataclass(frozen=True, eq=False)
class SomeWindows:
    """Some windows of another source.

    Parameters
    ----------
    source : PlaceBlocks
    rows : ndarray of int, shape (V,)
        The windows wanted.
    """

    source: PlaceBlocks
    rows: np.ndarray

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of what is wanted."""
        return (len(self.rows), *self.source.shape[1:])

    def places(self, first: int, last: int) -> np.ndarray:
        """The wanted windows of some places; no second copy where the source has made one."""
        block = self.source.places(first, last)
        if np.array_equal(self.rows, np.arange(len(block))):
            return block
        if not getattr(self.source, "fresh", False) or (np.diff(self.rows) <= 0).any():
            return block[self.rows]
        for target, row in enumerate(self.rows):  # moved up one by one: each stands at its place or after it
            block[target] = block[row]
        return block[: len(self.rows)]


def as_blocks(inputs: np.ndarray | PlaceBlocks) -> PlaceBlocks:
    """An array in memory, or a source that serves blocks already, as a source."""
    return inputs if isinstance(inputs, PlaceBlocks) else ArrayBlocks(np.asarray(inputs))


def spans(source: PlaceBlocks, budget: int = BLOCK_BYTES) -> Iterator[tuple[int, int]]:
    """First and last place, exclusive, of blocks that keep to a budget of bytes, if one place does."""
    n_windows, n_places, *rest = source.shape
    size = max(1, budget // max(1, n_windows * math.prod(rest) * ITEM_BYTES))
    for first in range(0, n_places, size):
        yield first, min(first + size, n_places)
