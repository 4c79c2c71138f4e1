# SPDX-License-Identifier: GPL-3.0-or-later
"""The rule for everything that W2W writes: it replaces and removes its own files, and nobody else's.

A file is W2W's where it is listed with its hash: files of a clip in the clip's record, all others in
`written.sha256`, as `sha256sum` writes it. The hash is listed before the file gets its name, next to that of
the file before it, so that a run that was killed in between can go on, and a list that somebody else made
gives away no file whose content he does not know. Everything is checked before anything is made.

A file that is written on the list, and the list, are on the disk before they have their names: after a power
cut the old or the new is there. A clip's files are not waited for, which could take as long as its work.
"""

import os
import shutil
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path, PurePosixPath
from tempfile import mkdtemp

from ...core.files import UNFINISHED, atomic_write, file_sha256, told_of_writes
from ...core.given import ForeignFileError, checked, inside
from ...core.study.clip_files import WORK
from ...core.wording import clean, join_words as listed_words

LIST = f"{WORK}/written.sha256"

Hashes = dict[str, set[str]]
"""Hashes that a file of W2W's may have, by its path in the folder."""

UNLINKED = (WORK, f"{WORK}/running")
"""Folders in which files are written in place, not renamed: no link may lie there."""


def keep_apart(library: Path, out: Path) -> None:
    """Raise a ValueError if the results folder is the library, or holds it; links do not hide that."""
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
            f"--out {out} holds the library {library}: give the results a folder of their own, next to the "
            "library or in it"
        )


def new_file(*paths: Path | None) -> None:
    """Raise a ValueError if one of these files exists already, or has no folder."""
    given = [path for path in paths if path is not None]
    for path in given:
        if os.path.lexists(path):
            raise ForeignFileError(
                f"{clean(path)} is already there, and will not be overwritten: move it, or give another name"
            )
        if not path.parent.is_dir():
            raise ValueError(f"{clean(path)} cannot be written: there is no folder {clean(path.parent)}")
    if len(set(given)) < len(given):
        raise ValueError(f"{clean(given[0])} cannot be two files at once: give each a name of its own")


def check(folder: Path, names: Iterable[str]) -> None:
    """Raise a ForeignFileError if something that W2W did not write is in the way; changes nothing.

    The names are paths inside the folder, which need not exist, with forward slashes.
    """
    there = next(place for place in (folder, *folder.absolute().parents) if os.path.lexists(place))
    if not there.is_dir():
        raise ForeignFileError(f"{clean(there)} is not a folder: give another one")
    _refuse(folder, [name for place in UNLINKED for name in links_in(folder, place)], {})
    written = _read(folder)
    found = dict.fromkeys(_in_the_way(folder, name, written) for name in (LIST, *names))
    _refuse(folder, [name for name in found if name], written)


def claimed(folder: Path, names: Iterable[str]) -> AbstractContextManager[None]:
    """`check` names, and list the files that the block writes under them."""
    check(folder, names := list(names))
    return list_written(folder, names)


@contextmanager
def list_written(folder: Path, names: Collection[str]) -> Iterator[None]:
    """List the files that the block writes under these names, with their hashes."""
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    places = {folder / name: name for name in names}

    def tell(temporary: Path, path: Path) -> None:
        if path in places:
            _to_disk(temporary)
            _write(folder, _either(_read(folder), {places[path]: {file_sha256(temporary)}}))

    try:
        with told_of_writes(tell):
            yield
    finally:
        with suppress(OSError):  # a full disk: what was listed stays ours
            others = {name: hashes for name, hashes in _read(folder).items() if name not in names}
            there = [name for name in names if (folder / name).is_file()]
            _write(folder, others | {name: {file_sha256(folder / name)} for name in there})


def _to_disk(path: Path) -> None:
    with path.open("r+b") as stream:
        os.fsync(stream.fileno())


def _either(before: Hashes, after: Hashes) -> Hashes:
    """The hashes of both lists: while a file is replaced, either version may be there."""
    return {name: before.get(name, set()) | after.get(name, set()) for name in before | after}


@contextmanager
def published(folder: Path, inputs: Iterable[Path | None] = ()) -> Iterator[Path]:
    """A folder to fill, whose files replace those that W2W wrote into `folder` before.

    The folder passes `check_whole`. Where the block fails, everything stays as it was.
    """
    check_whole(folder, inputs)
    beside = next(place for place in folder.absolute().parents if place.is_dir())
    temporary = Path(mkdtemp(dir=beside, prefix=f".{folder.name[:40]}.", suffix=UNFINISHED))
    try:
        yield temporary
        names = move_in(folder, temporary)
        remove_written(folder, lambda name: name not in names)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)


