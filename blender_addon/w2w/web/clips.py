# SPDX-License-Identifier: GPL-3.0-or-later
"""The clips of a study of the web app and their labels: the study's list says which, never its folder."""

import csv
import hashlib
import io
import json
from collections.abc import Collection
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple, TypeGuard

from ..core.files import write_text
from ..core.library.labels import LibraryError, read_labels, spelled_once
from ..core.library.library import LABELS, Library, activity_of, as_label, read_library
from ..core.readers.animations import contents, telling_part
from ..core.reading.formats import is_motion
from ..core.wording import clean, count, restated
from .request import INPUT, Requested
from .uploads import MOST_NAME, RefusedError, refused

COLUMNS = ("file", "activity", "subject", "source", "motion_key", "rate")

FIGURES = "figures"

ARRIVING = "arriving."
"""Beginning of the names of folders for uploads that are not known to be good yet."""


class Given(NamedTuple):
    """A clip's file, its name as it was given, and what an animation says by its own name."""

    file: str
    name: str
    own: str


@dataclass(frozen=True)
class Labelled(Requested):
    """A study's clips and their labels: the table's once it was edited, else those that came with them."""

    @property
    def edited(self) -> Path:
        """The table's labels, a csv of names on disk, if it was ever edited."""
        return self.folder / LABELS

    def library(self) -> Library:
        """The study's clips as its run finds them; a RefusedError if there are none."""
        with restated(lambda error: self.without_paths(str(error)), LibraryError, refused(400)):
            return read_library(self.folder / INPUT, self.edited if self.edited.exists() else None)

    def clips(self) -> dict[str, Given]:
        """All clips by their names on disk, an animation's below its file's, in the order of given names."""
        files, folder = self.request()["files"], self.folder / INPUT
        motions = [(folder / file, file) for file in sorted(files, key=lambda file: files[file])]
        found = {}
        for item in contents((path, file) for path, file in motions if is_motion(path)):
            clip, file = clean(item.file), item.pack or item.file
            found[clip] = Given(file, f"{files[file]}{clip[len(file) :]}", telling_part(item.animation))
        return found

    def came_with(self) -> dict[str, dict[str, Any]]:
        """Labels by clip as a run of the same files finds them: from labels.csv, else from names as given.

        A LibraryError says what is wrong with labels.csv.
        """
        files, clips = self.request()["files"], self.clips()
        if LABELS not in files:
            texts = {
                clip: as_label(one.own) if one.own else activity_of(one.name) for clip, one in clips.items()
            }
            return spelled_once(
                {clip: {"activity": text} for clip, text in texts.items() if text}, form=as_label
            )[0]
        inside = dict.fromkeys(
            [*(one.name for one in clips.values()), *(files[one.file] for one in clips.values())]
        )
        rows, _ = read_labels(self.folder / INPUT / LABELS, self.folder / INPUT, [*inside])
        found = {clip: rows.get(one.name) or rows.get(files[one.file]) for clip, one in clips.items()}
        return {clip: row for clip, row in found.items() if row}

    def labels(self) -> dict[str, dict[str, Any]]:
        """Labels by clip: those of the table, else those that came with the clips."""
        if not self.edited.exists():
            return self.came_with()
        with self.edited.open(encoding="utf-8", newline="") as stream:
            rows: dict[str, dict[str, Any]] = {row["file"]: dict(row) for row in csv.DictReader(stream)}
        return spelled_once({clip: row for clip, row in rows.items() if row.get("activity")})[0]

    def rates(self) -> dict[str, float]:
        """The frame rates that labels give to clips."""
        with suppress(LibraryError):
            return {clip: float(row.get("rate") or 0) for clip, row in self.came_with().items()}
        return {}

    def table(self) -> tuple[list[dict[str, Any]], str]:
        """A row for each clip, with its labels and what is known of it, and what is wrong with all labels."""
        request, problem = self.request(), ""
        labels: dict[str, dict[str, Any]] = {}
        try:
            labels = self.labels()
        except LibraryError as error:
            problem = self.without_paths(str(error))
        rows, first = [], dict[str, str]()
        for clip, one in self.clips().items():
            row = labels.get(clip)
            found = {"activity": row["activity"], "subject": row.get("subject", "")} if row else {}
            same = first.setdefault(request["sums"].get(one.file) or one.file, one.file)
            found |= {} if same == one.file else {"copy_of": request["files"][same]}
            rows.append({"file": clip, "name": one.name, "judged": request["judged"].get(one.file), **found})
        return rows, problem

    def label(self, rows: Any) -> None:
        """Take labels of the table: rows of file, activity ("" leaves the clip out) and subject."""
        clips, own = {*self.request()["files"], *self.clips()}, {}
        with suppress(LibraryError):
            own = self.came_with()
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows if isinstance(rows, list) else [None]:
            cells = [row.get(name, "") for name in COLUMNS[:3]] if isinstance(row, dict) else []
            texts = [cell for cell in cells if is_text(cell)]
            if len(texts) != 3 or texts[0] not in clips:
                raise RefusedError(400, "labels are rows of a file of the study, activity and subject")
            more = own.get(texts[0], {})
            writer.writerow((*texts, *(more.get(name) or "" for name in COLUMNS[3:])))
        write_text(self.edited, stream.getvalue())

    def figure_of(self, file: str) -> Path:
        """Where the small picture of a file's motion is kept."""
        return self.folder / FIGURES / f"{hashlib.sha256(file.encode()).hexdigest()[:32]}.json"

    def keep_figure(self, file: str, figure: list[list[int]]) -> None:
        """Keep the small picture of a file's motion."""
        (self.folder / FIGURES).mkdir(exist_ok=True)
        write_text(self.figure_of(file), json.dumps(figure, separators=(",", ":")))

    def remove(self, given: Collection[str]) -> None:
        """Take files out of the study's list, by the names of their clips on disk; they are deleted."""
        clips, request = self.clips(), self.request()
        gone = {clips[clip].file for clip in given if clip in clips}
        kept = {
            name: {file: value for file, value in request[name].items() if file not in gone}
            for name in ("files", "judged", "sums")
        }
        rows = [row for row in self.table()[0] if clips[row["file"]].file not in gone]
        self.change(**kept)
        if self.edited.exists():
            self.label(rows)
        self.sweep()

    def added(self, files: Collection[str]) -> str:
        """Label new files in a table that was edited before; a sentence says where labels.csv went over it.

        New clips get the labels that they came with. A labels.csv goes over the edits of clips that it names.
        """
        if not self.edited.exists() or not files:
            return ""
        try:
            own, clips = self.came_with(), self.clips()
        except LibraryError as error:
            return self.without_paths(str(error))
        new = (
            own if LABELS in files else {clip: row for clip, row in own.items() if clips[clip].file in files}
        )
        kept = [row for row in self.table()[0] if row["file"] not in new]
        self.label([*kept, *({**row, "file": clip} for clip, row in new.items())])
        if LABELS not in files:
            return ""
        rest = f"; {count('other clip', len(kept))} kept what you typed" if kept else ""
        return f"labels.csv labelled {count('clip', len(new))}, over what was typed for them{rest}."

    def settle_labels(self) -> None:
        """Write the labels down if a run would read others from the names on disk."""
        if not self.edited.exists() and any(own != name for own, name in self.request()["files"].items()):
            with suppress(LibraryError):
                labels = self.labels()
                self.label(
                    [{**row, "file": clip, "subject": row.get("subject", "")} for clip, row in labels.items()]
                )

    def sweep(self) -> None:
        """Remove what the list does not name: pieces of uploads that a killed server left."""
        folder, listed = self.folder / INPUT, self.request()["files"]
        for path in folder.rglob("*"):
            if not path.is_dir() and path.relative_to(folder).as_posix() not in listed:
                path.unlink(missing_ok=True)

    def sums(self, parameters: dict[str, Any] | None = None) -> dict[str, str]:
        """What the answer of a run depends on: a sum of the clips, of their labels and of what is asked."""
        request = self.request()
        labels = []
        with suppress(LibraryError):
            labels = sorted(
                (clip, row["activity"], row.get("subject", "")) for clip, row in self.labels().items()
            )
        files = sorted((file, request["sums"].get(file, "")) for file in request["files"] if file != LABELS)
        parts = {
            "clips": files,
            "labels": labels,
            "wishes": request["parameters"] if parameters is None else parameters,
        }
        return {
            name: hashlib.sha256(json.dumps(part, sort_keys=True).encode()).hexdigest()
            for name, part in parts.items()
        }


def is_text(value: object) -> TypeGuard[str]:
    return isinstance(value, str) and len(value) <= MOST_NAME and value.isprintable()
