# SPDX-License-Identifier: GPL-3.0-or-later
"""Plan an import: the files to take, their labels, and the files to leave out, each with the reason."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from ..readers.animations import contents, telling_part
from ..reading.formats import MOTION_SUFFIXES, is_motion
from ..wording import clean, count, join_words
from .labels import NO_LABELS, LabelCheck, LibraryError, read_labels
from .library import LABELS, Clip, activity_of, as_label, not_read_sentence, read_library, unique_names

AUTOMATIC, BY_FOLDER, BY_FILE, BY_CSV = "AUTOMATIC", "FOLDER", "FILE", "CSV"
"""Sources of labels; automatic is the folder's labels.csv, else folders in it, else file names."""


LABELLED, UNLABELLED, LEFT_OUT = "labelled", "unlabelled", "left out"
"""What a row of a preview is about."""

FEW = 3
"""Single files from which on names that all differ are no labels: the folder's name is one."""


@dataclass(frozen=True)
class ImportPlan:
    """The clips that an import would take, and the files that it would not."""

    clips: tuple[Clip, ...]  # clips it would take; one without an activity is taken, too, and not ranked
    left_out: tuple[tuple[str, str], ...] = ()  # files that it would leave out, each with the reason
    known: tuple[str, ...] = ()  # files that were taken before, which it would not take again
    check: LabelCheck = NO_LABELS  # what stood out in a csv
    unread: str = ""  # how many files are of kinds that are not read, in a sentence

    @property
    def activities(self) -> dict[str, list[str]]:
        """Files by activity in alphabetical order; those without one come last, under the empty name."""
        return by_activity((clip.activity, clip.file) for clip in self.clips)


