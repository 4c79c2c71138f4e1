# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from anybody: which are taken, under which names they lie on disk, what is in them.

What opens a file's content (`unpack`, `judge`) runs in a worker process with limits of time and memory.
"""

import hashlib
import re
import stat
import unicodedata
from collections.abc import Callable, Iterable, Mapping
from errno import EDQUOT, ENOSPC
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Any
from zipfile import ZipFile, ZipInfo

import numpy as np

from ..core.body.body import BODY_HANDS, Body, posed_joints
from ..core.files import DAMAGED, atomic_write, most_unpacked, reserved
from ..core.given import is_plain
from ..core.library.library import LABELS, Clip
from ..core.motion.motion import Motion
from ..core.motion.source import reason_of
from ..core.motion.up import Unasked
from ..core.readers.asf_amc import ASF_SUFFIX
from ..core.reading.formats import MOTION_SUFFIXES, TABLES
from ..core.reading.guard import LIMIT_S, MEMORY, guarded
from ..core.reading.reader import bounded
from ..headless.blender import NoBlenderError
from ..headless.commands.inspect import too_short
from ..headless.runs.clip import load_clip
from ..headless.runs.clip_task import Engine

SUFFIXES = (*MOTION_SUFFIXES, *TABLES, ASF_SUFFIX)
"""Kinds of files that are taken: motions, tables of joints, labels and skeletons."""

MOST_FILES, MOST_NAME, MOST_FOLDERS = 2000, 240, 8
"""Files of a study, characters of a name, and folders in it."""

PIECE = 2**20

UNSAFE = re.compile(r"[^0-9A-Za-z ._@()+,&=#~!%'\[\]{}\u0080-\U0010ffff-]|^[. =+@-]|[. ]$")
"""What no part of a name on disk has: the rest means the same on every system and in every program."""

FRAMES = 32
"""Frames of a clip's small picture."""

MOST_BYTES = 200
"""Bytes of a part of a name on disk, which systems keep below 256 with what is added while it is written."""

DISK_FULL = (ENOSPC, EDQUOT)

NO_DISK = "the server's disk is full: delete studies, or tell whoever runs the server"

UNREADABLE = "it is no zip that can be read: damaged, locked, or packed in an unusual way"


