# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from anybody: which are taken, under which names they lie on disk, what is in them.

What opens a file's content (`unpack`, `judge`) runs in a worker process with limits of time and memory.
"""

import re
import stat
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath
from typing import Any
from zipfile import ZipFile, ZipInfo

from ..core.body.body import Body
from ..core.files import DAMAGED, atomic_write, most_unpacked, reserved
from ..core.inside import is_plain
from ..core.keypoints.pose_files import NO_FACTS
from ..core.library.library import LABELS, MOTION_SUFFIXES, TEXT_SUFFIXES, Clip
from ..core.motion.up import BY_ITSELF, UPSIDE_DOWN
from ..core.readers.asf_amc import ASF_SUFFIX
from ..headless.commands.inspect import too_short
from ..headless.runs.guard import guarded
from ..headless.runs.workers import load_guarded

SUFFIXES = (*MOTION_SUFFIXES, *TEXT_SUFFIXES, ASF_SUFFIX)
"""Kinds of files that are taken: motions, tables of joints, labels and skeletons."""

MOST_FILES, MOST_NAME, MOST_FOLDERS = 2000, 240, 8
"""Files of a study, characters of a name, and folders in it."""

PIECE = 2**20

UNSAFE = re.compile(r"[^0-9A-Za-z ._@()+,&=#~-]|^[. ]|[. ]$")
"""What no part of a name on disk has: the rest means the same on every system and in every program."""


class RefusedError(Exception):
    """A request that is refused, with the HTTP status and a sentence that says why."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


def own_name(name: str, files: Mapping[str, str]) -> str:
    """The name on disk for a file that a browser or a zip calls `name`; a RefusedError if it is none.

    It has the name's folders, which label clips, and of its characters those that are safe, so that usual
    names stay as they are and a run makes the same of them as elsewhere. `files` are names on disk, each with
    the original: one that is uploaded again gets its name again.
    """
    if not is_plain(name):
        raise RefusedError(400, f"{name[:80]!r} is no plain file name: it must not lead out of its folder")
    if len(name) > MOST_NAME or name.count("/") > MOST_FOLDERS:
        raise RefusedError(400, f"{name[:80]!r}… is too long a name, or in too many folders")
    if PurePosixPath(name).suffix.lower() not in SUFFIXES:
        raise RefusedError(400, f"{name!r} is no motion file, table or labels.csv")
    parts = [UNSAFE.sub("_", part) for part in name.split("/")]
    own = "/".join(f"_{part}" if reserved(part) else part for part in parts)
    path, taken = PurePosixPath(own), {file.lower(): original for file, original in files.items()}
    number = 2
    while taken.get(own.lower(), name) != name:
        own, number = str(path.with_name(f"{path.stem}_{number}{path.suffix}")), number + 1
    return own


def unpack(archive: Path, folder: Path, files: Mapping[str, str], most: int) -> dict[str, Any] | str:
    """Unpack a zip's motion files into a folder; what was taken and refused, or why nothing was.

    Links, devices, paths out of the folder, locked files and bombs are refused before anything is written.
    """
    try:
        with guarded(), ZipFile(archive) as content:
            members = [member for member in content.infolist() if not member.is_dir()]
            _check(members, archive.stat().st_size, most)
            taken, refused = dict(files), {}
            top = _top([member.filename for member in members])
            for member in members:
                name = member.filename.removeprefix(top)
                try:
                    own = own_name(name, taken)
                except RefusedError as refusal:
                    refused[name] = str(refusal)
                    continue
                if len(taken) >= MOST_FILES:
                    raise RefusedError(413, f"a study holds at most {MOST_FILES} files")
                with content.open(member) as stream:
                    store(folder / own, iter(lambda: stream.read(PIECE), b""))
                taken[own] = name
    except RefusedError as refusal:
        return str(refusal)
    except (ValueError, OSError, *DAMAGED):
        return "it is no zip that can be read: damaged, locked, or packed in an unusual way"
    return {"files": {own: name for own, name in taken.items() if own not in files}, "refused": refused}


def _top(names: list[str]) -> str:
    """The folder above all others in a zip, with a slash, or "": it names the library, not an activity."""
    tops = {name.partition("/")[0] for name in names}
    is_library = any(name.count("/") > 1 or name.endswith(f"/{LABELS}") for name in names)
    return f"{tops.pop()}/" if len(tops) == 1 and is_library else ""


def _check(members: list[ZipInfo], size: int, most: int) -> None:
    """Refuse a zip by what it says of its members."""
    if len(members) > MOST_FILES:
        raise RefusedError(413, f"it holds {len(members)} files, and a study at most {MOST_FILES}")
    for member in members:
        if not is_plain(member.filename):
            raise RefusedError(400, f"it names {member.filename[:80]!r}, which leads out of its folder")
        kind = stat.S_IFMT(member.external_attr >> 16)
        if kind not in (0, stat.S_IFREG):
            raise RefusedError(400, f"{member.filename[:80]!r} is a link or a device: zip the file itself")
    unpacked = sum(member.file_size for member in members)
    if unpacked > min(most, most_unpacked(size)):
        raise RefusedError(413, f"it would unpack to {unpacked / 1e6:.0f} MB, more than is allowed here")


def store(path: Path, pieces: Iterable[bytes]) -> None:
    """Write a file, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic_write(path) as stream:
        for piece in pieces:
            stream.write(piece)


def judge(path: Path, file: str, rate: float = 0.0) -> dict[str, Any]:
    """What a motion file holds, or the `problem` for which a run would skip it, as `w2w inspect` has it.

    A `rate` other than 0 goes before the file's own.
    """
    found = load_guarded(Clip(path, file, "clip", "", rate=rate), Body.bundled(), (), NO_FACTS, BY_ITSELF)
    if isinstance(found, str):
        return {"problem": found}
    source, _, details = found
    if problem := too_short(details) or (UPSIDE_DOWN if "head_down" in details else ""):
        return {"problem": problem}
    facts = {name: details[name] for name in ("duration_s", "frame_rate", "skeleton")}
    return facts | {"up": getattr(source, "up", ""), "cut": details.get("cut", "")}
