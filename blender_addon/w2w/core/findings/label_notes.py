# SPDX-License-Identifier: GPL-3.0-or-later
"""Notes on a library's labels, in sentences and as plain values."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..motion.labels import LabelCheck

NAMED = 3
"""Files named in a sentence; `summary.json` has them all."""


def label_notes(check: LabelCheck) -> list[str]:
    """One sentence for each kind of oddity."""
    notes = [f"{check.note}."] if check.note else []
    for name, ways in check.spellings:
        spelled = listed([f"'{way}'" for way in ways], len(ways))
        if check.exact:
            notes.append(f"{spelled} count as different activities (--exact-labels).")
        else:
            notes.append(f"{spelled} count as one activity, '{name}' (--exact-labels keeps them apart).")
    kinds = (
        (check.no_such_file, "row matches no file", "rows match no file"),
        (check.no_activity, "row has no activity or no file name", "rows have no activity or no file name"),
        (check.not_listed, "file is not listed", "files are not listed"),
    )
    for files, one, many in kinds:
        if files:
            notes.append(f"{len(files)} {one if len(files) == 1 else many}: {listed(files)}.")
    return notes


def label_content(check: LabelCheck) -> dict[str, Any]:
    """All notes, with every file named."""
    return {
        "rows_without_file": list(check.no_such_file),
        "rows_without_activity": list(check.no_activity),
        "files_not_listed": list(check.not_listed),
        "spellings": {name: list(ways) for name, ways in check.spellings},
        "spellings_kept_apart": check.exact,
        "notes": label_notes(check),
    }


def copies_sentence(copies: Sequence[tuple[str, str]]) -> str:
    """Names the clips that are copies, each with the first that shows its motion; empty without any."""
    if not copies:
        return ""
    many = len(copies) > 1
    named = listed([f"{name} (of {first})" for name, first in copies])
    count = f"{len(copies)} clips count as copies" if many else "1 clip counts as a copy"
    return (
        f"{count} of another, by motion_key or by how the body moves, and no clip is tested on its copies: "
        f"{named}"
    )


def listed(words: Sequence[str], most: int = NAMED) -> str:
    """Words as a sentence lists them, the first few by name."""
    if len(words) > most:
        return f"{', '.join(words[:most])} and {len(words) - most} more"
    return " and ".join(filter(None, (", ".join(words[:-1]), words[-1])))
