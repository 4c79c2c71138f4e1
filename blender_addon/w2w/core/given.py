# SPDX-License-Identifier: GPL-3.0-or-later
"""What people give: paths and numbers from Python, clips by number or slice, names in a folder's files."""

import os
import re
import stat
from collections.abc import Sequence
from dataclasses import replace
from numbers import Integral
from pathlib import Path
from typing import Any, ClassVar, Self, TypeGuard, TypeVar, cast, overload

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


PLAIN = re.compile(r"(?![. ]+(?:/|\Z))[^/\\:\x00-\x1f\x7f]+(?:/(?![. ]+(?:/|\Z))[^/\\:\x00-\x1f\x7f]+)*")
"""A path below a folder, on any system: no `..`, no empty part, no drive, no backslash."""

FORBIDDEN = re.compile(r'[/\\:*?"<>|\x00-\x1f\x7f\s]+')
"""Characters that not every system allows in a file's name, and spaces."""


class ForeignFileError(ValueError):
    """A file that W2W did not write, or a name that leads out of its folder; the message names it."""


def inside(folder: Path, name: object) -> Path:
    """The path of a file in a folder, by a name that the folder's own files give.

    Raises ForeignFileError if the name, or a link on the way, leads out of the folder, or to a pipe or
    device. The folder may be a link itself, and nothing need exist.
    """
    place = os.fspath(folder)
    name = checked(name, place)
    for part in name.split("/"):
        place = os.path.join(place, part)  # noqa: PTH118 - a path costs more than the call
        try:
            mode = os.lstat(place).st_mode
            if stat.S_ISLNK(mode):
                if not Path(os.path.realpath(place)).is_relative_to(os.path.realpath(folder)):
                    raise ForeignFileError(
                        f"{place} is a link that leads out of the folder: put there what it leads to"
                    )
                mode = os.stat(place).st_mode  # noqa: PTH116
        except (FileNotFoundError, NotADirectoryError):
            break
        if not (stat.S_ISREG(mode) or stat.S_ISDIR(mode)):
            raise ForeignFileError(f"{place} is a pipe or a device, where W2W has a file: take it away")
    return Path(folder, name)


def is_plain(name: object) -> TypeGuard[str]:
    """Whether a name stays in its folder on every system."""
    return isinstance(name, str) and bool(PLAIN.fullmatch(name))


def checked(name: object, source: str) -> str:
    """A name that `source`, in words, gives; ForeignFileError if it does not stay in its folder."""
    if is_plain(name):
        return name
    raise ForeignFileError(
        f"{source} names {ascii(name)[:80]}, which leads out of the folder. W2W writes no such name: do not "
        "use this folder unless you know who made it"
    )


def file_name(name: str) -> str:
    """A name that a user or a file gave, such as a placement's, as part of a file's name."""
    return FORBIDDEN.sub("_", name.strip())
