# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files of a results folder W2W wrote: it replaces and removes those, and nobody else's.

What was made of a clip stands in the clip's record, every other result in `written.sha256`, as
`sha256sum` writes it. A name is claimed there before anything is written under it, so that a run
that was killed in between goes on. A file is replaced where its name is ours, and removed where
its hash is ours too.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any

from w2w.core.clip_files import WORK
from w2w.core.files import file_sha256, write_text

from .picture_names import HEATMAPS, picture_files

LIST = "written.sha256"
UNKNOWN = "0" * 64
"""Stands for the hash of a file that is claimed and perhaps not written yet."""

EARLIER = ("config.json", "summary.json", "utility.csv", "utility.npz", "report.html", "study.blend")
EARLIER_SWEEP = ("sweep.csv", "places.csv", "sweep.png")
"""What versions wrote that kept no list."""

CLIP_FOLDERS = ("motions", "signals", WORK)
"""Where the files of a clip's record may lie; a record that says otherwise is not believed."""

MAX_NAMED = 3
"""Names of foreign files that a sentence gives."""


class ForeignFileError(Exception):
    """A file that W2W did not write stands where it must write; the message says which."""


def keep_apart(library: Path, out: Path) -> None:
    """Refuse a results folder that is the library, or holds it; links do not hide that.

    Raises
    ------
    ValueError
        With a sentence for people.
    """
    if not (library.is_dir() and out.exists()):
        return
    inside = library.resolve()
    if inside.samefile(out):
        raise ValueError(
            f"--out is the library itself, {library}: give the results a folder of their own, so that "
            "nothing of yours lies among them"
        )
    if any(parent.samefile(out) for parent in inside.parents):
        raise ValueError(
            f"--out {out} holds the library {library}: give the results a folder of their own, beside the "
            "library or in it"
        )


def claim(folder: Path, names: Iterable[str], later: Iterable[str] = ()) -> None:
    """Take names for files that are about to be written.

    Parameters
    ----------
    folder : Path
        The results folder; its work folder must exist.
    names : iterable of str
        Paths inside it, with forward slashes.
    later : iterable of str
        Names to be claimed later: only looked at.

    Raises
    ------
    ForeignFileError
        If a file stands at one of them that W2W did not write; nothing has been touched then.
    """
    names = list(names)
    written = _read(folder)
    refuse(folder, [name for name in (*names, *later) if name not in written and _stands(folder, name)])
    _write(folder, written | dict.fromkeys(names, ""))


def note(folder: Path, names: Iterable[str] | None = None) -> None:
    """Keep the hashes of claimed files, and give up names under which nothing was written.

    Parameters
    ----------
    folder : Path
    names : iterable of str, optional
        All that have been claimed and not noted, by default.
    """
    written = _read(folder)
    for name in [name for name, value in written.items() if not value] if names is None else names:
        if (folder / name).is_file():
            written[name] = file_sha256(folder / name)
        else:
            written.pop(name, None)
    _write(folder, written)


def remove_claimed(folder: Path, inside: str) -> None:
    """Remove what earlier runs wrote into a folder of the results, and give up the names there."""
    written = _read(folder)
    stale = {name: value for name, value in written.items() if name.startswith(f"{inside}/") and value}
    remove_own(folder, stale)
    _write(folder, {name: value for name, value in written.items() if name not in stale})


def remove_own(folder: Path, files: Mapping[str, str]) -> None:
    """Remove files that are still what W2W wrote; whatever else stands there stays.

    Parameters
    ----------
    folder : Path
    files : mapping of str to str
        Hash of each path inside it.
    """
    for name, sha256 in files.items():
        path = folder / name
        if path.is_file() and file_sha256(path) == sha256:
            path.unlink()


def files_of_record(record: Path) -> dict[str, str]:
    """Hash of each file that a clip's record names; nothing where there is no record to be believed."""
    content = json_content(record)
    files = content.get("files") if isinstance(content, dict) else None
    return files if _is_hashes(files) and all(_is_clips(name) for name in files) else {}


def refuse(folder: Path, foreign: list[str]) -> None:
    """Say which files stand in the way, if any.

    Raises
    ------
    ForeignFileError
    """
    if not foreign:
        return
    more = f" and {len(foreign) - MAX_NAMED} more" if len(foreign) > MAX_NAMED else ""
    raise ForeignFileError(
        f"{folder} already holds {', '.join(foreign[:MAX_NAMED])}{more}, which W2W did not write and will "
        "not overwrite: move it away, or give another folder"
    )


def json_content(path: Path) -> Any:
    """What a JSON file holds; None where it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _is_clips(name: str) -> bool:
    path = PurePosixPath(name)
    return ".." not in path.parts and path.parts[:1] in [(folder,) for folder in CLIP_FOLDERS]


def _is_hashes(content: Any) -> bool:
    return isinstance(content, dict) and all(isinstance(value, str) for value in content.values())


def _stands(folder: Path, name: str) -> bool:
    return os.path.lexists(folder / name)


def _read(folder: Path) -> dict[str, str]:
    """The hash of every file that is ours, empty where it is claimed and perhaps not written yet."""
    try:
        lines = (folder / WORK / LIST).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return {name: "" for name in _of_earlier_version(folder) if _stands(folder, name)}
    written = {name: sha256 for sha256, _, name in (line.partition("  ") for line in lines) if name}
    return {name: "" if sha256 == UNKNOWN else sha256 for name, sha256 in written.items()}


def _of_earlier_version(folder: Path) -> list[str]:
    """Names that a version that kept no list wrote into the folder, known by what stands in it."""
    if not (folder / WORK / "patches.npz").is_file():
        return []
    if any((folder / WORK).glob("map_*.npz")):
        return [*EARLIER_SWEEP]
    names = []
    for marker in (folder / WORK / "running").glob("*"):  # killed before it could record them
        names += [f"motions/{marker.name}.npz", f"signals/{marker.name}.npz"]
    summary, config = json_content(folder / "summary.json"), json_content(folder / "config.json")
    if isinstance(config, dict) and {"parameters", "versions", "code_sha256"} <= config.keys():
        names += EARLIER
    elif isinstance(summary, dict) and {"problem", "labelled_by"} <= summary.keys():
        names += ["summary.json"]
    if isinstance(summary, dict) and isinstance(summary.get("activities"), dict):
        tested = sorted(set(summary["activities"]) - set(summary.get("left_out", ())))
        names += [f"{HEATMAPS}/{name}" for name in picture_files(tested)]
    return names


def _write(folder: Path, written: Mapping[str, str]) -> None:
    lines = [f"{sha256 or UNKNOWN}  {name}\n" for name, sha256 in sorted(written.items())]
    write_text(folder / WORK / LIST, "".join(lines))
