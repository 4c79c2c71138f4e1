# SPDX-License-Identifier: GPL-3.0-or-later
"""A data set's npz archive, opened."""

from __future__ import annotations

from pathlib import Path

import numpy as np


def open_archive(path: str | Path) -> np.lib.npyio.NpzFile:
    """Open an npz archive of plain arrays.

    Raises
    ------
    ValueError
        If the file is none.
    """
    archive = np.load(path, allow_pickle=False)
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise ValueError(f"{path} is no npz archive")
    return archive
