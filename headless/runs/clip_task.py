# SPDX-License-Identifier: GPL-3.0-or-later
"""A clip's task, as a worker gets it, and what is on disk about it: its record and a worker's mark."""

from __future__ import annotations

import hashlib
import json
import os
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from w2w.core.clip_files import WORK, features_file, motion_file, signals_file
from w2w.core.files import UNFINISHED, file_sha256, write_json
from w2w.core.keypoints.facts import PoseFacts, side_car
from w2w.core.keypoints.pose_files import NO_FACTS
from w2w.core.motion.asf_amc import AMC_SUFFIX, skeleton_file
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.library import Clip, is_joint_file
from w2w.core.motion.source import UnusableMotion
from w2w.core.results_folder import ClipResult
from w2w.core.study import StudyConfig

from .guard import LIMIT_S, MEMORY
from .own_files import remove_own


@dataclass(frozen=True)
class Engine:
    """Who does the clips, and how they are read.

    `scheduler` is the address or file of a Dask scheduler, which brings its own workers; a clip may take
    `limit_s` seconds and `memory` bytes; `bone_maps` are the user's own, tried before the bundled ones;
    `verify` reads all that an earlier run left again.
    """

    workers: int = 1
    scheduler: str = ""
    limit_s: float = LIMIT_S
    bone_maps: tuple[BoneMap, ...] = ()
    memory: int = MEMORY
    pose: PoseFacts = NO_FACTS
    verify: bool = False


@dataclass(frozen=True)
class ClipTask:
    """All that a worker needs to know about one clip.

    `inputs` is a hash of the body, the patches, the config and the code that the result depends on.
    """

    clip: Clip
    out: Path
    config: StudyConfig
    inputs: str
    engine: Engine = Engine()

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
    def record_file(self) -> Path:
        """The record of the work: written before the files get their names."""
        return record_file(self.out, self.clip.name)

    @property
    def marker(self) -> Path:
        """A file that exists while a worker is at work on the clip."""
        return self.out / WORK / "running" / self.clip.name

    def key(self, source_sha256: str) -> str:
        """Hash of everything that the result depends on."""
        parts = [self.inputs, source_sha256, self.clip.activity, self.clip.subject, self.clip.name]
        parts += [file_sha256(path) for path in _read_beside(self.clip.path)]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def _read_beside(path: Path) -> list[Path]:
    """Files that say what the clip's own does not: its skeleton, or its rate and joints."""
    if path.suffix.lower() == AMC_SUFFIX:
        try:
            return [skeleton_file(path)]
        except UnusableMotion:
            return []
    beside = side_car(path) if is_joint_file(path) else None
    return [] if beside is None else [beside]


def record_file(out: Path, clip: str) -> Path:
    return out / WORK / "clips" / f"{clip}.json"


def unfinished(path: Path) -> Path:
    """Where a motion or recording is until the clip's record names it."""
    return path.with_name(f".{path.name}{UNFINISHED}")


def recorded(out: Path, clip: str) -> dict[str, str]:
    """Hashes of a clip's motion and signals in its record, which is believed about no other file."""
    names = [path.relative_to(out).as_posix() for path in (motion_file(out, clip), signals_file(out, clip))]
    try:
        files = json.loads(record_file(out, clip).read_text(encoding="utf-8"))["files"]
        return {name: str(files[name]) for name in names if name in files}
    except FileNotFoundError:
        return {}
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return dict.fromkeys(names, "")  # the record is damaged, but ours


def write_record(task: ClipTask, result: ClipResult, files: tuple[Path, ...]) -> None:
    """Record what became of a clip and the hash of each of its files.

    The record goes first and the files get their names after it, so that a kill at any moment
    leaves no file of ours that no record names; `finished` names them where it did not come to it.
    """
    names = {}
    for path in files:
        nameless = unfinished(path)
        names[path.relative_to(task.out).as_posix()] = nameless if nameless.exists() else path
    if not files:
        remove_own(task.out, recorded(task.out, task.clip.name))
    content = {
        "key": task.key(result.source_sha256),
        "reason": result.reason,
        "details": result.details,
        "files": {name: file_sha256(path) for name, path in names.items()},
        "source": {"sha256": result.source_sha256, "bytes": source_size(task.clip.path)},
        "bytes": {name: path.stat().st_size for name, path in names.items()},
    }
    write_json(task.record_file, content)
    for name, path in names.items():
        path.replace(task.out / name)


def mark_source(task: ClipTask, source: str) -> None:
    """Note the hash for `record_death`, which must not read a file that killed a worker."""
    if task.marker.exists():
        with task.marker.open("a", encoding="ascii") as stream:
            stream.write(f"{source}\n")


def marked_source(task: ClipTask) -> str:
    """The hash of the clip's file; empty where the worker died before it was known."""
    try:
        first = task.marker.read_text(errors="replace").partition("\n")[0]
    except OSError:
        return ""
    return first if re.fullmatch("[0-9a-f]{64}", first) else ""


def source_size(path: Path) -> int | None:
    """Bytes of a clip's file; None where it is gone."""
    return path.stat().st_size if path.exists() else None


def stamp(path: Path) -> tuple[int, ...]:
    """What changes with a clip's file or the link to it: its size, and times that nobody can set back."""
    try:
        found, link = path.stat(), path.lstat()
    except OSError:
        return ()
    return found.st_size, found.st_mtime_ns, found.st_ctime_ns, link.st_mtime_ns, link.st_ctime_ns


def distrust(task: ClipTask) -> None:
    """Let no later run believe the clip's record by times alone: its file changed while it was read."""
    with suppress(OSError):
        os.utime(task.record_file, (0, 0))


def untouched(task: ClipTask) -> tuple[dict[str, Any], str] | None:
    """The record of an earlier run and its source's hash, if sizes and times say that all is as it was.

    Neither the clip's file nor what was made of it is read: nothing was written after the record, as `make`
    tells, and sizes are the record's.
    """
    try:
        done, at = json.loads(task.record_file.read_text("utf-8")), task.record_file.stat().st_mtime_ns
        source, sizes = done["source"], done["bytes"]
        size, *times = stamp(task.clip.path)
        if size != source["bytes"] or max(times) > at or done["key"] != task.key(source["sha256"]):
            return None
        for name in done["files"]:
            made = (task.out / name).stat()
            if made.st_size != sizes[name] or made.st_mtime_ns > at:
                return None
        if isinstance(done["reason"], str) and isinstance(done["details"], dict):
            return done, source["sha256"]
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        pass
    return None


def finished(task: ClipTask, key: str) -> dict[str, Any] | None:
    """The record of an earlier run, if its inputs are the same and its files are whole."""
    try:
        done = json.loads(task.record_file.read_text(encoding="utf-8"))
        if done["key"] != key or not isinstance(done["reason"], str) or not isinstance(done["details"], dict):
            return None
        whole = all(_is_whole(task.out / name, value) for name, value in done["files"].items())
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return done if whole else None


def _is_whole(path: Path, sha256: str) -> bool:
    """Whether a file is as its record says; one that a kill left without its name gets it now."""
    nameless = unfinished(path)
    if nameless.exists() and file_sha256(nameless) == sha256:
        nameless.replace(path)
    return file_sha256(path) == sha256