def by_activity(clips: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Names of clips, given with their activities, by these; see `ImportPlan.activities`."""
    names_of: dict[str, list[str]] = {}
    for activity, name in sorted(clips, key=lambda clip: (not clip[0], clip[0])):
        names_of.setdefault(activity, []).append(name)
    return names_of


def plan_folder(folder: Path, by: str = AUTOMATIC, csv: Path | None = None) -> ImportPlan:
    """Plan the import of all motion files in a folder and the folders in it.

    `by` is what labels the clips; by folder, files that lie in no folder of it take its own name. `csv` has
    the labels, for `BY_CSV`; by default it is `LABELS` in the folder.

    Raises LibraryError if there are no files, or the csv is missing or cannot be understood.
    """
    labels = csv or folder / LABELS if by == BY_CSV else None
    library = read_library(folder, labels, own_labels=by == AUTOMATIC)
    clips: Sequence[Clip] = library.clips
    if by in (BY_FOLDER, BY_FILE):
        clips = [replace(clip, activity=_label(clip.path, by, clip.animation)) for clip in clips]
    check = NO_LABELS if by in (BY_FOLDER, BY_FILE) else library.check
    return replace(_plan(clips, library.skipped, check), unread=not_read_sentence(library.unread))


def plan_files(paths: Iterable[Path], by: str = AUTOMATIC, csv: Path | None = None) -> ImportPlan:
    """Plan the import of single files, by their names if some are alike; see `plan_folder`.

    Raises LibraryError if none of them is a motion file, or the csv is missing or cannot be understood.
    """
    paths = list(paths)
    motions = [path for path in paths if is_motion(path)]
    if not motions:
        raise LibraryError(f"choose motion files ({', '.join(MOTION_SUFFIXES)})")
    reason = "it is no kind of motion file that can be read"
    left_out = [(clean(path.name), reason) for path in paths if path not in motions]
    found = contents((path, path.name) for path in motions)
    files, names = [clean(item.file) for item in found], unique_names(item.file for item in found)
    if by == BY_CSV:
        labels = csv or motions[0].parent / LABELS
        rows, check = read_labels(labels, motions[0].parent, files)
        missing = f"{clean(labels.name)} gives it no activity"
        left_out += [(file, missing) for file in files if file not in rows]
    else:
        labels_of = [_label(item.path, by, item.animation) for item in found]
        is_told = len(set(labels_of)) < len(labels_of) or any(item.animation for item in found)
        if by == AUTOMATIC and not is_told and len(found) >= FEW:
            labels_of = [_label(item.path, BY_FOLDER, "") for item in found]
        rows = {file: {"activity": label} for file, label in zip(files, labels_of, strict=True)}
        check = NO_LABELS
    clips = [
        Clip(item.path, file, name, **rows[file], animation=item.animation)
        for item, file, name in zip(found, files, names, strict=True)
        if file in rows
    ]
    return _plan(clips, left_out, check)


def without_known(plan: ImportPlan, known: Iterable[Path]) -> ImportPlan:
    """A plan less the files that were taken before, be it under another name."""
    taken = taken_before((clip.path for clip in plan.clips), known)
    new = tuple(clip for clip in plan.clips if clip.path not in taken)
    return replace(plan, clips=new, known=tuple(clip.file for clip in plan.clips if clip.path in taken))


def taken_before(paths: Iterable[Path], known: Iterable[Path]) -> set[Path]:
    """Those of some files that are, or are a copy of, one that is known."""
    whole, taken = {path: path.absolute() for path in paths}, {path.absolute() for path in known}
    first = same_files([*taken, *whole.values()])
    return {path for path, found in whole.items() if {found, first.get(found)} & taken}


def same_files(paths: Sequence[Path]) -> dict[Path, Path]:
    """Files that are, byte for byte, one that comes before them, and which that is."""
    by_size: dict[int, list[Path]] = {}
    for path in dict.fromkeys(paths):
        if path.is_file() and (size := path.stat().st_size):
            by_size.setdefault(size, []).append(path)
    copies: dict[Path, Path] = {}
    for same_size in by_size.values():
        first: dict[bytes, Path] = {}
        for path in same_size if len(same_size) > 1 else ():
            with suppress(OSError):  # its import says why it cannot be read
                with path.open("rb") as stream:
                    digest = hashlib.file_digest(stream, "sha256").digest()
                if first.setdefault(digest, path) != path:
                    copies[path] = first[digest]
    return copies


def preview(
    activities: Mapping[str, Sequence[str]], left_out: Sequence[tuple[str, str]]
) -> tuple[str, list[tuple[str, str, str]]]:
    """What would be imported: a title, then rows of a name, words about it, and what they are.

    Clips come by the activity they would get; those without one after the others, for no ranking counts
    them, and last what is left out, each with the reason.
    """
    labels = [activity for activity in activities if activity]
    title = f"{count('clip', sum(map(len, activities.values())))}, {count('activity', len(labels))}"
    rows = [(f"{name}  ({len(activities[name])})", join_words(activities[name]), LABELLED) for name in labels]
    if without := activities.get(""):
        rows.append((f"No activity, not ranked  ({len(without)})", join_words(without), UNLABELLED))
    rows += [(name, why, LEFT_OUT) for name, why in left_out]
    return (f"{title}, {len(left_out)} left out" if left_out else title), rows


def outcome_sentence(used: int, failed: int, left_out: int, unlabelled: int, twice: Sequence[str]) -> str:
    """What an import did, in numbers and the names of what was there before, and what to look at."""
    parts = [f"Imported {count('motion', used)}"]
    if failed:
        parts.append(f"{count('file', failed)} cannot be used: the list says why")
    if left_out:
        parts.append(f"{left_out} left out: the list says why")
    if unlabelled:
        parts.append(f"{unlabelled} without an activity, which no ranking counts: type it in the list")
    if twice:
        names = join_words([f"'{name}'" for name in twice], most=1)
        parts.append(f"{names} was in the list already: one motion twice flatters a ranking")
    return "; ".join(parts)


def activity_of_action(action: str, armature: str = "") -> str:
    """Label of a clip from the name of its action in Blender; "" if that says nothing.

    Blender itself names an action after the armature.

    Examples
    --------
    >>> activity_of_action("Armature|Sit To Stand.002")
    'sit_to_stand'
    >>> activity_of_action("Armature|mixamo.com|Layer0")
    ''
    """
    return as_label(telling_part(action, frozenset({armature, f"{armature}Action"})))


def _label(path: Path, by: str, animation: str) -> str:
    if by == BY_FOLDER:
        return as_label(clean(path.absolute().parent.name))
    if animation:
        return as_label(telling_part(clean(animation)))
    return activity_of(clean(path.name))


def _plan(clips: Sequence[Clip], left_out: Sequence[tuple[str, str]], check: LabelCheck) -> ImportPlan:
    """A plan without files that are the same as another of it: they would be tested on what they trained."""
    copies = same_files([clip.path for clip in clips])
    file_of = {(clip.path, clip.animation): clip.file for clip in clips}
    firsts = [(clip.file, (copies[clip.path], clip.animation)) for clip in clips if clip.path in copies]
    twice = [(file, f"it is the same file as {file_of[first]}") for file, first in firsts if first in file_of]
    alone = tuple(clip for clip in clips if clip.path not in copies)
    return ImportPlan(alone, (*left_out, *twice), check=check)
