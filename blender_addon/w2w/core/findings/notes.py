# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on the clips and labels behind a result."""

from collections.abc import Sequence
from typing import Any

from ..library.labels import LabelCheck
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import UtilityMap
from ..wording import count, join_words

TOO_FEW = "too few clips"
"""In a table's cell, instead of an interval."""


def counts_sentence(clips: dict[str, int], utility: UtilityMap) -> str:
    """The counts in words."""
    names, left_out = len(utility.activities), len(utility.left_out)
    text = f"{clips['ranked']} of {clips['found']} clips ranked, in {names} activities"
    if left_out:
        others = clips["used"] - clips["ranked"]
        belong = "belongs" if others == 1 else "belong"
        text += (
            f"; {count('clip', others)} could be used but {belong} to {count('activity', left_out)} that "
            "could not be ranked"
        )
    return f"{text}; {clips['skipped']} skipped"


def few_clips(clips: int) -> str:
    """A caution if an interval comes from too few clips; else ""."""
    return "" if clips >= FEWEST_CLIPS else f"from {count('clip', clips)} only: too few for an interval"


def interval_text(low: float, high: float, caution: str, digits: int = 3) -> str:
    """An interval, or that there are too few clips for one."""
    return TOO_FEW if caution else f"{low:.{digits}f} to {high:.{digits}f}"


def label_notes(check: LabelCheck) -> list[str]:
    """One sentence for each kind of oddity."""
    notes = [f"{check.note}."] if check.note else []
    for name, ways in check.spellings:
        if check.exact and len(ways) > 1:
            notes.append(f"{_quoted(ways)} count as different activities (--exact-labels).")
        else:
            hint = " (--exact-labels keeps them apart)" if len(ways) > 1 else ""
            notes.append(f"{merged_sentence(name, ways)}{hint}.")
    notes += [f"{merged_sentence(name, ways, 'subject')}." for name, ways in check.subjects]
    kinds = (
        (check.no_such_file, "row matches no file", "rows match no file"),
        (check.no_activity, "row has no activity or no file name", "rows have no activity or no file name"),
        (check.not_listed, "file is not listed", "files are not listed"),
    )
    for files, singular, plural in kinds:
        if files:
            notes.append(f"{len(files)} {singular if len(files) == 1 else plural}: {join_words(files)}.")
    return notes


def merged_sentence(name: str, ways: Sequence[str], what: str = "activity") -> str:
    """A sentence on the spellings of a label that count as one."""
    if len(ways) == 1:
        return f"{_quoted(ways)} is encoded in two ways that look the same, and counts as one {what}"
    return f"{_quoted(ways)} count as one {what}, '{name}'"


def _quoted(names: Sequence[str]) -> str:
    return join_words([f"'{name}'" for name in names], len(names))


def label_content(check: LabelCheck) -> dict[str, Any]:
    """All notes, with every file named."""
    return {
        "rows_without_file": list(check.no_such_file),
        "rows_without_activity": list(check.no_activity),
        "files_not_listed": list(check.not_listed),
        "spellings": {name: list(ways) for name, ways in check.spellings},
        "spellings_kept_apart": check.exact,
        "subjects": {name: list(ways) for name, ways in check.subjects},
        "notes": label_notes(check),
    }
