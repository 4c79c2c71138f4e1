# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of clips in a results folder, one line of JSON each: those used, then those skipped."""

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from .files import atomic_write

CLIP_LIST = "clips.jsonl"

Entry = dict[str, Any]


def write_clip_list(out: Path, entries: Iterable[Entry]) -> None:
    """Write the list into a results folder, whole or not at all."""
    with atomic_write(out / CLIP_LIST) as stream:
        for entry in entries:
            line = json.dumps(entry, ensure_ascii=False, allow_nan=False) + "\n"
            stream.write(line.encode("utf-8", "backslashreplace"))


def read_clip_list(out: Path) -> Iterator[Entry]:
    """Each clip of a results folder; a ValueError where the list is damaged."""
    with (out / CLIP_LIST).open(encoding="utf-8") as stream:
        for line in stream:
            entry = json.loads(line)
            if not isinstance(entry, dict) or "file" not in entry:
                raise ValueError(f"{CLIP_LIST} is damaged: a line names no file")
            yield entry


def is_used(entry: Entry) -> bool:
    """Whether the clip was turned into signals; others say why they were `skipped`."""
    return "skipped" not in entry
