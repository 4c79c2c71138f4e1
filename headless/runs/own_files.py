# SPDX-License-Identifier: GPL-3.0-or-later
"""The rule for everything that W2W writes: it replaces and removes its own files, and nobody else's.

What was made of a clip stands in the clip's record, every other file in `written.sha256`, as
`sha256sum` writes it. A name is claimed there before anything is written under it, so that a run
that was killed in between goes on. A file is W2W's where its name is listed and its hash is the same.
Everything is checked before anything is made.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path, PurePosixPath
from tempfile import mkdtemp
from typing import Any

from w2w.core.clip_files import WORK
from w2w.core.file_names import shown
from w2w.core.files import UNFINISHED, file_sha256, write_text

LIST = "written.sha256"
UNKNOWN = "0" * 64
"""Stands for the hash of a file that is claimed and perhaps not written yet."""

CLIP_FOLDERS = ("motions", "signals", WORK)
"""Where the files of a clip's record may lie; a record that says otherwise is not believed."""

MAX_NAMED = 3
"""Names of foreign files that a sentence gives."""


class ForeignFileError(ValueError):
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


def new_file(path: Path | None, *others: Path | None) -> None:
    """Refuse a single file to be written where anything stands already, or where no folder is for it.

    Parameters
    ----------
    path : Path or None
        None where none is asked for.
    *others : Path or None
        Further files that the same command writes.

    Raises
    ------
    ForeignFileError, ValueError
    """
    paths = [one for one in (path, *others) if one is not None]
    for one in paths:
        if os.path.lexists(one):
            raise ForeignFileError(
                f"{shown(one)} is already there, and will not be overwritten: move it, or give another name"
            )
        if not one.parent.is_dir():
            raise ValueError(f"{shown(one)} cannot be written: there is no folder {shown(one.parent)}")
    if len(set(paths)) < len(paths):
        raise ValueError(f"{shown(paths[0])} cannot be two files at once: give each a name of its own")


def check(folder: Path, names: Iterable[str]) -> None:
    """Refuse a folder in which something that W2W did not write is in the way; changes nothing.

    Parameters
    ----------
    folder : Path
        The folder to write into; it need not exist.
    names : iterable of str
        Paths inside it that are going to be written, with forward slashes.

    Raises
    ------
    ForeignFileError
    """
    there = next(place for place in (folder, *folder.absolute().parents) if os.path.lexists(place))
    if not there.is_dir():
        raise ForeignFileError(f"{shown(there)} is not a folder: give another one")
    written = _read(folder)
    found = (_in_the_way(folder, name, written) for name in (f"{WORK}/{LIST}", *names))
    _refuse(folder, [name for name in dict.fromkeys(found) if name])


def claim(folder: Path, names: Iterable[str]) -> None:
    """Take names for files that are about to be written.

    Raises
    ------
    ForeignFileError
        As `check`; nothing has been touched then.
    """
    names = list(names)
    check(folder, names)
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    _write(folder, _read(folder) | dict.fromkeys(names, ""))


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


@contextmanager
def claimed(folder: Path, names: Iterable[str]) -> Iterator[None]:
    """Claim names for the files that the block writes, and note them at its end.

    Raises
    ------
    ForeignFileError
        As `check`; nothing has been touched then.
    """
    names = list(names)
    claim(folder, names)
    try:
        yield
    finally:
        with suppress(OSError):  # a full disk: what is claimed stays ours
            note(folder, names)


def check_whole(folder: Path, inputs: Iterable[Path | None] = ()) -> None:
    """Refuse a folder in which anything lies that W2W did not write, or somebody changed since.

    Parameters
    ----------
    folder : Path
    inputs : iterable of Path or None
        What is read; such files may lie in it.

    Raises
    ------
    ForeignFileError
    """
    check(folder, ())
    theirs = {path.resolve() for path in inputs if path is not None}
    written = _read(folder)
    names = [name for name in _files_in(folder) if (folder / name).resolve() not in theirs]
    _refuse(folder, [name for name in names if not _is_ours(folder, name, written)])


