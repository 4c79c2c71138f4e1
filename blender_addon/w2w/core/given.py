# SPDX-License-Identifier: GPL-3.0-or-later
"""What people give from Python: paths, numbers, and clips by number or slice."""

import os
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar, cast, overload

import numpy as np

from .wording import restated

Clip = TypeVar("Clip", covariant=True)


def given_path(path: object, what: str) -> Path:
    """The path of `what`, such as "a recording"; a ValueError if it is none."""
    if not isinstance(path, str | os.PathLike):
        raise ValueError(f"{what} is given by its path, not by {type(path).__name__}")
    if not os.fspath(path):
        raise ValueError(f"{what} is given by its path: this one is empty")
    return Path(path)


def given_numbers(values: Any, what: str, dtype: type[np.floating] = np.float64) -> np.ndarray:
    """The array of `what`, such as "poses"; a ValueError if not all of it are numbers."""
    wrong = f"{what} must be an array of numbers, all of one shape"
    # infinity is told by who needs finite numbers
    with restated(wrong, (TypeError, ValueError)), np.errstate(over="ignore"):
        return np.asarray(values, dtype=dtype)


class Clips(Sequence[Clip]):
    """A record of clips as a sequence; a slice of it is a record, too."""

    of_clips: ClassVar[tuple[str, ...]]
    """Fields with an item for each clip, the clips themselves first."""

    @overload
    def __getitem__(self, index: int) -> Clip: ...
    @overload
    def __getitem__(self, index: slice) -> Self: ...
    def __getitem__(self, index: int | slice) -> Clip | Self:
        if isinstance(index, slice):
            return replace(cast(Any, self), **{name: getattr(self, name)[index] for name in self.of_clips})
        if not isinstance(index, Integral):
            raise ValueError(f"clips are taken by number or slice, such as [0] or [:3], not by {index!r}")
        return getattr(self, self.of_clips[0])[int(index)]

    def __len__(self) -> int:
        return len(getattr(self, self.of_clips[0]))