class RefusedError(Exception):
    """A request that is refused, with the HTTP status and a sentence that says why."""

    def __init__(self, status: int, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


def refused(status: int) -> Callable[[str], RefusedError]:
    """What makes a sentence a request's refusal with an HTTP status."""
    return partial(RefusedError, status)


class Names:
    """The names on disk of a study's files, each given once.

    A name keeps its folders, which label clips, and all characters that are safe on every system, in NFC, so
    that a run makes the same of usual names as elsewhere.
    """

    def __init__(self, files: Mapping[str, str]) -> None:
        self._given: dict[str, str] = {}  # names as they were given, by those on disk in a form to compare
        self._own: dict[str, str] = {}
        self._folders: set[str] = set()
        for own, name in files.items():
            self._take(own, name)

    def own(self, name: str) -> str:
        """The name on disk of a file that a browser or a zip calls `name`; a RefusedError if it is no name.

        A file that comes again gets its name again.
        """
        if known := self._own.get(name):
            return known
        parts = [_safe(part) for part in checked_name(name).split("/")]
        for depth in range(1, len(parts)):
            while _form("/".join(parts[:depth])) in self._given:  # a file is called as the folder
                parts[depth - 1] += "_"
        own, number = "/".join(parts), 2
        path = PurePosixPath(own)
        while _form(own) in self._given or _form(own) in self._folders:
            own, number = str(path.with_name(f"{path.stem}_{number}{path.suffix}")), number + 1
        self._take(own, name)
        return own

    def _take(self, own: str, name: str) -> None:
        form = _form(own)
        self._given[form], self._own[name] = name, own
        self._folders |= {form[:at] for at, letter in enumerate(form) if letter == "/"}


def given_name(name: str) -> str:
    """A name as it was given, with each accented letter as one character."""
    return unicodedata.normalize("NFC", name)


def checked_name(name: str) -> str:
    """The name of a file that may be taken; a RefusedError says why it may not."""
    if not is_plain(name):
        raise RefusedError(400, f"{name[:80]!r} is no plain file name: it must not lead out of its folder")
    if len(name) > MOST_NAME or name.count("/") > MOST_FOLDERS:
        raise RefusedError(400, f"{name[:80]!r}… is too long a name, or in too many folders")
    if PurePosixPath(name).suffix.lower() not in SUFFIXES:
        raise RefusedError(400, f"{name!r} is no motion file, table or labels.csv")
    return name


def _form(own: str) -> str:
    """A name on disk as systems compare that do not tell capitals apart."""
    return unicodedata.normalize("NFC", own.casefold())


def _safe(part: str) -> str:
    """A part of a path as it may lie on any disk: no longer than MOST_BYTES, its ending kept."""
    text = "".join(
        "_" if unicodedata.category(letter)[0] in "CZ" and letter != " " else letter for letter in part
    )
    text = UNSAFE.sub("_", text)
    stem, dot, suffix = text.rpartition(".") if "." in text[-8:] else (text, "", "")
    while len(f"{stem}{dot}{suffix}".encode()) > MOST_BYTES:
        stem = stem[:-1]
    return f"_{text}" if reserved(text) else f"{stem}{dot}{suffix}"


def unpack(archive: Path, folder: Path, files: int, most: int) -> dict[str, Any] | str:
    """Unpack a zip's motion files into a folder, numbered; what was taken and refused, or why nothing was.

    Links, devices, paths out of the folder, locked files and bombs are refused before anything is written. At
    most so many `files` are taken, and `most` bytes. What is taken: the number, the name and the sum of each.
    """
    try:
        with guarded(), ZipFile(archive) as content:
            members = [member for member in content.infolist() if not member.is_dir()]
            _check(members, archive.stat().st_size, most)
            taken, refused = list[tuple[str, str, str]](), dict[str, str]()
            top = _top([member.filename for member in members])
            for member in members:
                name = given_name(member.filename.removeprefix(top))
                try:
                    checked_name(name)
                except RefusedError as refusal:
                    refused[name] = str(refusal)
                    continue
                if len(taken) >= files:
                    raise RefusedError(413, f"a study holds at most {MOST_FILES} files")
                with content.open(member) as stream:
                    total = store(folder / str(len(taken)), iter(lambda: stream.read(PIECE), b""))
                taken.append((str(len(taken)), name, total))
    except RefusedError as refusal:
        return str(refusal)
    except OSError as error:
        if error.errno in DISK_FULL:
            return NO_DISK
        return UNREADABLE
    except (ValueError, *DAMAGED):
        return UNREADABLE
    return {"files": taken, "refused": refused}


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


def store(path: Path, pieces: Iterable[bytes]) -> str:
    """Write a file, whole or not at all; returns its SHA-256."""
    path.parent.mkdir(parents=True, exist_ok=True)
    total = hashlib.sha256()
    with atomic_write(path) as stream:
        for piece in pieces:
            stream.write(piece)
            total.update(piece)
    return total.hexdigest()


def judge(path: Path, file: str, rate: float = 0.0) -> dict[str, Any]:
    """What a motion file holds, or the `problem` for which a run would skip it, as `w2w inspect` has it.

    A `rate` other than 0 goes before the file's own.
    """
    clip = Clip(path, file, "clip", "", rate=rate)
    try:
        source, motion, details = bounded(
            LIMIT_S, MEMORY, partial(load_clip, clip, Body.bundled(), Engine(ups=Unasked()))
        )
    except NoBlenderError:
        raise
    except Exception as error:
        return {"problem": reason_of(error)}
    if problem := too_short(details):
        return {"problem": problem}
    facts = {name: details[name] for name in ("duration_s", "frame_rate", "skeleton")}
    up = "" if source.up_guessed else getattr(source, "up", "")
    more = {"up": up, "cut": details.get("cut", "")}
    return facts | more | {"figure": figure(motion)}


def figure(motion: Motion) -> list[list[int]]:
    """A motion as a small picture shows it: places (x, y, z) of 22 joints in a few frames, in centimetres.

    The body stays where it is: its pelvis has no x and y.
    """
    frames = np.unique(np.linspace(0, motion.n_frames - 1, FRAMES).round().astype(int))
    rest = np.asarray(Body.bundled().joints)
    places = posed_joints(rest, motion.rotations[frames], motion.pelvis[frames])[1][:, : BODY_HANDS[0]]
    places[..., :2] -= places[:, :1, :2]
    return [frame.ravel().tolist() for frame in (100 * places).round().astype(int)]
