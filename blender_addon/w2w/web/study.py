# SPDX-License-Identifier: GPL-3.0-or-later
"""A study of the web app: a folder with what was uploaded, what was asked, and the results of its run.

The folder is all that there is: a server that was killed knows from it where it was.
"""

import hmac
import json
import re
import secrets
import time
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

from ..core.files import write_json, write_text
from ..core.imu.presets import PRESETS
from ..core.library.library import LABELS
from ..core.parameters import parameters_of
from ..core.patches.body_parts import ALL, SIDES, find_patches
from ..core.ranking.weights import check_counting
from ..core.study.config import StudyConfig
from ..core.study.results import REPORT, UnfinishedError, check_finished
from ..core.wording import restated
from ..headless.commands.demo import write_library
from ..headless.commands.place import CHOICE
from ..headless.commands.status import describe
from ..headless.options import words
from ..headless.runs.monitor import read_state
from ..headless.study_options import NAMES, StudyOptions
from .clips import Labelled, is_text
from .request import DAMAGED, EVENTS, IDLE, INPUT, NO_STUDY, REQUEST, RESULTS
from .uploads import RefusedError, refused

ID = re.compile(r"[0-9a-f]{32}")

STOPPED = 128
"""Exit codes from here on are a signal's: such a run is not finished."""

LAST_BYTES = 2**16
"""Bytes at the end of a run's events that hold the last one."""

PARAMETERS: dict[str, tuple[type, ...]] = {
    name: (str,) if each.is_list else (int, float) if float in each.kinds else each.kinds[:1]
    for name, each in parameters_of(StudyConfig).items()
    if each.web
} | {"pose_up": (str,)}
"""Parameters that a study may ask for, each with its types: those declared for the web, none names a file."""

WISHES = {name: PARAMETERS[name] for name in CHOICE if name in PARAMETERS}
"""Those of them that can be chosen by again."""

REGIONS = [f"{side} {region}".strip() for region in ALL for side in ("", *SIDES)]

DEMO = {"title": "Five gestures at a desk", "by_subject": False}
"""What a study of the demo asks for: by clip, as `w2w demo`."""

CHANGED = {"clips": "the clips", "labels": "their labels", "wishes": "the wishes"}


