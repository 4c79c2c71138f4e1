# SPDX-License-Identifier: GPL-3.0-or-later
"""Uploads to a study: they arrive in a folder of their own, and move into the study once they are good."""

import asyncio
import json
import os
import secrets
import shutil
from collections import Counter
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path
from typing import Any

from starlette.datastructures import UploadFile
from starlette.requests import Request

from ..core.csv_tables import CsvError, read_table
from ..core.library.labels import COLUMNS
from ..core.library.library import LABELS
from ..core.wording import restated
from .clips import ARRIVING
from .request import INPUT
from .study import Study, checked_parameters
from .uploads import MOST_FILES, PIECE, Names, RefusedError, checked_name, given_name, refused, store, unpack
from .work import Work

MOST_AT_ONCE, MOST_UPLOADS, MOST_OF_ONE = 200, 64, 16
"""Files of a request, requests with files that are read at the same time, and those of one person."""

OF_ONE, IN_ALL = 3, 10
"""One person's studies, and all studies together, may take so many times what one may."""

MOST_LABELS = 10**6
"""Bytes of a labels.csv: a row for each file that a study may hold, and more."""

BUSY = "a run of the study was asked for meanwhile: cancel it, or send the files again when it has ended"


Items = list[tuple[str, UploadFile | str]]
"""Fields and files of a request, by the name of the field."""


class Arrived:
    """Files of one request that lie in a folder of their own, each with its name, and what was refused."""

    def __init__(self, study: Study) -> None:
        self.study, self.folder = study, study.folder / f"{ARRIVING}{secrets.token_hex(8)}"
        self.files: list[tuple[Path, str, str]] = []  # where it lies, its name as given, its sum
        self.refused: dict[str, str] = {}
        self.replaced: list[str] = []  # names of which another file was there

    def keep(self, value: UploadFile, name: str) -> None:
        """Store an uploaded file; a RefusedError says why it may not be."""
        checked_name(name)
        if name == LABELS and (value.size or 0) > MOST_LABELS:
            raise RefusedError(
                413, f"it is larger than {MOST_LABELS / 1e6:.0f} MB: a row for each file is enough"
            )
        path = self.folder / f"f{len(self.files)}"
        total = store(path, iter(lambda: value.file.read(PIECE), b""))
        if name == LABELS:
            _check_labels(path)
        self.files.append((path, name, total))

    def move(self) -> dict[str, str]:
        """Move all into the study, at once; returns their names as given by those on disk."""
        if not self.study.folder.joinpath(INPUT).is_dir():
            raise RefusedError(404, "the study was deleted meanwhile")
        request = self.study.request()
        names, moved, sums = Names(request["files"]), dict[str, str](), dict[str, str]()
        for path, name, total in self.files:
            if len(request["files"]) + len(moved) >= MOST_FILES and name not in request["files"].values():
                self.refused[name] = f"a study holds at most {MOST_FILES} files"
                continue
            own = names.own(name)
            place = self.study.folder / INPUT / own
            place.parent.mkdir(parents=True, exist_ok=True)
            path.replace(place)
            if {**request["sums"], **sums}.get(own, total) != total:
                self.replaced.append(name)
            moved[own], sums[own] = name, total
        kept = {} if LABELS in moved else request["judged"]  # they may give rates
        judged = {file: facts for file, facts in kept.items() if file not in moved}
        files, sums = {**request["files"], **moved}, {**request["sums"], **sums}
        self.study.change(files=files, judged=judged, sums=sums)
        return moved


def _check_labels(path: Path) -> None:
    with restated(lambda error: str(error).replace(str(path), LABELS), CsvError, refused(400)):
        read_table(path, *COLUMNS)