def move_in(folder: Path, temporary: Path) -> list[str]:
    """Give all files of a temporary folder their names in a folder, after `check`; returns the names."""
    check(folder, names := _files_in(temporary))
    (folder / WORK).mkdir(parents=True, exist_ok=True)
    before, made = _read(folder), {name: {file_sha256(temporary / name)} for name in names}
    _write(folder, _either(before, made))
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (temporary / name).replace(folder / name)
    _write(folder, before | made)
    return names


def check_whole(folder: Path, inputs: Iterable[Path | None] = ()) -> None:
    """Raise a ForeignFileError if a folder holds anything but `inputs` and unchanged files of W2W's."""
    check(folder, ())
    theirs = {path.resolve() for path in inputs if path is not None}
    written = _read(folder)
    names = [name for name in _files_in(folder) if (folder / name).resolve() not in theirs]
    _refuse(folder, [name for name in names if not _is_ours(folder, name, written)], written)


def remove_written(folder: Path, which: Callable[[str], bool]) -> None:
    """Take files of a folder off its list, and remove those that are still as W2W wrote them."""
    written = _read(folder)
    stale = {name: value for name, value in written.items() if which(name)}
    remove_own(folder, stale)
    _write(folder, {name: value for name, value in written.items() if name not in stale})


def remove_own(folder: Path, hashes: Hashes) -> None:
    """Remove files, given by their paths in a folder, that still have one of their hashes; others stay."""
    for name in hashes:
        path = inside(folder, name)
        if path.is_file() and _is_ours(folder, name, hashes):
            path.unlink()


def is_whole(folder: Path) -> bool:
    """Whether all files on a folder's list are there as they were written."""
    files = ((inside(folder, name), hashes) for name, hashes in _read(folder).items())
    return all(path.is_file() and {file_sha256(path)} == hashes for path, hashes in files)


def _refuse(folder: Path, foreign: list[str], written: Hashes) -> None:
    """Name the files that are in the way, if any, and say what to do."""
    if not foreign:
        return
    holds = f"{clean(folder)} already holds {listed_words([*map(clean, foreign)])}, which"
    if written.keys() >= {*foreign}:
        raise ForeignFileError(
            f"{holds} changed after W2W wrote it and will not be overwritten: move it away if the change is "
            "yours, delete it if it is damaged, and run the same command again"
        )
    lost = f"; if a run made it and its list in {WORK} is lost or damaged, delete it"
    raise ForeignFileError(
        f"{holds} W2W did not write and will not overwrite: move it away, or give another folder"
        + (lost if (folder / WORK).is_dir() else "")
    )


def links_in(folder: Path, place: str) -> list[str]:
    """Links in a folder, or the folder itself if it is one, by their paths."""
    if (folder / place).is_symlink():
        return [place]
    if not (folder / place).is_dir():
        return []
    with os.scandir(folder / place) as entries:
        return sorted(f"{place}/{entry.name}" for entry in entries if entry.is_symlink())


def _in_the_way(folder: Path, name: str, written: Hashes) -> str:
    """Name of the foreign file in a file's way, or of the link or file in place of a folder."""
    for parent in reversed(PurePosixPath(name).parents[:-1]):
        place = folder / parent
        if place.is_symlink() or (place.exists() and not place.is_dir()):
            return parent.as_posix()
    return "" if name == LIST or _is_ours(folder, name, written) else name


def _is_ours(folder: Path, name: str, written: Hashes) -> bool:
    """Whether there is nothing, or the very file that W2W wrote."""
    path = folder / name
    if not os.path.lexists(path):
        return True
    if name not in written or path.is_symlink() or not path.is_file():
        return False
    return file_sha256(path) in written[name]


def _files_in(folder: Path) -> list[str]:
    """All that is in a folder outside its work folder; links count as files."""
    found = []
    for place, folders, files in os.walk(folder):
        inside = Path(place)
        if inside == folder:
            folders[:] = [name for name in folders if name != WORK or (folder / WORK).is_symlink()]
        links = [name for name in folders if (inside / name).is_symlink()]
        found += [(inside / name).relative_to(folder).as_posix() for name in (*files, *links)]
    return sorted(found)


def _read(folder: Path) -> Hashes:
    """The listed hashes of each of our files; a ForeignFileError if a name leads elsewhere."""
    path, found = inside(folder, LIST), Hashes()
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, ValueError):
        return found
    for number, line in enumerate(lines, start=1):
        sha256, gap, name = line.partition("  ")
        if gap:
            found.setdefault(checked(name, f"{path}, line {number},"), set()).add(sha256)
    return found


def _write(folder: Path, written: Hashes) -> None:
    lines = [f"{sha256}  {name}\n" for name, hashes in sorted(written.items()) for sha256 in sorted(hashes)]
    with atomic_write(folder / LIST) as stream:
        stream.write("".join(lines).encode("utf-8", "backslashreplace"))
        stream.flush()
        os.fsync(stream.fileno())