@dataclass(frozen=True)
class Study(Labelled):
    """A study by its folder, whose name is its id and whose parent is its owner's folder."""

    @classmethod
    def make(cls, owner: Path, demo: bool = False) -> Self:
        """Make a study under an id that nobody can guess."""
        study = cls(owner / secrets.token_hex(16))
        (study.folder / INPUT).mkdir(parents=True)
        files: dict[str, str] = {}
        if demo:
            write_library(study.folder / INPUT)
            files = {clip.file: clip.file for clip in study.library().clips} | {LABELS: LABELS}
        request = {"made": time.time(), "parameters": DEMO if demo else {}, "files": files, "sums": {}}
        write_json(study.folder / REQUEST, request)
        return study

    @classmethod
    def of(cls, owner: Path, name: str) -> Self:
        """The owner's study with an id; a RefusedError if there is none."""
        study = cls(owner / name)
        if not ID.fullmatch(name) or not (study.folder / REQUEST).is_file():
            raise RefusedError(404, NO_STUDY)
        return study

    @classmethod
    def shared(cls, data: Path, link: str) -> Self:
        """The study that a link of id and secret leads anybody to; a RefusedError if there is none."""
        name, _, secret = link.partition(".")
        for path in data.glob(f"*/{name}") if ID.fullmatch(name) else ():
            study = cls(path)
            known = study.request()["shared"]
            if known and hmac.compare_digest(known.encode(), secret.encode()) and study.answer():
                return study
        raise RefusedError(404, "There is nothing here: the link is wrong, or was taken back")

    @property
    def id(self) -> str:
        return self.folder.name

    @property
    def results(self) -> Path:
        return self.folder / RESULTS

    def checked(self, parameters: Any) -> dict[str, Any]:
        """The changes of a request that asks for a run; a RefusedError says what is wrong with it."""
        given = checked_parameters(parameters)
        self.sweep()
        self.settle_labels()
        with restated("", ValueError, refused(400)):
            check_counting(self.library().activities, words(given.get("background", "")), ())
        return {
            "parameters": given,
            "answered": self.answered(),
            "ran": self.sums(given),
            "asked": time.time(),
        }

    def ask(self, changes: dict[str, Any]) -> None:
        """Ask for a run by `checked` changes."""
        (self.folder / EVENTS).unlink(missing_ok=True)
        self.change(**changes)

    def answered(self) -> dict[str, str]:
        """The sums of what the answer at hand was made from; {} if there is none."""
        request = self.request()
        if not self.answer():
            return {}
        ended = request["asked"] is not None and self.end() is not None
        return (request["ran"] if ended else request["answered"]) or self.sums()

    def note_answered(self) -> None:
        """Write down what the answer is of, before the first change by a version that knows it."""
        request = self.request()
        if not (request["ran"] or request["answered"]) and self.answer():
            self.change(ran=self.sums(), answered=self.sums())

    def stale(self) -> str:
        """Why the answer at hand is not that of what is asked now, in a sentence; "" if it is."""
        if not self.answer():
            return ""
        try:
            check_finished(self.results)
        except UnfinishedError:
            return "" if self.waits else "A new run was stopped: this answer may be of what was there before."
        except (OSError, ValueError):
            return ""
        now, then = self.sums(), self.answered()
        changed = [text for name, text in CHANGED.items() if then.get(name, now[name]) != now[name]]
        if not changed:
            return ""
        return f"Since this answer {' and '.join(changed)} changed: run again for a new one."

    def command(self, workers: int, scheduler: str) -> list[str]:
        """The words of the command that does this study's run."""
        asked = self.request()["parameters"]
        words = ["run", str(self.folder / INPUT), "--out", str(self.results), f"--workers={workers}"]
        if self.edited.exists():
            words.append(f"--labels={self.edited}")
        if scheduler:
            words.append(f"--scheduler={scheduler}")
        for name, value in asked.items():
            option = NAMES.get(name, f"--{name.replace('_', '-')}")
            words += [f"{option}={value}"] if not isinstance(value, bool) else [option] * value
        return [*words, "--log-json"]

    def end(self) -> dict[str, Any] | None:
        """The last event of a run that has ended by itself: its `exit_code`, and the `problem` if any."""
        with suppress(OSError, ValueError, LookupError, TypeError, AttributeError):
            with (self.folder / EVENTS).open("rb") as stream:
                stream.seek(max(0, stream.seek(0, 2) - LAST_BYTES))
                last = json.loads(stream.read().splitlines()[-1])
            return last if last.get("event") == "finished" and last["exit_code"] < STOPPED else None
        return None

    @property
    def waits(self) -> bool:
        """Whether a run was asked for and has not ended."""
        return self.request()["asked"] is not None and self.end() is None

    def progress(self, running: bool, before: int = 0) -> dict[str, Any]:
        """The state of the run, in a word and a sentence, and its answer; so many others are `before` it."""
        asked, end = self.request()["asked"], self.end()
        answer = self.answer()
        if asked is None:
            return {"state": "draft", "sentence": "", "answer": answer}
        if end is not None:
            word = "failed" if end["exit_code"] else "finished"
            return {"state": word, "sentence": self.without_paths(end.get("problem", "")), "answer": answer}
        if not running:
            others = f" {before} before it." if before else ""
            sentence = f"Waiting for other studies to end.{others}"
            return {"state": "queued", "sentence": sentence, "answer": "", "before": before}
        progress = {"state": "running", "sentence": "Starting.", "answer": "", "share": 0.0}
        with suppress(OSError, ValueError, TypeError):
            with (self.folder / EVENTS).open("rb") as stream:
                begun = b'"event": "started"' in stream.read(LAST_BYTES)
            if begun:  # until then the state is of an earlier run
                state = read_state(self.results)
                progress["sentence"] = describe(state, running=True)
                progress["share"] = state.done / state.clips if state.clips else 0.0
        return progress

    def answer(self) -> str:
        """The sentence of the results, "" if there are none."""
        with suppress(OSError, ValueError, KeyError, TypeError):
            if (self.results / REPORT).is_file():
                summary = json.loads((self.results / "summary.json").read_text(encoding="utf-8"))
                return summary["answer"]["sentence"]
        return ""

    def idle_s(self) -> float:
        """Seconds that the server ran since somebody last looked at the study; below 0 to keep it longer."""
        with suppress(OSError, ValueError):
            return float((self.folder / IDLE).read_text(encoding="ascii"))
        return 0.0

    def set_idle(self, seconds: float) -> None:
        if seconds != self.idle_s():
            write_text(self.folder / IDLE, f"{seconds:.6f}")


def checked_parameters(given: Any) -> dict[str, Any]:
    """Parameters from a request, as they are; a RefusedError says which is wrong."""
    if not isinstance(given, dict):
        raise RefusedError(400, "parameters are an object of names and values")
    given = {name: value for name, value in given.items() if value not in (None, "")}
    for name, value in given.items():
        kinds = PARAMETERS.get(name)
        if kinds is None:
            raise RefusedError(400, f"there is no parameter {name[:80]!r}, but {', '.join(PARAMETERS)}")
        if type(value) not in kinds or (isinstance(value, str) and not is_text(value)):
            raise RefusedError(400, f"{name} cannot be {str(value)[:80]!r}")
    if given.get("sensor", "ideal") not in PRESETS:
        raise RefusedError(400, f"sensor is one of {', '.join(PRESETS)}")
    with restated("", (ValueError, OSError), refused(400)):
        options = StudyOptions(**given)
        options.config()
        options.pose()
        for name in ("only", "forbid", "must"):
            for place in words(given.get(name, "")):
                find_patches(REGIONS, REGIONS, re.sub(r" \d\d+$", "", place))
    return given


def damaged(study: Study) -> dict[str, Any]:
    """What is shown of a study whose request cannot be read."""
    return {"id": study.id, "made": 0.0, "clips": 0, "state": "failed", "sentence": DAMAGED, "answer": ""}
