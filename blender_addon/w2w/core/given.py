# SPDX-License-Identifier: GPL-3.0-or-later
"""What people give from Python: paths, numbers, and a clip's place among others."""

import os
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np


def given_path(path: object, what: str) -> Path:
    """The path of `what`, such as "a recording"; a ValueError if it is none."""
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"{what} is given by its path, not by {type(path).__name__}")
    if not os.fspath(path):
        raise ValueError(f"{what} is given by its path: this one is empty")
    return Path(path)


def given_numbers(values: Any, what: str, dtype: type[np.floating] = np.float64) -> np.ndarray:
    """The array of `what`, such as "poses"; a ValueError if not all of it are numbers."""
    try:
        with np.errstate(over="ignore"):  # infinity is told by who needs finite numbers
            return np.asarray(values, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise ValueError(f"{what} must be an array of numbers, all of one shape") from error


def clip_number(index: object) -> int:
    """The number of a clip in a sequence; a ValueError for a name or the like."""
    if not isinstance(index, Integral):
        raise ValueError(f"clips are taken by number or slice, such as [0] or [:3], not by {index!r}")
    return int(index)
