# SPDX-License-Identifier: GPL-3.0-or-later
"""A study of the web app: a folder with what was uploaded, what was asked, and the results of its run.

The folder is all that there is: a server that was killed knows from it where it was.
"""

import json
import re
import secrets
import time
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, TypeGuard

from ..core.csv_tables import csv_text
from ..core.files import write_json, write_text
from ..core.imu.presets import PRESETS
from ..core.library.labels import LibraryError
from ..core.library.library import LABELS, Library, is_motion, read_library
from ..core.readers.animations import contents
from ..core.wording import shown
from ..headless.commands.demo import TARGET, write_library
from ..headless.commands.status import describe
from ..headless.runs.monitor import read_state
from ..headless.study_options import NAMES, StudyOptions
from ..report.page import REPORT
from .uploads import MOST_NAME, RefusedError

INPUT, RESULTS, EVENTS, REQUEST = "input", "results", "events.jsonl", "request.json"

ID = re.compile(r"[0-9a-f]{32}")

STOPPED = 128
"""Exit codes from here on are a signal's: such a run is not finished."""

PARAMETERS: dict[str, tuple[type, ...]] = {
    "target": (int, float), "every_activity": (int, float), "max_places": (int,), "only": (str,),
    "forbid": (str,), "must": (str,), "background": (str,), "sensor": (str,), "title": (str,),
    "by_subject": (bool,), "patches": (int,), "seed": (int,),
}  # fmt: skip
"""Parameters that a study may ask for, each with its types: of `w2w run`, none that names a file."""

COLUMNS = ("file", "activity", "subject", "source", "motion_key", "rate")


