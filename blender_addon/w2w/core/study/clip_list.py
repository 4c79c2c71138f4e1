# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips in a results folder, one line of JSON each: those used, then those skipped."""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from ..files import atomic_write
from ..given import checked, inside

CLIP_LIST = "clips.jsonl"

Entry = dict[str, Any]


def write_clip_list(out: Path, entries: Iterable[Entry]) -> None:
    """Write the list into a results folder, whole or not at all."""
    with atomic_write(out / CLIP_LIST) as stream:
        for entry in entries:
            line = json.dumps(entry, ensure_ascii=False, allow_nan=False) + "\n"
            stream.write(line.encode("utf-8", "backslashreplace"))


def read_clip_list(out: Path) -> Iterator[Entry]:
    """Each clip of a results folder; ValueError if the list is damaged or names a file elsewhere."""
    path = inside(out, CLIP_LIST)
    with path.open(encoding="utf-8") as stream:
        for number, line in enumerate(stream, start=1):
            entry = json.loads(line)
            if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
                raise ValueError(f"{CLIP_LIST} is damaged: line {number} names no file")
            if "clip" in entry:
                checked(entry["clip"], f"{path}, line {number},")
            yield entry


def is_used(entry: Entry) -> bool:
    """Whether the clip was turned into signals; others have the reason under `skipped`."""
    return "skipped" not in entry
