# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that a folder's own files give, resolved inside the folder: none leads out of it."""

import os
import re
import stat
from pathlib import Path
from typing import TypeGuard

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
