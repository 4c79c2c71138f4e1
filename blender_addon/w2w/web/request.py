# SPDX-License-Identifier: GPL-3.0-or-later
"""What was asked of a study of the web app: `request.json` in its folder, damaged or not."""

import json
import re
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..core.files import write_json
from ..core.library.library import LABELS
from .uploads import RefusedError

INPUT, RESULTS, EVENTS, REQUEST, IDLE = "input", "results", "events.jsonl", "request.json", "idle"

PATH = re.compile(r"(?<![^\s'\"(=:,])(?:[A-Za-z]:)?[/\\](?:[^\s'\"/\\:,]+[/\\])+(?=[^\s/\\])")
"""Folders of a path of this machine in a sentence."""

PARTS: dict[str, tuple[type | tuple[type, ...], Any]] = {
    "made": ((int, float), 0.0), "asked": ((int, float, type(None)), None), "parameters": (dict, {}),
    "files": (dict, {}), "judged": (dict, {}), "sums": (dict, {}), "ran": (dict, {}), "answered": (dict, {}),
    "shared": (str, ""),
}  # fmt: skip
"""What a request holds, each with its kind and what it is where an earlier version wrote none."""


@dataclass(frozen=True)
class Requested:
    """A study's folder and what was asked of it."""

    folder: Path

    def request(self) -> dict[str, Any]:
        """What was asked: parameters, files, since when it waits for its run; a RefusedError if damaged."""
        try:
            found = json.loads((self.folder / REQUEST).read_text(encoding="utf-8"))
            request = {name: found.get(name, empty) for name, (_, empty) in PARTS.items()}
            if "sums" not in found and (self.folder / INPUT / LABELS).is_file():
                request["files"] = {LABELS: LABELS, **request["files"]}  # the demo's were not listed once
            damaged = not all(isinstance(request[name], kind) for name, (kind, _) in PARTS.items())
        except FileNotFoundError as error:
            raise RefusedError(404, NO_STUDY) from error
        except (OSError, ValueError, AttributeError, TypeError, RecursionError):
            damaged = True
        if damaged:
            raise RefusedError(500, f"{DAMAGED}: put back a copy of it, or delete the study")
        return request

    def change(self, **changes: Any) -> None:
        write_json(self.folder / REQUEST, self.request() | changes)

    def without_paths(self, text: str) -> str:
        """A sentence without the server's own paths, files under the names that they were given."""
        names = {}
        with suppress(RefusedError):
            names = self.request()["files"]
        text = text.replace(str(self.folder / INPUT), "the study").replace(f"{self.folder}/", "")
        for own, name in names.items():
            if own != name:
                text = text.replace(own, name)
        return PATH.sub("", text.replace("the study/", ""))


NO_STUDY = "There is no such study here: its address is wrong, or it was deleted"

DAMAGED = "This study cannot be read: its request.json is damaged"
