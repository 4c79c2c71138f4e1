# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels from a csv file: which row means which clip, and what in it is of no use.

A row names a file or words of captions, as HumanML3D has them (Guo et al. 2022, doi
10.1109/CVPR52688.2022.00509). ``texts/000021.txt`` captions ``new_joints/000021.npy``, a line each: ``a
person walks.#a/DET person/NOUN walk/VERB#0.0#0.0``, the words with their base forms, and the seconds that it
is about; 0 to 0 is the whole.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from ..csv_tables import CsvError, CsvTable, read_table
from ..wording import harmless, shown


class LibraryError(ValueError):
    """A library or its labels cannot be understood; the message says what to change."""

    def __init__(self, message: str) -> None:
        super().__init__(harmless(message))


@dataclass(frozen=True)
class LabelCheck:
    """Problems and assumptions when labels were read."""

    no_such_file: tuple[str, ...] = ()  # files that a row names and the library does not hold
    no_activity: tuple[str, ...] = ()  # files whose row has no activity; the row's line where it has no file
    not_listed: tuple[str, ...] = ()  # files of the library that no row names
    # activities that were spelled in several ways, each with the ways
    spellings: tuple[tuple[str, tuple[str, ...]], ...] = ()
    exact: bool = False  # whether the ways were kept apart
    note: str = ""  # what had to be assumed to read the file


NO_LABELS = LabelCheck()
"""The check of a library that no csv file labels."""


WORD = re.compile(r"[^\W_]+")

MOST_BYTES = 2**20
"""Longest file of captions that is read."""


def label_rows(
    labels: Path, folder: Path, inside: Sequence[str], exact: bool
) -> tuple[dict[str, dict[str, str]], dict[str, str], LabelCheck]:
    """Labels of a library's files by a csv of files or of captions.

    Returns rows by file as `read_labels` does, the reason for each file without one, and what stood out.
    Raises LibraryError if the csv cannot be understood, or labels nothing.
    """
    with suppress(CsvError):
        captions = read_table(labels, ("caption", "activity"), ("file",))
        if not any(row["file"] for _, row in captions.rows):
            return _caption_labels(labels, captions, folder, inside)
    rows, check = read_labels(labels, folder, inside, exact)
    reasons = dict.fromkeys(inside, f"{shown(labels.name)} gives it no activity")
    return rows, reasons | dict.fromkeys(check.not_listed, f"{shown(labels.name)} does not list it"), check


def read_labels(
    path: Path, folder: Path, inside: Sequence[str], exact: bool = False
) -> tuple[dict[str, dict[str, str]], LabelCheck]:
    """Rows of labels by path inside a library, of those paths that are `inside` it, and what stood out.

    The csv has columns ``file`` and ``activity``, and if wanted ``subject``, ``motion_key`` and ``source``.
    `exact` keeps activities apart that differ only in case, spaces or underscores.

    Raises LibraryError, naming the line, if the file cannot be understood.
    """
    try:
        table = read_table(path, ("file", "activity"), ("subject", "motion_key", "source"))
    except CsvError as error:
        raise LibraryError(str(error)) from error
    find = _Finder(folder, inside)
    rows: dict[str, dict[str, str]] = {}
    strangers, empty, named = [], [], set()
    for number, row in table.rows:
        text = row.pop("file")
        found = find.candidates(text)
        if not (text and row["activity"]):
            empty.append(text or f"line {number}")
            named.update(found)
        elif not found:
            strangers.append(text)
        elif len(found) > 1:
            raise LibraryError(
                f"{shown(path)}, line {number}: '{text}' could be any of {', '.join(found[:3])}: "
                "write the path inside the library"
            )
        elif rows.setdefault(found[0], row) != row:
            raise LibraryError(
                f"{shown(path)}, line {number}: '{found[0]}' is listed twice with different labels"
            )
    if not rows:
        raise LibraryError(_useless(path, inside, strangers, empty))
    name_of, spellings = _one_spelling(row["activity"] for row in rows.values())
    if not exact:
        rows = {file: row | {"activity": name_of[row["activity"]]} for file, row in rows.items()}
    named.update(rows)
    missing = tuple(file for file in inside if file not in named)
    check = LabelCheck(tuple(strangers), tuple(empty), missing, spellings, exact, table.note)
    return rows, check


