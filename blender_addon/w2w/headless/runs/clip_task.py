# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's task, as a worker gets it, and the mark of the worker that is at it."""

import hashlib
import json
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.files import file_sha256, stamp
from ...core.library.library import Clip
from ...core.reading.clips import How
from ...core.reading.formats import UP_SUFFIXES, Read, formats_of, read_beside
from ...core.reading.guard import LIMIT_S, MEMORY
from ...core.study.clip_files import WORK, features_file, motion_file, signals_file
from ...core.study.config import StudyConfig
from ...core.wording import name_bytes
from ...scene.motion.load import read_by_blender

Looks = list[str | list[int]]
"""What `look` returns."""

Record = dict[str, Any]
"""What became of a clip: its name, the reason why it was skipped, facts, hash and look of its file.

One that is kept has a key, too, and the hash, size and time of each file that was made of it.
"""


@dataclass(frozen=True, kw_only=True)
class Engine(How):
    """Settings of how clips are read and by which workers.

    `scheduler` is the address or file of a Dask scheduler, which brings its own workers; a clip may take
    `limit_s` seconds and `memory` bytes; `verify` reads all that an earlier run left again, and `signals`
    says whether they are kept.
    """

    workers: int = 1
    scheduler: str = ""
    limit_s: float = LIMIT_S
    memory: int = MEMORY
    blender: Read | None = read_by_blender
    verify: bool = False
    signals: bool = True

    @property
    def limits(self) -> tuple[float, int]:
        """Seconds and bytes, of which a clip that was given up may have more in a later run."""
        return self.limit_s, self.memory


@dataclass(frozen=True)
class ClipTask:
    """All that a worker needs to know about one clip.

    `inputs` is a hash of the body, the patches, the config and the version of what makes signals, `before`
    the clip's record by an earlier run, as it is in the list, and `library` the library's `digest_of_path`.
    """

    clip: Clip
    out: Path
    config: StudyConfig
    inputs: str
    engine: Engine = Engine()
    before: str = ""
    library: str = ""

    @property
    def motion_file(self) -> Path:
        return motion_file(self.out, self.clip.name)

    @property
    def signals_file(self) -> Path:
        return signals_file(self.out, self.clip.name)

    @property
    def features_file(self) -> Path:
        return features_file(self.out, self.clip.name)

    @property
    def marker(self) -> Path:
        """A file that exists while a worker is at work on the clip."""
        return self.out / WORK / "running" / self.clip.name

    def key(self, source_sha256: str) -> str:
        """Hash of everything that the result depends on."""
        parts = [self.inputs, source_sha256, self.clip.activity, self.clip.subject, self.clip.name]
        parts += [file_sha256(path) for path in read_beside(self.clip.path)]
        parts += [f"rate {self.clip.rate}"] if self.clip.rate else []
        if self.clip.path.suffix.lower() in UP_SUFFIXES:
            parts.append(repr(self.engine.ups))
        parts += [each.version for each in formats_of(self.clip.path) if each.version]
        if (rests := self.engine.rests.of_file(self.clip.file)).poses:
            parts.append(repr(rests))
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    def look(self) -> Looks:
        """The digest of the library's path and the `stamp` of each file that is read for the clip."""
        return look(self.library, self.clip.path)


def digest_of_path(folder: Path) -> str:
    """A digest of a folder's real path: results are passed on, and the path may hold names of people."""
    return hashlib.sha256(name_bytes(os.path.realpath(folder))).hexdigest()[:16]


def look(library: str, path: Path) -> Looks:
    """The digest of a library's path and the `stamp` of each file read for a clip, given by its path."""
    return [library, *map(stamp, (path, *read_beside(path)))]


def mark_read(task: ClipTask, seen: Record) -> None:
    """Note what is read for `record_death`, which must not read a file that killed a worker."""
    if task.marker.exists():
        with task.marker.open("a", encoding="ascii") as stream:
            stream.write(f"{seen['sha256']}\n{json.dumps(seen['looks'])}\n")


def marked_read(task: ClipTask) -> Record:
    """The hash of the clip's file, and its `look` before that; "" and [] if the worker died earlier."""
    seen: Record = {"sha256": "", "looks": []}
    with suppress(OSError, ValueError, RecursionError):
        first, second, *_ = [*task.marker.read_text(errors="replace").splitlines(), "", ""]
        seen["sha256"] = first if re.fullmatch("[0-9a-f]{64}", first) else ""
        seen["looks"] = json.loads(second)
    return seen