@contextmanager
def published(folder: Path, inputs: Iterable[Path | None] = ()) -> Iterator[Path]:
    """A folder to fill, whose files take the place of those that W2W wrote into `folder` before.

    Where the block fails, everything stays as it was.

    Parameters
    ----------
    folder : Path
        New, empty, or with nothing in it but what W2W wrote there.
    inputs : iterable of Path or None
        As `check_whole`.

    Raises
    ------
    ForeignFileError
        As `check_whole`.
    """
    check_whole(folder, inputs)
    beside = next(place for place in folder.absolute().parents if place.is_dir())
    temporary = Path(mkdtemp(dir=beside, prefix=f".{folder.name[:40]}.", suffix=UNFINISHED))
    try:
        yield temporary
        names = _files_in(temporary)
        claim(folder, names)
        for name in names:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (temporary / name).replace(folder / name)
        remove_written(folder, lambda name: name not in names)
        note(folder)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def remove_written(folder: Path, which: Callable[[str], bool]) -> None:
    """Remove those listed files of a folder that are still as W2W wrote them, and give up their names."""
    written = _read(folder)
    stale = {name: value for name, value in written.items() if which(name)}
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
    for name in files:
        path = folder / name
        if path.is_file() and _is_ours(folder, name, files):
            path.unlink()


def files_of_record(record: Path) -> dict[str, str]:
    """Hash of each file that a clip's record names; nothing where there is no record to be believed."""
    content = json_content(record)
    files = content.get("files") if isinstance(content, dict) else None
    return files if _is_hashes(files) and all(_is_clips(name) for name in files) else {}


def json_content(path: Path) -> Any:
    """What a JSON file holds; None where it cannot be read."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return None


def _refuse(folder: Path, foreign: list[str]) -> None:
    """Say which files are in the way, if any."""
    if not foreign:
        return
    more = f" and {len(foreign) - MAX_NAMED} more" if len(foreign) > MAX_NAMED else ""
    raise ForeignFileError(
        f"{shown(folder)} already holds {', '.join(map(shown, foreign[:MAX_NAMED]))}{more}, which W2W did "
        "not write and will not overwrite: move it away, or give another folder"
    )


def _in_the_way(folder: Path, name: str, written: Mapping[str, str]) -> str:
    """What is in a file's way: a foreign file, or a link or file for a folder; else empty."""
    for parent in reversed(PurePosixPath(name).parents[:-1]):
        place = folder / parent
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            return parent.as_posix()
    return "" if name == f"{WORK}/{LIST}" or _is_ours(folder, name, written) else name


def _is_ours(folder: Path, name: str, written: Mapping[str, str]) -> bool:
    """Whether nothing stands there, or the very file that W2W wrote, or claimed and may have written."""
    path = folder / name
    if not os.path.lexists(path):
        return True
    if name not in written or path.is_symlink() or not path.is_file():
        return False
    return written[name] in ("", file_sha256(path))


def _files_in(folder: Path) -> list[str]:
    """All that is in a folder but its work folder; links count as files."""
    found = []
    for place, folders, files in os.walk(folder):
        inside = Path(place)
        if inside == folder:
            folders[:] = [name for name in folders if name != WORK or (folder / WORK).is_symlink()]
        links = [name for name in folders if (inside / name).is_symlink()]
        found += [(inside / name).relative_to(folder).as_posix() for name in (*files, *links)]
    return sorted(found)


def _is_clips(name: str) -> bool:
    path = PurePosixPath(name)
    return ".." not in path.parts and path.parts[:1] in [(folder,) for folder in CLIP_FOLDERS]


def _is_hashes(content: Any) -> bool:
    return isinstance(content, dict) and all(isinstance(value, str) for value in content.values())


def _read(folder: Path) -> dict[str, str]:
    """The hash of every file that is ours, empty where it is claimed and perhaps not written yet."""
    try:
        lines = (folder / WORK / LIST).read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return {}
    written = {name: sha256 for sha256, _, name in (line.partition("  ") for line in lines) if name}
    return {name: "" if sha256 == UNKNOWN else sha256 for name, sha256 in written.items()}


def _write(folder: Path, written: Mapping[str, str]) -> None:
    lines = [f"{sha256 or UNKNOWN}  {name}\n" for name, sha256 in sorted(written.items())]
    write_text(folder / WORK / LIST, "".join(lines))
