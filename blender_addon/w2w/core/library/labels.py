# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels from a csv file: which row means which clip, and what in it is of no use.

A row names a file or words of captions, as HumanML3D has them (Guo et al. 2022, doi
10.1109/CVPR52688.2022.00509). ``texts/000021.txt`` captions ``new_joints/000021.npy``, a line each: ``a
person walks.#a/DET person/NOUN walk/VERB#0.0#0.0``, the words with their base forms, and the seconds that it
is about; 0 to 0 is the whole.
"""

import posixpath
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path, PurePosixPath
from typing import Any, TypeVar

from ..csv_tables import CsvError, CsvTable, read_table
from ..motion.source import HIGHEST_RATE, LOWEST_RATE
from ..wording import clean, composed, harmless, plain_words, restated


class LibraryError(ValueError):
    """A library or its labels cannot be understood; the message says what to change."""

    def __init__(self, message: str) -> None:
        super().__init__(harmless(message))


Key = TypeVar("Key")

COLUMNS = ("file", "activity"), ("subject", "motion_key", "source", "rate")
"""Columns that a csv of labels must have, and those that it may have."""

Row = dict[str, Any]
"""Labels of a file by column: text, and the ``rate`` as a number, 0 where none is given."""

Spellings = tuple[tuple[str, tuple[str, ...]], ...]
"""Labels that were spelled in several ways, each with the ways; one way if all look the same."""


@dataclass(frozen=True)
class LabelCheck:
    """Problems and assumptions when labels were read."""

    no_such_file: tuple[str, ...] = ()  # files that a row names and the library does not hold
    no_activity: tuple[str, ...] = ()  # files whose row has no activity; the row's line if it has no file
    not_listed: tuple[str, ...] = ()  # files of the library that no row names
    spellings: Spellings = ()  # of activities
    subjects: Spellings = ()
    exact: bool = False  # whether the ways were kept apart
    note: str = ""  # what had to be assumed to read the file


NO_LABELS = LabelCheck()
"""The check of a library that no csv file labels."""


WORD = re.compile(r"[^\W_]+")

MOST_BYTES = 2**20
"""Longest file of captions that is read."""


def label_rows(
    labels: Path, folder: Path, inside: Sequence[str], exact: bool
) -> tuple[dict[str, Row], dict[str, str], LabelCheck]:
    """Labels of a library's files by a csv of files or of captions.

    Returns rows by file as `read_labels` does, the reason for each file without one, and what stood out.
    Raises LibraryError if the csv cannot be understood, or labels nothing.
    """
    with suppress(CsvError):
        captions = read_table(labels, ("caption", "activity"), ("file",))
        if not any(row["file"] for _, row in captions.rows):
            return _caption_labels(labels, captions, folder, inside, exact)
    rows, check = read_labels(labels, folder, inside, exact)
    reasons = dict.fromkeys(inside, f"{clean(labels.name)} gives it no activity")
    return rows, reasons | dict.fromkeys(check.not_listed, f"{clean(labels.name)} does not list it"), check


def read_labels(
    path: Path, folder: Path, inside: Sequence[str], exact: bool = False
) -> tuple[dict[str, Row], LabelCheck]:
    """Rows of labels by path inside a library, of those paths that are `inside` it, and what stood out.

    The csv has columns ``file`` and ``activity``, and if wanted ``subject``, ``motion_key``, ``source`` and
    ``rate``, in frames a second.
    `exact` keeps activities apart that differ only in case, spaces, underscores or hyphens.

    Raises LibraryError, naming the line, if the file cannot be understood.
    """
    with restated("", CsvError, LibraryError):
        table = read_table(path, *COLUMNS)
    find = _Finder(folder, inside)
    rows: dict[str, Row] = {}
    strangers, empty, named = [], [], set()
    for number, cells in table.rows:
        row: Row = cells | {"rate": _rate(cells["rate"], f"{clean(path)}, line {number}")}
        text = row.pop("file")
        files = find.candidates(text)
        if not (text and row["activity"]):
            empty.append(text or f"line {number}")
            named.update(files)
        elif not files:
            strangers.append(text)
        elif len(files) > 1:
            raise LibraryError(
                f"{clean(path)}, line {number}: '{text}' could be any of {', '.join(files[:3])}: "
                "write the path inside the library"
            )
        elif not _same_labels(rows.setdefault(files[0], row), row):
            raise LibraryError(
                f"{clean(path)}, line {number}: '{files[0]}' is listed twice with different labels"
            )
    if not rows:
        raise LibraryError(_useless(path, inside, strangers, empty))
    rows, check = spelled_once(rows, exact)
    named.update(rows)
    missing = tuple(file for file in inside if file not in named)
    return rows, replace(
        check, no_such_file=tuple(strangers), no_activity=tuple(empty), not_listed=missing, note=table.note
    )


def same_label(label: str) -> str:
    """The common form of labels that differ only in case, spaces, underscores, hyphens within, and encoding.

    Examples
    --------
    >>> same_label(" Sit  To_Stand "), same_label("sit-to-stand")
    ('sit_to_stand', 'sit_to_stand')
    """
    words = plain_words(label)
    return re.sub(r"[ _]+", "_", re.sub(r"(?<=\w)-(?=\w)", "_", words)).strip("_") or words


def speller(listed: Iterable[str]) -> Callable[[str], str]:
    """A function that spells a label as it is listed, else as it is given."""
    known: dict[str, str] = {}
    for label in listed:
        known.setdefault(same_label(label), label)
    return lambda given: known.get(same_label(given), composed(given))


def spelled_once(
    rows: Mapping[Key, Row], exact: bool = False, form: Callable[[str], str] = composed
) -> tuple[dict[Key, Row], LabelCheck]:
    """Rows of labels in which each activity and subject has one spelling, and those that had several.

    `exact` keeps activities apart, never subjects: one person on both sides of leave-one-subject-out would
    flatter. `form` makes an activity's name from its spelling.
    """
    name_of, spellings = one_spelling((row["activity"] for row in rows.values()), form)
    if exact:
        name_of = {text: composed(text) for text in name_of}
    who, subjects = one_spelling(row.get("subject", "") for row in rows.values())
    spelled = {
        file: row | {"activity": name_of[row["activity"]], "subject": who[row.get("subject", "")]}
        for file, row in rows.items()
    }
    return spelled, LabelCheck(spellings=spellings, subjects=subjects, exact=exact)


def _rate(text: str, place: str) -> float:
    """Frames a second in a cell, 0 if it is empty; a LibraryError names the place of any other text."""
    with suppress(ValueError):
        rate = float(text.replace(",", ".") or 0)
        if not text or LOWEST_RATE <= rate <= HIGHEST_RATE:
            return rate
    raise LibraryError(
        f"{place}: the rate is '{text}'; it is in frames a second, {LOWEST_RATE:g} to {HIGHEST_RATE:,.0f}, "
        "such as 30, or empty where the file's own is right"
    )


def _same_labels(first: Row, second: Row) -> bool:
    return all(same_label(str(first[name])) == same_label(str(second[name])) for name in first)


def by_label(values: Mapping[str, Any], labels: Iterable[str]) -> dict[str, Any]:
    """Values of labels: those given for the very label, else for one that `same_label` makes the same."""
    by_spelling = {same_label(label): value for label, value in values.items()}
    by_name = {label: values.get(label, by_spelling.get(same_label(label))) for label in labels}
    return {label: value for label, value in by_name.items() if value is not None}


def one_spelling(
    labels: Iterable[str], form: Callable[[str], str] = composed
) -> tuple[dict[str, str], Spellings]:
    """The commonest spelling of each label, of equals that in lower case; and the labels with several."""
    uses = Counter(labels)
    groups: dict[str, list[str]] = {}
    for text in sorted(uses, key=lambda text: (-uses[text], text != text.lower(), text)):
        groups.setdefault(same_label(text), []).append(text)
    name_of = {text: form(ways[0]) for ways in groups.values() for text in ways}
    several = [tuple(dict.fromkeys(map(composed, ways))) for ways in groups.values() if len(ways) > 1]
    return name_of, tuple(sorted((form(ways[0]), ways) for ways in several))


class _Finder:
    """Search for the library's file that a row means.

    A row may give the end of a file's path, down to its bare name, or its whole path and the library's
    folder before it: any other folder in a row is one that the file does not lie in. If no file has exactly
    that name, `plain_words` decides.
    """

    def __init__(self, folder: Path, inside: Sequence[str]) -> None:
        self.known = set(inside)
        self.inside = inside
        self.folders = {plain_words(clean(path.name)) for path in (folder.absolute(), folder.resolve())}

    @cached_property
    def by_name(self) -> dict[str, list[tuple[str, str]]]:
        """Files by their names, each with its path, in plain words."""
        files_of: dict[str, list[tuple[str, str]]] = {}
        for file in self.inside:
            plain = plain_words(file)
            files_of.setdefault(posixpath.basename(plain), []).append((file, plain))
        return files_of

    def candidates(self, text: str) -> list[str]:
        """Files that may be meant; none if the library does not hold one."""
        path = text if text in self.known else PurePosixPath(text.replace("\\", "/")).as_posix()
        if path in self.known:
            return [path]
        asked = plain_words(path)
        same_name = self.by_name.get(posixpath.basename(asked), [])
        whole = []
        for file, plain in same_name:
            before = asked.removesuffix(f"/{plain}")
            if before != asked and posixpath.basename(before) in self.folders:
                whole.append(file)
        fitting = whole or [file for file, plain in same_name if f"/{plain}".endswith(f"/{asked}")]
        to_the_letter = [
            file for file in fitting if f"/{path}".endswith(f"/{file}") or f"/{file}".endswith(f"/{path}")
        ]
        return to_the_letter or fitting


def _useless(path: Path, inside: Sequence[str], strangers: list[str], empty: list[str]) -> str:
    text = f"{clean(path)} lists none of the {len(inside)} motion files in the library with an activity"
    if strangers:
        text += f"; it lists '{strangers[0]}', say, and the library holds '{inside[0]}'"
    elif empty:
        text += f": {len(empty)} rows have no file or no activity"
    return text


def _caption_labels(
    path: Path, table: CsvTable, folder: Path, inside: Sequence[str], exact: bool
) -> tuple[dict[str, Row], dict[str, str], LabelCheck]:
    """Labels by the words of captions.

    A clip is of an activity if one of its captions holds a row's words side by side, as they stand or in
    their base forms (*walk* is in "he walks"). Captions of a whole clip count, from ``NAME.txt`` next to the
    clip or in a folder ``texts`` next to its own.
    """
    listed = {number: row for number, row in table.rows if row["caption"] and row["activity"]}
    listed, check = spelled_once(listed, exact)
    wanted = [(_words(row["caption"]), row["activity"]) for row in listed.values()]
    rows: dict[str, Row] = {}
    left_out: dict[str, str] = {}
    for file in inside:
        texts = list(_captions(folder / file))
        activities = sorted({activity for words, activity in wanted if any(words in text for text in texts)})
        if len(activities) == 1:
            rows[file] = {"activity": activities[0]}
        elif activities:
            left_out[file] = f"its captions are of {' and '.join(activities)}"
        else:
            left_out[file] = "none of its captions is listed" if texts else "it has no captions"
    if not rows:
        raise LibraryError(f"{clean(path)} holds the words of no caption of the {len(inside)} motion files")
    empty = tuple(f"line {number}" for number, row in table.rows if not (row["caption"] and row["activity"]))
    return rows, left_out, replace(check, no_activity=empty, not_listed=tuple(left_out), note=table.note)


def _captions(file: Path) -> Iterator[str]:
    """Each caption of a whole clip, as it stands and then in base forms, by its `_words`."""
    for place in (file.parent, file.parent.parent / "texts"):
        text = place / f"{file.stem}.txt"
        if text.is_file() and text.stat().st_size <= MOST_BYTES:
            for line in text.read_text(encoding="utf-8", errors="replace").splitlines():
                caption, forms, *span = (*line.split("#"), "")
                if all(part in ("", "0.0", "nan") for part in span):
                    yield _words(caption)
                    yield _words(" ".join(word.partition("/")[0] for word in forms.split()))


def _words(text: str) -> str:
    """Words in lower case, with a space before and after each."""
    return f" {' '.join(WORD.findall(plain_words(text)))} "
