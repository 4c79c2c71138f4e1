# SPDX-License-Identifier: GPL-3.0-or-later
"""What is on disk about the work on a clip: the record of what was made, and the mark of a worker at it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from w2w.core.clip_files import motion_file, signals_file
from w2w.core.files import file_sha256, write_json
from w2w.core.findings.finished_study import ClipResult

from .clip_task import ClipTask, record_file, unfinished
from .own_files import remove_own


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
    names = {path.relative_to(task.out).as_posix(): _standing(path) for path in files}
    if not files:
        remove_own(task.out, recorded(task.out, task.clip.name))
    content = {
        "key": task.key(result.source_sha256),
        "reason": result.reason,
        "details": result.details,
        "files": {name: file_sha256(path) for name, path in names.items()},
    }
    write_json(task.record_file, content)
    for name, path in names.items():
        path.replace(task.out / name)


def _standing(path: Path) -> Path:
    """Where a file of a clip is until it is recorded."""
    return unfinished(path) if unfinished(path).exists() else path


def mark_source(task: ClipTask, source: str) -> None:
    """Note the hash for `record_death`, which must not read a file that killed a worker."""
    if task.marker.exists():
        with task.marker.open("a", encoding="ascii") as stream:
            stream.write(f"{source}\n")


def marked_source(task: ClipTask) -> str:
    """The hash of the clip's file; empty where the worker did not come so far."""
    try:
        first = task.marker.read_text(errors="replace").partition("\n")[0]
    except OSError:
        return ""
    return first if re.fullmatch("[0-9a-f]{64}", first) else ""


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
