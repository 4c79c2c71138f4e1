# SPDX-License-Identifier: GPL-3.0-or-later
"""Some of the windows that a record holds field by field."""

from typing import NamedTuple, TypeVar

import numpy as np

from w2w.core.windows.inputs import PatchBlocks, SomeWindows

Windows = TypeVar("Windows", bound=NamedTuple)


def some_windows(windows: Windows, rows: np.ndarray) -> Windows:
    """Some of the windows, by a mask: of every array and source of blocks; other fields stay.

    `rows` (W,) of bool.
    `windows`: with arrays of shape (W, ...) and sources of blocks of W windows.
    """
    index = np.flatnonzero(rows)

    def kept(field: object) -> object:
        if isinstance(field, np.ndarray):
            return field[index]
        if isinstance(field, SomeWindows):  # no block is read through two selections
            return SomeWindows(field.source, field.rows[index])
        return SomeWindows(field, index) if isinstance(field, PatchBlocks) else field

    return windows._make(map(kept, windows))
