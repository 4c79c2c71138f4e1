# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of each clip, kept in the work folder for later runs to resume from.

The run itself writes what its workers say into a list, one line a clip: a hundred thousand are read in a
second, and of a line that a kill cut in half no other suffers. A shard has a list of its own.
"""

import json
import os
import re
import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any

from ...core.files import UNFINISHED, file_sha256, stamp, write_text
from ...core.given import ForeignFileError, checked, inside, is_plain
from ...core.library.library import Clip, Library
from ...core.reading.reader import Death
from ...core.study.clip_files import WORK, mark_changing, motion_file, signals_file
from ...core.study.results import ClipResult
from .clip_task import ClipTask, Engine, Record
from .own_files import Hashes, remove_own

LIST = "records"
"""Name of the list's file; a shard's name follows it."""

CLIP = re.compile(r'\{"clip": "((?:[^"\\]|\\.)*)"')
"""The beginning of a line of the list, whose rest may be damaged."""

SYNC = 256
"""Records after which they are waited for until the disk has them."""

UNSEEN = "unseen"
"""The key of a record whose file killed or outlasted its reader at the first look."""


class Records(Mapping[str, Record]):
    """The newest record of each clip, as text until it is asked for; only the name of a damaged one."""

    def __init__(self, texts: dict[str, str], out: Path) -> None:
        self._texts, self._out = texts, out

    def __getitem__(self, clip: str) -> Record:
        return _decoded(self._texts[clip], clip)

    def __iter__(self) -> Iterator[str]:
        return iter(self._texts)

    def __len__(self) -> int:
        return len(self._texts)

    def names(self, clip: str, file: str) -> bool:
        """Whether a motion or signals, by its path in the folder, is the clip's by its record."""
        text = self._texts.get(clip, "")
        return f'"{file}"' in text or (
            clip in self._texts and file in given_names(self._out, clip, self[clip])
        )

    def text(self, clip: str) -> str:
        """The clip's line in the list, or ""."""
        return self._texts.get(clip, "")


def unfinished(path: Path) -> Path:
    """The temporary path of a motion or recording until the clip's record names it."""
    return path.with_name(f".{path.name}{UNFINISHED}")


def record_of(
    task: ClipTask,
    seen: Record,
    reason: str = "",
    made: tuple[Mapping[str, Any], tuple[Path, ...]] = ({}, ()),
    **more: object,
) -> Record:
    """What became of a clip, with the hash of each of its files.

    `seen` are the hash of its file and how it looked before it was read, `made` the facts and the files.
    """
    details, files = made
    nameless = {path: new if (new := unfinished(path)).exists() else path for path in files}
    names = {path.relative_to(task.out).as_posix(): new for path, new in nameless.items()}
    return {
        **not_kept(task, reason),
        "details": details,
        "source": seen,
        "key": task.key(seen["sha256"]),
        "files": {name: file_sha256(path) for name, path in names.items()},
        "made": {name: size_and_time(path) for name, path in names.items()},
        **more,
    }


def not_kept(task: ClipTask, reason: str) -> Record:
    """What became of a clip that the next run tries again: no list has it."""
    unseen = {"sha256": "", "looks": []}
    return {"clip": task.clip.name, "reason": reason, "details": {}, "source": unseen}


def result_of(clip: Clip, record: Record) -> ClipResult:
    """The result of a clip, from its record."""
    return ClipResult(clip, record["reason"], record["details"], record["source"]["sha256"])


@contextmanager
def keeping(out: Path, before: Mapping[str, Record], shard: str = "") -> Iterator[Callable[[Record], None]]:
    """A function that lists a clip's record and names its files: a run is the one writer of its list.

    `before` are the records that it found. The record goes first and the files get their names after it, so
    that a process killed at any point never leaves a file without a record; `finished` renames those that
    were not reached.
    """
    with _list_file(out, shard).open("a", encoding="utf-8") as stream:
        numbers = count(1)

        def keep(record: Record) -> None:
            if "key" not in record:
                return
            clip, names = record["clip"], record["files"]
            others = given_names(out, clip, before[clip]) if clip in before else {}
            if others := {name: hashes for name, hashes in others.items() if name not in names}:
                mark_changing(out)
                remove_own(out, others)
            stream.write(f"\n{json.dumps({'clip': clip, 'at': time.time_ns(), **record})}")
            stream.flush()
            for name in names:
                with suppress(FileNotFoundError):  # it has its name
                    unfinished(out / name).replace(out / name)
            if next(numbers) % SYNC == 0:
                os.fsync(stream.fileno())

        try:
            yield keep
        finally:
            forget_read()
            os.fsync(stream.fileno())


def size_and_time(path: Path | str) -> list[int]:
    """Bytes of a file of ours and when it was written (ns), which renames and moves keep."""
    found = os.lstat(path)  # no file of ours is a link
    return [found.st_size, found.st_mtime_ns]


def lists_in(out: Path) -> list[Path]:
    """The list of the folder's records, and those of its shards."""
    return [inside(out, f"{WORK}/{path.name}") for path in sorted((out / WORK).glob(f"{LIST}*.jsonl"))]


def read_records(out: Path) -> Records:
    """The newest record of each clip; of a damaged one only the clip's name."""
    lists = ((path, path.stat()) for path in lists_in(out))
    found = dict(_listed(tuple((path, stat.st_size, stat.st_mtime_ns) for path, stat in lists)))
    return Records(found, out)


