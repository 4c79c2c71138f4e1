# SPDX-License-Identifier: GPL-3.0-or-later
"""The result of each clip, kept in the work folder for later runs to resume from.

A worker writes a clip's record as a file of its own, which no kill can cut in half. The run gathers them
into a list, one line a clip: a hundred thousand are read in a second. A shard has a list of its own.
"""

import json
import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

from ...core.files import UNFINISHED, file_sha256, stamp, write_json, write_text
from ...core.inside import ForeignFileError, checked, inside, is_plain
from ...core.library.library import Library
from ...core.reading.reader import Death
from ...core.study.clip_files import WORK, mark_changing, motion_file, signals_file
from ...core.study.results import ClipResult
from .clip_task import ClipTask, Engine, Looks
from .own_files import Hashes, remove_own

Record = dict[str, Any]

LIST = "records"
"""Name of the list's file; a shard's name follows it."""

CLIP = re.compile(r'\{"clip": "((?:[^"\\]|\\.)*)"')
"""The beginning of a line of the list, whose rest may be damaged."""

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


def write_record(
    task: ClipTask, result: ClipResult, looks: Looks, files: tuple[Path, ...], more: Record
) -> None:
    """Record what became of a clip, the hash of each of its files, and how it looked before it was read.

    If it looks different now, nobody knows what was read: such a record fits no file. The record goes
    first and the files get their names after it, so that a process killed at any point never leaves a file
    without a record; `finished` renames those that were not reached.
    """
    mark_changing(task.out)
    names = {}
    for path in files:
        nameless = unfinished(path)
        names[path.relative_to(task.out).as_posix()] = nameless if nameless.exists() else path
    if before := last_record(task):
        others = given_names(task.out, task.clip.name, before)
        remove_own(task.out, {name: hashes for name, hashes in others.items() if name not in names})
    key = task.key(result.source_sha256)
    changed = bool(looks) and task.look() != looks
    content = {
        "key": "" if changed else key,
        "reason": result.reason,
        "details": result.details,
        "files": {name: file_sha256(path) for name, path in names.items()},
        "source": {"sha256": result.source_sha256, "looks": [] if changed else looks},
        "made": {name: _size_and_time(path) for name, path in names.items()},
    }
    write_json(task.record_file, content | more)
    for name, path in names.items():
        path.replace(task.out / name)


def refresh(task: ClipTask, record: Record, looks: Looks) -> None:
    """Record how a clip and its files look that are as they were by their hashes."""
    new = {
        "source": record["source"] | {"looks": looks},
        "made": {name: _size_and_time(task.out / name) for name in record["files"]},
    }
    if task.look() == looks and not new.items() <= record.items():
        whose = {"clip", "at"}
        write_json(task.record_file, {name: record[name] for name in record if name not in whose} | new)


def _size_and_time(path: Path | str) -> list[int]:
    """Bytes of a file of ours and when it was written (ns), which renames and moves keep."""
    found = os.lstat(path)  # no file of ours is a link
    return [found.st_size, found.st_mtime_ns]


def last_record(task: ClipTask) -> Record | None:
    """The clip's newest record: a file of its own, or as the run found it in the list."""
    own = _own_record(task.record_file)
    return _decoded(task.before, task.clip.name) if own is None and task.before else own


def _own_record(path: Path) -> Record | None:
    """The record in a clip's own file and when it was written; no more than the name if it is damaged."""
    try:
        return {"clip": path.stem, "at": path.stat().st_mtime_ns, **json.loads(path.read_text("utf-8"))}
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError, RecursionError):
        return {"clip": path.stem, "at": 0}


def has_records(out: Path) -> bool:
    """Whether any run wrote a record here."""
    return bool(lists_in(out)) or any((out / WORK / "clips").glob("*.json"))


def lists_in(out: Path) -> list[Path]:
    """The list of the folder's records, and those of its shards."""
    return [inside(out, f"{WORK}/{path.name}") for path in sorted((out / WORK).glob(f"{LIST}*.jsonl"))]


def read_records(out: Path) -> Records:
    """The newest record of each clip; of a damaged one only the clip's name."""
    lists = ((path, path.stat()) for path in lists_in(out))
    found = dict(_listed(tuple((path, stat.st_size, stat.st_mtime_ns) for path, stat in lists)))
    for own in (out / WORK / "clips").glob("*.json"):
        path = inside(out, f"{WORK}/clips/{own.name}")
        if record := _own_record(path):
            found[path.stem] = json.dumps(record)
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


def gather(out: Path, clips: Iterable[str], shard: str = "") -> None:
    """Move clips' records from their own files into the list."""
    paths = [out / WORK / "clips" / f"{clip}.json" for clip in clips]
    found = {path: record for path in paths if (record := _own_record(path))}
    with _list_file(out, shard).open("a", encoding="utf-8") as stream:
        stream.write("".join(f"\n{json.dumps(record)}" for record in found.values()))
        stream.flush()
        os.fsync(stream.fileno())
    for path in found:
        path.unlink()


def tidy(out: Path, without: Collection[str] = ()) -> Records:
    """The records of a folder that no other run works in, less some clips', in one list from now on."""
    records = read_records(out)
    kept = {clip: records.text(clip) for clip in records if clip not in without}
    lists = set(lists_in(out))
    own = list((out / WORK / "clips").glob("*.json"))
    if own or len(kept) < len(records) or lists != {_list_file(out)}:
        write_text(_list_file(out), "".join(f"\n{text}" for text in kept.values()))
        for path in (*own, *(lists - {_list_file(out)})):
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


def untouched(task: ClipTask, record: Record | None) -> ClipResult | None:
    """The result in a record of an earlier run, if the clip and what was made of it look exactly as recorded.

    Neither is read.
    """
    if record is None:
        return None
    try:
        files = _check_names(task.out, task.clip.name, record)
        source, made = record["source"], record["made"]
        if _had_less(record, task.engine):
            return None
        if source["looks"] != task.look() or record["key"] != task.key(source["sha256"]):
            return None
        if any(made[name] != _size_and_time(f"{task.out}/{name}") for name in files):
            return None
        if isinstance(record["reason"], str) and isinstance(record["details"], dict):
            return ClipResult(task.clip, record["reason"], record["details"], source["sha256"])
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
    found = str(out / WORK / "clips" / f"{clip}.json")
    for path in lists_in(out):
        with path.open(encoding="utf-8", errors="replace") as stream:
            for number, line in enumerate(stream, start=1):
                if (begun := CLIP.match(line)) and begun[1] == clip:
                    found = f"{path}, line {number},"
    return found


def finished(task: ClipTask, key: str) -> Record | None:
    """The record of an earlier run, if its inputs are the same and its files are whole."""
    if (done := last_record(task)) is None:
        return None
    try:
        if done["key"] != key or _had_less(done, task.engine):
            return None
        if not isinstance(done["reason"], str) or not isinstance(done["details"], dict):
            return None
        _check_names(task.out, task.clip.name, done)
        whole = all(_is_whole(inside(task.out, name), value) for name, value in done["files"].items())
    except ForeignFileError:
        raise
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return done if whole else None


def _is_whole(path: Path, sha256: str) -> bool:
    """Whether a file is as its record says; one that a kill left without its name gets it now."""
    nameless = unfinished(path)
    if nameless.exists() and file_sha256(nameless) == sha256:
        nameless.replace(path)
    return file_sha256(path) == sha256
