# SPDX-License-Identifier: GPL-3.0-or-later
"""Labels from captions in words, as HumanML3D has them (Guo et al. 2022, doi 10.1109/CVPR52688.2022.00509).

``texts/000021.txt`` captions ``new_joints/000021.npy``, a line each: ``a person walks.#a/DET person/NOUN
walk/VERB#0.0#0.0``, the words with their base forms, and the seconds that it is about; 0 to 0 is the whole.
"""

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

from ..csv_tables import CsvError, read_table
from ..wording import shown
from .labels import LabelCheck, LibraryError

COLUMNS = ("caption", "activity")

WORD = re.compile(r"[^\W_]+")

MOST_BYTES = 2**20
"""Longest file of captions that is read."""


def asks_for_captions(path: Path) -> bool:
    """Whether a csv labels captions rather than files."""
    try:
        return not any(row["file"] for _, row in read_table(path, COLUMNS, ("file",)).rows)
    except CsvError:
        return False


def read_caption_labels(
    path: Path, folder: Path, inside: Sequence[str]
) -> tuple[dict[str, dict[str, str]], dict[str, str], LabelCheck]:
    """Labels of a library's files by the words of their captions.

    The csv has columns ``caption`` and ``activity``: a clip is of an activity if one of its captions holds
    the row's words side by side, as they stand or in their base forms (*walk* is in "he walks"). Captions of
    a whole clip count, from ``NAME.txt`` beside the clip or in a folder ``texts`` beside its own.

    Returns rows by file as `read_labels` does, the reason for each file without one, and what stood out.
    Raises LibraryError if the csv cannot be understood, or labels nothing.
    """
    try:
        table = read_table(path, COLUMNS)
    except CsvError as error:
        raise LibraryError(str(error)) from error
    wanted = [(_words(row["caption"]), row["activity"]) for _, row in table.rows if all(row.values())]
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
    empty = tuple(f"line {number}" for number, row in table.rows if not all(row.values()))
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