@dataclass(frozen=True)
class Study:
    """A study by its folder, whose name is its id and whose parent is its owner's folder."""

    folder: Path

    @classmethod
    def make(cls, owner: Path, demo: bool = False) -> Self:
        """Make a study under an id that nobody can guess."""
        study = cls(owner / secrets.token_hex(16))
        (study.folder / INPUT).mkdir(parents=True)
        files: dict[str, str] = {}
        if demo:
            write_library(study.folder / INPUT, 6)
            files = {clip.file: clip.file for clip in study.library().clips}
        asked = {"target": TARGET} if demo else {}
        request = {"made": time.time(), "asked": None, "parameters": asked, "files": files, "judged": {}}
        write_json(study.folder / REQUEST, request)
        return study

    @classmethod
    def of(cls, owner: Path, name: str) -> Self:
        """The owner's study with an id; a RefusedError if there is none."""
        study = cls(owner / name)
        if not ID.fullmatch(name) or not (study.folder / REQUEST).is_file():
            raise RefusedError(404, "There is no such study here: its address is wrong, or it was deleted")
        return study

    @property
    def id(self) -> str:
        return self.folder.name

    @property
    def results(self) -> Path:
        return self.folder / RESULTS

    def request(self) -> dict[str, Any]:
        """What was asked: parameters, files, and since when it waits for its run."""
        return json.loads((self.folder / REQUEST).read_text(encoding="utf-8"))

    def change(self, **changes: Any) -> None:
        write_json(self.folder / REQUEST, self.request() | changes)

    def library(self, edited: bool = True) -> Library:
        """The clips under the labels of the table, else their own; a RefusedError if there are none."""
        labels = self.folder / LABELS
        try:
            return read_library(self.folder / INPUT, labels if edited and labels.exists() else None)
        except LibraryError as error:
            raise RefusedError(400, self.shown(str(error))) from error

    def rates(self) -> dict[str, float]:
        """The frame rates that labels give to files, by their paths in the study."""
        if not (self.folder / INPUT / LABELS).is_file():
            return {}
        with suppress(RefusedError):
            clips = self.library(edited=False).clips
            return {clip.path.relative_to(self.folder / INPUT).as_posix(): clip.rate for clip in clips}
        return {}

    def shown(self, text: str) -> str:
        """A sentence without the server's own paths."""
        return text.replace(str(self.folder / INPUT), "the study").replace(f"{self.folder}/", "")

    def table(self) -> tuple[list[dict[str, Any]], str]:
        """A row for each clip, with its labels and what is known of it, and what is wrong with all labels."""
        request, problem = self.request(), ""
        clips = {}
        try:
            clips = {clip.file: clip for clip in self.library().clips}
        except RefusedError as error:
            problem = str(error)
        rows = []
        for file, name in sorted(request["files"].items()):
            if not is_motion(self.folder / INPUT / file):
                continue
            for item in contents([(self.folder / INPUT / file, file)]):
                clip = clips.get(shown(item.file))
                labels = {"activity": clip.activity, "subject": clip.subject} if clip else {}
                judged = request["judged"].get(file)
                named = f"{name}{shown(item.file)[len(file) :]}"  # an animation's comes after its file's
                rows.append({"file": shown(item.file), "name": named, "judged": judged, **labels})
        return rows, problem

    def label(self, rows: Any) -> None:
        """Take labels of the table: rows of file, activity ("" leaves the clip out) and subject."""
        files = self.request()["files"]
        own = {clip.file: clip for clip in self.library(edited=False).clips}
        lines: list[tuple[str, ...]] = [COLUMNS]
        for row in rows if isinstance(rows, list) else [None]:
            cells = [row.get(name, "") for name in COLUMNS[:3]] if isinstance(row, dict) else []
            texts = [cell for cell in cells if _is_text(cell)]
            if len(texts) != 3 or texts[0] not in {*files, *own}:
                raise RefusedError(400, "labels are rows of a file of the study, activity and subject")
            clip = own.get(texts[0])
            more = [clip.source, clip.motion_key, str(clip.rate or "")] if clip else [""] * 3
            lines.append((*texts, *more))
        write_text(self.folder / LABELS, csv_text(lines))

    def added(self, files: Collection[str]) -> None:
        """Give new files their own labels in a table that was edited before."""
        if (self.folder / LABELS).exists() and files:
            added = {item.file for item in contents((self.folder / INPUT / file, file) for file in files)}
            rows = [row for row in self.table()[0] if row["file"] not in added]
            own = [clip for clip in self.library(edited=False).clips if clip.file in added]
            new = [{"file": clip.file, "activity": clip.activity, "subject": clip.subject} for clip in own]
            self.label([*rows, *new])

    def ask(self, parameters: Any) -> None:
        """Ask for a run with parameters; a RefusedError says what is wrong with them."""
        self.change(parameters=checked_parameters(parameters))
        self.library()
        (self.folder / EVENTS).unlink(missing_ok=True)
        self.change(asked=time.time())

    def command(self, workers: int, scheduler: str) -> list[str]:
        """The words of the command that does this study's run."""
        asked = self.request()["parameters"]
        words = ["run", str(self.folder / INPUT), "--out", str(self.results), f"--workers={workers}"]
        if (edited := self.folder / LABELS).exists():
            words.append(f"--labels={edited}")
        if scheduler:
            words.append(f"--scheduler={scheduler}")
        for name, value in asked.items():
            option = NAMES.get(name, f"--{name.replace('_', '-')}")
            words += [f"{option}={value}"] if not isinstance(value, bool) else [option] * value
        return [*words, "--log-json"]

    def end(self) -> dict[str, Any] | None:
        """The last event of a run that has ended by itself: its `exit_code`, and the `problem` if any."""
        try:
            last = json.loads((self.folder / EVENTS).read_bytes().splitlines()[-1])
        except (OSError, ValueError, IndexError):
            return None
        ended = last.get("event") == "finished" and last["exit_code"] < STOPPED
        return last if ended else None

    @property
    def waits(self) -> bool:
        """Whether a run was asked for and has not ended."""
        return self.request()["asked"] is not None and self.end() is None

    def progress(self, running: bool) -> dict[str, Any]:
        """The state of the study's run, in a word and a sentence, and its answer."""
        asked, end = self.request()["asked"], self.end()
        answer = self.answer()
        if asked is None:
            return {"state": "draft", "sentence": "", "answer": answer}
        if end is not None:
            word = "failed" if end["exit_code"] else "finished"
            return {"state": word, "sentence": self.shown(end.get("problem", "")), "answer": answer}
        if not running:
            return {"state": "queued", "sentence": "Waiting for other studies to end.", "answer": ""}
        progress = {"state": "running", "sentence": "Starting.", "answer": "", "share": 0.0}
        try:
            state = read_state(self.results)
        except (OSError, ValueError, TypeError):
            return progress
        if state.started >= asked:
            progress["sentence"] = describe(state, running=True)
            progress["share"] = state.done / state.clips if state.clips else 0.0
        return progress

    def answer(self) -> str:
        """The sentence of the results, "" if there are none."""
        try:
            if not (self.results / REPORT).is_file():
                return ""
            summary = json.loads((self.results / "summary.json").read_text(encoding="utf-8"))
            return summary["answer"]["sentence"]
        except (OSError, ValueError, KeyError, TypeError):
            return ""


def _is_text(value: object) -> TypeGuard[str]:
    return isinstance(value, str) and len(value) <= MOST_NAME and value.isprintable()


def checked_parameters(given: Any) -> dict[str, Any]:
    """Parameters from a request, as they are; a RefusedError says which is wrong."""
    if not isinstance(given, dict):
        raise RefusedError(400, "parameters are an object of names and values")
    given = {name: value for name, value in given.items() if value not in (None, "")}
    for name, value in given.items():
        kinds = PARAMETERS.get(name)
        if kinds is None:
            raise RefusedError(400, f"there is no parameter {name[:80]!r}, but {', '.join(PARAMETERS)}")
        if type(value) not in kinds or (isinstance(value, str) and not _is_text(value)):
            raise RefusedError(400, f"{name} cannot be {str(value)[:80]!r}")
    if given.get("sensor", "ideal") not in PRESETS:
        raise RefusedError(400, f"sensor is one of {', '.join(PRESETS)}")
    try:
        StudyOptions(**given).config()
    except (ValueError, OSError) as error:
        raise RefusedError(400, str(error)) from error
    return given