class Receiver:
    """Takes the files of requests, as far as there is room."""

    def __init__(self, work: Work, most: int) -> None:
        self.work, self.most = work, most
        self._arriving, self.of_one = Counter[Path](), Counter[str]()

    async def receive(self, request: Request, study: Study) -> dict[str, Any]:
        """Store a request's files in a study; what was taken, what was refused and why."""
        async with self._items(request, study) as items:
            return await self._take(items, study)

    @asynccontextmanager
    async def laid(self, request: Request, study: Study) -> AsyncIterator[tuple[Path, str, Arrived]]:
        """A request's recordings in a folder that lasts as long as the block, where worn, and what came.

        What a zip holds is in a folder called like it: apps export one for each recording.
        """
        async with self._items(request, study) as items, self._arrived(items, study, apart=True) as arrived:
            if not arrived.files:
                raise RefusedError(400, next(iter(arrived.refused.values()), "there is no file"))
            worn, names = arrived.folder / "worn", Names({})
            for path, name, _ in arrived.files:
                place = worn / names.own(name)
                place.parent.mkdir(parents=True, exist_ok=True)
                path.replace(place)
            yield worn, str(dict(items).get("at", "")), arrived

    @asynccontextmanager
    async def _items(self, request: Request, study: Study) -> AsyncIterator[Items]:
        """A request's fields and files, if not too many others are read."""
        owner = study.folder.parent.name
        if self.of_one.total() >= MOST_UPLOADS or (self.of_one[owner] >= MOST_OF_ONE and owner != "local"):
            raise RefusedError(503, "Too many uploads at once: try again in a moment")
        self.of_one[owner] += 1
        try:
            async with request.form(max_files=MOST_AT_ONCE, max_fields=8) as form:
                yield form.multi_items()
        finally:
            self.of_one[owner] -= 1

    async def _take(self, items: Items, study: Study) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for field, value in items:
            if not isinstance(value, UploadFile) and field == "parameters":
                found[field] = checked_parameters(parsed(value))
        async with self._arrived(items, study) as arrived:
            if arrived.files and study.waits:
                raise RefusedError(409, BUSY)
            study.note_answered()
            files = arrived.move() if arrived.files else {}
            return {"files": files, "refused": arrived.refused, "replaced": arrived.replaced, **found}

    @asynccontextmanager
    async def _arrived(self, items: Items, study: Study, apart: bool = False) -> AsyncIterator[Arrived]:
        """A request's files, in a folder that lasts as long as the block."""
        arrived = Arrived(study)
        try:
            await self._gather(items, study, arrived, apart)
            yield arrived
        finally:
            await asyncio.to_thread(shutil.rmtree, arrived.folder, ignore_errors=True)

    async def _gather(self, items: Items, study: Study, arrived: Arrived, apart: bool) -> None:
        """Store files as far as there is room; `apart`: what a zip holds in a folder called like it."""
        size = sum(value.size or 0 for _, value in items if isinstance(value, UploadFile))
        room = await self._room(study)
        self._arriving[study.folder] += size
        try:
            for field, value in items:
                if not isinstance(value, UploadFile):
                    continue
                name = LABELS if field == "labels" else given_name(value.filename or "")
                room -= value.size or 0
                try:
                    if room < 0:
                        raise RefusedError(413, "there is no room for it: delete files or studies first")
                    if name.lower().endswith(".zip"):
                        await self._unpack(value, arrived, room, name[:-4] if apart else "")
                    else:
                        await asyncio.to_thread(arrived.keep, value, name)
                except RefusedError as refusal:
                    arrived.refused[name[:80]] = str(refusal)
        finally:
            self._arriving[study.folder] -= size

    async def _room(self, study: Study) -> int:
        """Bytes that a study may still take, beside the others of its owner and of all."""
        owner, data, arriving = study.folder.parent, self.work.data, self._arriving
        here, own, all_ = [await asyncio.to_thread(folder_size, path) for path in (study.folder, owner, data)]
        room = min(self.most - here - arriving[study.folder], IN_ALL * self.most - all_ - arriving.total())
        if owner.name == "local":
            return room
        coming = sum(size for folder, size in arriving.items() if folder.parent == owner)
        return min(room, OF_ONE * self.most - own - coming)

    async def _unpack(self, value: UploadFile, arrived: Arrived, room: int, under: str = "") -> None:
        content = arrived.folder / f"z{len(arrived.files)}"
        archive = content.with_suffix(".zip")
        await asyncio.to_thread(store, archive, iter(lambda: value.file.read(PIECE), b""))
        got = await self.work.unpackers.of(archive).ask(unpack, archive, content, MOST_FILES, room)
        archive.unlink(missing_ok=True)
        if not isinstance(got, dict):
            raise RefusedError(400, got or "it takes long or much memory to unpack: send it in parts")
        if under and LABELS not in [name for _, name, _ in got["files"]]:
            got["files"] = [(number, f"{under}/{name}", total) for number, name, total in got["files"]]
        for number, name, total in got["files"]:
            try:
                if name == LABELS:
                    if (content / number).stat().st_size > MOST_LABELS:
                        raise RefusedError(413, f"it is larger than {MOST_LABELS / 1e6:.0f} MB")
                    await asyncio.to_thread(_check_labels, content / number)
                arrived.files.append((content / number, name, total))
            except RefusedError as refusal:
                arrived.refused[name] = str(refusal)
        arrived.refused |= got["refused"]


def folder_size(folder: Path) -> int:
    """Bytes of a folder's files; files and folders that go meanwhile do not count."""
    total = 0
    for path, _, names in os.walk(folder):  # which passes over a folder that has gone, as `rglob` does not
        for name in names:
            with suppress(OSError):
                total += Path(path, name).lstat().st_size
    return total


def parsed(text: str | bytes) -> Any:
    """The content of a JSON text; a RefusedError if it is none."""
    with restated("That is no JSON", (ValueError, RecursionError), refused(400)):
        return json.loads(text)


async def content_of(request: Request) -> Any:
    return parsed(await request.body())


async def object_of(request: Request) -> dict[str, Any]:
    given = await content_of(request)
    if not isinstance(given, dict):
        raise RefusedError(400, "That is no JSON object")
    return given


def study_of(work: Work, request: Request) -> Study:
    """The study that a request names, of the person who asks."""
    return Study.of(work.data / request.state.owner, request.path_params["id"])