def same_label(label: str) -> str:
    """The common form of labels that differ only in case, spaces and underscores.

    Examples
    --------
    >>> same_label(" Sit  To_Stand ")
    'sit_to_stand'
    """
    return re.sub(r"[\s_]+", " ", unicodedata.normalize("NFC", label)).strip().replace(" ", "_").casefold()


def by_label(values: Mapping[str, Any], labels: Iterable[str]) -> dict[str, Any]:
    """Values of labels: those given for the very label, else for one that `same_label` makes the same."""
    alike = {same_label(label): value for label, value in values.items()}
    found = {label: values.get(label, alike.get(same_label(label))) for label in labels}
    return {label: value for label, value in found.items() if value is not None}


def _one_spelling(
    activities: Iterable[str],
) -> tuple[dict[str, str], tuple[tuple[str, tuple[str, ...]], ...]]:
    """One spelling for each: the commonest, of equals that in lower case; and those with several ways."""
    uses = Counter(activities)
    groups: dict[str, list[str]] = {}
    for text in sorted(uses, key=lambda text: (-uses[text], text != text.lower(), text)):
        groups.setdefault(same_label(text), []).append(text)
    name_of = {text: ways[0] for ways in groups.values() for text in ways}
    return name_of, tuple(sorted((ways[0], tuple(ways)) for ways in groups.values() if len(ways) > 1))


class _Finder:
    """Finds the file of the library that a row means.

    A row may give the end of a file's path, down to its bare name, or its whole path and the library's
    folder before it: any other folder in a row is one that the file does not lie in.
    """

    def __init__(self, folder: Path, inside: Sequence[str]) -> None:
        self.known = set(inside)
        self.folders = {shown(folder.absolute().name), shown(folder.resolve().name)}
        self.by_name: dict[str, list[str]] = {}
        for file in inside:
            self.by_name.setdefault(PurePosixPath(file).name, []).append(file)

    def candidates(self, text: str) -> list[str]:
        """Files that may be meant; none where the library does not hold one."""
        file = PurePosixPath(text.replace("\\", "/"))
        if file.as_posix() in self.known:
            return [file.as_posix()]
        same_name = self.by_name.get(file.name, [])
        whole = []
        for found in same_name:
            before = str(file).removesuffix(f"/{found}")
            if before != str(file) and PurePosixPath(before).name in self.folders:
                whole.append(found)
        return whole or [found for found in same_name if f"/{found}".endswith(f"/{file}")]


def _useless(path: Path, inside: Sequence[str], strangers: list[str], empty: list[str]) -> str:
    text = f"{shown(path)} lists none of the {len(inside)} motion files in the library with an activity"
    if strangers:
        text += f"; it lists '{strangers[0]}', say, and the library holds '{inside[0]}'"
    elif empty:
        text += f": {len(empty)} rows have no file or no activity"
    return text


def _caption_labels(
    path: Path, table: CsvTable, folder: Path, inside: Sequence[str]
) -> tuple[dict[str, dict[str, str]], dict[str, str], LabelCheck]:
    """Labels by the words of captions.

    A clip is of an activity if one of its captions holds a row's words side by side, as they stand or in
    their base forms (*walk* is in "he walks"). Captions of a whole clip count, from ``NAME.txt`` beside the
    clip or in a folder ``texts`` beside its own.
    """
    wanted = [
        (_words(row["caption"]), row["activity"])
        for _, row in table.rows
        if row["caption"] and row["activity"]
    ]
    rows: dict[str, dict[str, str]] = {}
    left_out: dict[str, str] = {}
    for file in inside:
        texts = list(_captions(folder / file))
        found = sorted({activity for words, activity in wanted if any(words in text for text in texts)})
        if len(found) == 1:
            rows[file] = {"activity": found[0]}
        elif found:
            left_out[file] = f"its captions are of {' and '.join(found)}"
        else:
            left_out[file] = "none of its captions is listed" if texts else "it has no captions"
    if not rows:
        raise LibraryError(f"{shown(path)} holds the words of no caption of the {len(inside)} motion files")
    empty = tuple(f"line {number}" for number, row in table.rows if not (row["caption"] and row["activity"]))
    check = LabelCheck(no_activity=empty, not_listed=tuple(left_out), note=table.note)
    return rows, left_out, check


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
    return f" {' '.join(WORD.findall(text.lower()))} "
