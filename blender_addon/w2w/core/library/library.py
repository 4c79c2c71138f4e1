# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of motion files: which clips it holds and what each shows."""

import hashlib
import os
import posixpath
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import chain, count
from pathlib import Path, PurePosixPath

from ..files import reserved
from ..readers.animations import contents, telling_part
from ..reading.clips import Clip as Clip
from ..reading.formats import FAULTS, MOTION_SUFFIXES, TABLES, WAYS, is_motion
from ..wording import clean, composed, count as count_of, join_words, name_bytes, restated
from .labels import NO_LABELS, LabelCheck, LibraryError, label_rows, spelled_once

LABELS = "labels.csv"
"""The file in a library that labels it, if there is one."""

WORK_FOLDER = ".w2w"
RESULTS = (WORK_FOLDER, "motions", "signals", "heatmaps", "export", "utility.npz")
"""Files that a run writes into its output folder, which may lie in the library."""


@dataclass(frozen=True)
class Library:
    """The clips of a folder and where their labels come from."""

    folder: Path
    clips: tuple[Clip, ...]  # in the order of their paths
    labelled_by: str  # where the labels come from, in words
    skipped: tuple[tuple[str, str], ...] = ()  # files left out, each with the reason
    check: LabelCheck = NO_LABELS  # what stood out in the labels
    unread: tuple[tuple[str, int], ...] = ()  # suffixes of files that are not read, and how many

    @property
    def activities(self) -> dict[str, int]:
        """Number of clips by activity, in alphabetical order."""
        return dict(sorted(Counter(clip.activity for clip in self.clips).items()))


def not_read_sentence(unread: Sequence[tuple[str, int]]) -> str:
    """How many files are of kinds that are not read, by their suffix, and what to do; "" if none is."""
    if not unread:
        return ""
    kinds = join_words([f"{number} {suffix}" for suffix, number in unread])
    ways = dict.fromkeys(WAYS[suffix] for suffix, _ in unread if suffix in WAYS)
    files = count_of("file", sum(number for _, number in unread))
    return "; ".join([f"{files} of kinds that are not read: {kinds}", *ways, *FAULTS])


