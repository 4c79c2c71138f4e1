# SPDX-License-Identifier: GPL-3.0-or-later
"""A results folder as a zip, made while it is sent."""

import os
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

from ..core.study.clip_files import WORK
from .uploads import PIECE


class _Pieces(bytearray):
    """What a zip has written and nobody has sent yet."""

    def write(self, data: bytes) -> int:
        self += data
        return len(data)

    def flush(self) -> None:
        """Keep all for the reader."""


def zipped(folder: Path) -> Iterator[bytes]:
    """A results folder as a zip, in pieces as they are made.

    Without what belongs to a process at work, and without links: they may lead out of the folder.
    """
    pieces = _Pieces()
    with ZipFile(pieces, "w") as archive:  # type: ignore[call-overload]
        for path in sorted(_files(folder)):
            name = path.relative_to(folder).as_posix()
            if name.startswith((f"{WORK}/lock", f"{WORK}/holder", f"{WORK}/running")):
                continue
            with path.open("rb") as stream, archive.open(name, "w", force_zip64=True) as member:
                while piece := stream.read(PIECE):
                    member.write(piece)
                    yield bytes(pieces)
                    pieces.clear()
    yield bytes(pieces)


def _files(folder: Path) -> Iterator[Path]:
    for place, _, names in os.walk(folder):
        paths = (Path(place, name) for name in names)
        yield from (path for path in paths if path.is_file() and not path.is_symlink())