@lru_cache(maxsize=1)  # a run checks its folder before it holds it, and reads it again once it does
def _listed(lists: tuple[tuple[Path, int, int], ...]) -> dict[str, str]:
    """The newest line of each clip in lists of such sizes and times."""
    found: dict[str, str] = {}
    for path, *_ in lists:
        lines = {}
        with path.open(encoding="utf-8", errors="replace") as stream:
            for number, line in enumerate(stream, start=1):
                if name := CLIP.match(line):  # a kill may have cut it short before the clip's name
                    clip = checked(name[1], f"{path}, line {number},")
                    lines[clip] = line.rstrip("\n")  # the last is the newest, whatever the clock said
        for clip, line in lines.items():
            if clip not in found or _decoded(line, clip)["at"] >= _decoded(found[clip], clip)["at"]:
                found[clip] = line
    return found


def forget_read() -> None:
    """Clear the cache of lists."""
    _listed.cache_clear()


def _decoded(line: str, clip: str) -> Record:
    try:
        record = json.loads(line)
        if record["clip"] == clip and isinstance(record["at"], int):
            return record
    except (ValueError, KeyError, TypeError, RecursionError):
        pass
    return {"clip": clip, "at": 0}


def tidy(out: Path, without: Collection[str] = ()) -> Records:
    """The records of a folder that no other run works in, less some clips', in one list from now on."""
    records = read_records(out)
    kept = {clip: records.text(clip) for clip in records if clip not in without}
    lists = set(lists_in(out))
    if len(kept) < len(records) or lists != {_list_file(out)}:
        write_text(_list_file(out), "".join(f"\n{text}" for text in kept.values()))
        for path in lists - {_list_file(out)}:
            path.unlink()
    return Records(kept, out)


def _list_file(out: Path, shard: str = "") -> Path:
    return out / WORK / ".".join(filter(None, (LIST, shard, "jsonl")))


def given_names(out: Path, clip: str, record: Record) -> Hashes:
    """Hashes of the motion and signals that a record names; what it says of other files is ignored."""
    names = [file(out, clip).relative_to(out).as_posix() for file in (motion_file, signals_file)]
    if not isinstance(files := record.get("files"), Mapping):
        return {name: set() for name in names}  # the record is damaged, but ours
    _check_names(out, clip, record)
    return {name: {str(files[name])} for name in names if name in files}


def untouched(task: ClipTask) -> Record | None:
    """The record of an earlier run, if the clip and what was made of it look exactly as recorded.

    Neither is read.
    """

    def as_made(record: Record, name: str) -> bool:
        return record["made"][name] == size_and_time(f"{task.out}/{name}")

    return _known(task, lambda source: source["looks"] == task.look() and task.key(source["sha256"]), as_made)


def finished(task: ClipTask, key: str, seen: Record) -> Record | None:
    """The record of an earlier run, if its inputs are the same and its files whole, and how all looks now."""

    def whole(record: Record, name: str) -> bool:
        return _is_whole(inside(task.out, name), record["files"][name])

    if record := _known(task, lambda _: key, whole):
        made = {name: size_and_time(task.out / name) for name in record["files"]}
        return record | {"source": seen, "made": made}
    return None


def _known(
    task: ClipTask, key_of: Callable[[Record], Any], whole: Callable[[Record, str], bool]
) -> Record | None:
    """The record of an earlier run, if it has the key of its source now, and its files are `whole`."""
    if not task.before:
        return None
    try:
        record = _decoded(task.before, task.clip.name)
        files = _check_names(task.out, task.clip.name, record)
        if _had_less(record, task.engine) or record["key"] != key_of(record["source"]):
            return None
        if isinstance(record["reason"], str) and isinstance(record["details"], dict):
            return record if all(whole(record, name) for name in files) else None
    except ForeignFileError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        pass
    return None


def _had_less(record: Record, engine: Engine) -> bool:
    """Whether a clip was given up within narrower limits than a run has now."""
    had = record.get("limits", engine.limits)
    return any(less < now for less, now in zip(had, engine.limits, strict=True))


def given_up_in(out: Path, library: Library, engine: Engine) -> dict[Path, Death]:
    """Files that killed or outlasted who looked at them first in an earlier run, by their content."""
    records, found = read_records(out), {}
    for clip in library.clips:
        if UNSEEN in records.text(clip.name):
            with suppress(OSError, ValueError, KeyError, TypeError):
                record, looked = records[clip.name], stamp(clip.path)
                same = record["source"]["sha256"] == file_sha256(clip.path)
                if same and record[UNSEEN] and not _had_less(record, engine):
                    found[clip.path] = Death(str(record["reason"]), looked)
    return found


def _check_names(out: Path, clip: str, record: Record) -> Collection[str]:
    """The names of the files in a clip's record; a ForeignFileError if one leads out of the folder."""
    for name in record["files"]:
        if not is_plain(name):
            checked(name, _place_of(out, clip))
    return record["files"]


def _place_of(out: Path, clip: str) -> str:
    """The place of a clip's record, in words."""
    found = str(out / WORK)
    for path in lists_in(out):
        with path.open(encoding="utf-8", errors="replace") as stream:
            for number, line in enumerate(stream, start=1):
                if (begun := CLIP.match(line)) and begun[1] == clip:
                    found = f"{path}, line {number},"
    return found


def _is_whole(path: Path, sha256: str) -> bool:
    """Whether a file is as its record says; one that a kill left without its name gets it now."""
    nameless = unfinished(path)
    if nameless.exists() and file_sha256(nameless) == sha256:
        nameless.replace(path)
    return file_sha256(path) == sha256