def read_library(
    folder: str | Path, labels: str | Path | None = None, exact_labels: bool = False, own_labels: bool = True
) -> Library:
    """Find the motion files of a folder and all folders below it, and label them.

    A label comes from `labels` if given, else from `LABELS` in the folder (unless `own_labels` is False),
    else from the clip's folder inside the library, else from its file name (``Walking (2).fbx``,
    ``X Bot@Waving.fbx``); each animation of a file with several is labelled by its own name. `labels` is a
    csv with columns ``file`` and ``activity``, and if wanted ``subject``, ``source``, ``motion_key`` and
    ``rate``; ``file`` is the path inside the library, or any unambiguous trailing part, such as the bare
    name. With columns ``caption`` and ``activity`` it labels clips by words of their captions.
    `exact_labels` keeps activities apart that differ only in case, spaces, underscores or hyphens.

    Raises LibraryError if the folder is missing or holds no motion files, or the csv cannot be understood.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise LibraryError(f"{folder} is not a folder: give the folder that holds your motion files")
    motions, others = _motion_files(folder)
    inside, unread = sorted(motions, key=name_bytes), tuple(others.most_common())
    if not inside:
        kinds = ", ".join(MOTION_SUFFIXES)
        there = not_read_sentence(unread)
        raise LibraryError(
            f"{folder} holds no motion files ({kinds}, or csv or json of joint positions), nor do the "
            f"folders in it{there and f'; {there}'}"
        )
    root = folder.absolute()  # not resolved: a link keeps its name, which says its kind
    folders = {file.rpartition("/")[0] for file in inside}
    above = {name: root / name for name in folders}  # a path is made faster from its folder's
    files = [above[place] / name for place, _, name in (file.rpartition("/") for file in inside)]
    found = contents(zip(files, inside, strict=True))
    names = unique_names(item.file for item in found)
    inside = [clean(item.file) for item in found]
    packs = {clean(item.file): clean(item.pack) for item in found if item.pack}
    reasons: dict[str, str] = {}
    where = ""
    if labels is None and own_labels and (folder / LABELS).is_file():
        labels, where = folder / LABELS, " in the library"
    if labels is None:
        telling = zip(inside, (telling_part(clean(item.animation)) for item in found), strict=True)
        named = {file: {"activity": text} for file, own in telling if (text := own or _telling(file))}
        rows, check = spelled_once(named, exact_labels, as_label)
        reasons = dict.fromkeys(inside, "neither its folder nor its name says what it shows")
        alone = [file for file in inside if file not in packs]
        check = replace(check, note=_people(alone))
        sources = {"folder names" if "/" in file else "file names" for file in alone}
        sources |= {"names of animations"} if packs else set()
        labelled_by = join_words(sorted(sources, reverse=True))
    else:
        labels = Path(labels)
        labelled_by = f"the file {clean(labels.name)}{where}"
        nameable = [*inside, *dict.fromkeys(packs.values())]
        hint = ". As it lies in the library, it labels it: rename it, or give others" if where else ""
        with restated(lambda error: f"{error}{hint}", LibraryError, LibraryError):
            rows, reasons, check = label_rows(labels, folder, nameable, exact_labels)
        rows |= {file: rows[pack] for file, pack in packs.items() if file not in rows and pack in rows}
        missing = tuple(file for file in check.not_listed if file in inside and file not in rows)
        check = replace(check, not_listed=missing)
    clips = [
        Clip(item.path, file, name, **rows[file], animation=item.animation)
        for item, file, name in zip(found, inside, names, strict=True)
        if file in rows
    ]
    skipped = [(file, reasons[file]) for file in inside if file not in rows]
    return Library(folder, tuple(clips), labelled_by, tuple(skipped), check, unread)


def activity_of(file: str) -> str:
    """Label of a clip from its folder inside the library, else from its file name.

    Examples
    --------
    >>> activity_of("walking/clip 7.fbx")
    'walking'
    >>> activity_of("X Bot@Waving (2).fbx")
    'waving'
    """
    return as_label(_telling(file))


def _telling(file: str) -> str:
    """The name of a folder or file that labels a clip, without a number in brackets; "" if there is none.

    A folder's name may be a number alone, because somebody put clips in it.
    """
    above, _, name = file.rpartition("/")
    if folder := above.rpartition("/")[2].strip():
        return _unnumbered(folder) or folder
    parts = reversed(PurePosixPath(name).stem.split("@"))
    return next(filter(None, map(_unnumbered, parts)), "")


def _people(files: Sequence[str]) -> str:
    """A note on folders that hold clips of the same names, as those of people do; "" if most names differ."""
    split = (file.rpartition("/") for file in files)
    named = {(re.sub(r"[\s_.-]*\d+$", "", activity_of(name)) or name, above) for above, _, name in split}
    uses = Counter(name for name, _ in named)
    shared = sorted(name for name in uses if uses[name] > 1)
    if len(shared) < 2 or 2 * len(shared) <= len(uses):
        return ""
    people = (
        "if folders or names are people, say so by a labels.csv with the columns file, activity and subject"
    )
    return f"folders hold clips of the same names, {join_words(shared)}: {people}"


@lru_cache
def _unnumbered(text: str) -> str:
    return re.sub(r"\s*\(\d+\)\s*$", "", text).strip()


@lru_cache
def as_label(text: str) -> str:
    """A label from the name of a folder, a file or an action.

    Examples
    --------
    >>> as_label("Sit To-Stand (3)")
    'sit_to_stand'
    """
    text = composed(_unnumbered(text) or text.strip()).lower()
    return re.sub(r"[\s_\-]+", "_", text).strip("_") or text


def unique_names(files: Iterable[str]) -> list[str]:
    """Names for files, given by their different paths inside a library, that are safe on every file system.

    They differ even where case does not count.
    """
    files = list(files)
    plain = [re.sub(r"[^0-9A-Za-z]+", "_", posixpath.splitext(file)[0]).strip("_")[:80] for file in files]
    uses = Counter(name.lower() for name in plain)
    as_they_are = [name and uses[name.lower()] == 1 and not reserved(name) for name in plain]
    taken = {name.lower() for name, kept in zip(plain, as_they_are, strict=True) if kept}
    names = []
    for name, kept, file in zip(plain, as_they_are, files, strict=True):
        names.append(name if kept else _hashed(name, file, taken))
        taken.add(names[-1].lower())
    return names


def _hashed(stem: str, file: str, taken: set[str]) -> str:
    """A name with a hash of the file's path, longer as long as another file is called so."""
    digest = hashlib.sha256(name_bytes(file)).hexdigest()
    ends = chain((digest[:length] for length in range(8, 65, 8)), (f"{digest}_{n}" for n in count(2)))
    return next(name for end in ends if (name := f"{stem}_{end}".strip("_")).lower() not in taken)


def _motion_files(folder: Path) -> tuple[list[str], Counter[str]]:
    """Paths in a folder of all that it and its subfolders, but hidden ones, name as motions, except results.

    Pipes and links that lead nowhere are included: reading one gives the reason to skip it. The others are
    counted by suffix, unless they are hidden, have none, or are text, which may say anything.
    """
    motions: list[str] = []
    others: Counter[str] = Counter()
    for place, folders, files in os.walk(folder):
        if WORK_FOLDER in folders:
            folders[:] = [name for name in folders if name not in RESULTS]
            files = [name for name in files if name not in RESULTS]
        folders[:] = [name for name in folders if not name.startswith(".")]
        inside = Path(place).relative_to(folder).as_posix()
        inside = "" if inside == "." else f"{inside}/"
        for name in files:  # most are recognised by their suffix, without a path for each
            suffix = posixpath.splitext(name)[1].lower()
            if suffix in MOTION_SUFFIXES or is_motion(Path(place, name)):
                motions.append(f"{inside}{name}")
            elif suffix and suffix not in TABLES and not name.startswith("."):
                others[clean(suffix)] += 1
    return motions, others
