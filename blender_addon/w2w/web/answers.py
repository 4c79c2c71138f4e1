# SPDX-License-Identifier: GPL-3.0-or-later
"""Requests about a study's answer: choosing again, how cheap the sensor may be, files, sharing."""

import mimetypes
import os
import secrets
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from ..core.given import inside
from ..core.study.clip_files import WORK
from ..core.study.results import REPORT
from ..core.wording import restated
from ..headless.console import sentence_of
from .choosing import cheapest, choose_again, get_ready, pilot_by, report_again, report_needing, signals_of
from .guard import Doors, report_policy
from .receiving import Receiver, object_of, parsed, study_of
from .study import WISHES, Study, checked_parameters
from .uploads import PIECE, RefusedError, refused
from .work import Reader, Work

NO_RESULTS = "The study has no results yet: run it first"


class Answers:
    """The requests about what runs found, over the same work as the others."""

    def __init__(self, work: Work, doors: Doors) -> None:
        self.work, self.receiver = work, Receiver(work, doors.most)

    def routes(self) -> list[Route]:
        """All addresses below a study's that are of its answer."""
        one = "/api/studies/{id}"
        return [
            Route(f"{one}/share", self.share, methods=["POST"]),
            Route(f"{one}/share", self.unshare, methods=["DELETE"]),
            Route(f"{one}/place", self.place, methods=["POST"]),
            Route(f"{one}/need", self.need, methods=["POST"]),
            Route(f"{one}/pilot", partial(self.recorded, pilot_by), methods=["POST"]),
            Route(f"{one}/pilot/signals", partial(self.recorded, signals_of), methods=["POST"]),
            Route(f"{one}/results.zip", self.archive),
            Route(f"{one}/files/{{name:path}}", self.file),
        ]

    async def share(self, request: Request) -> Response:
        """Give the answer an address of its own, which shows it to whoever has it."""
        study = study_of(self.work, request)
        secret = study.request()["shared"] or secrets.token_urlsafe(16)
        study.change(shared=secret)
        return JSONResponse({"link": str(request.url_for("shared", link=f"{study.id}.{secret}"))})

    async def unshare(self, request: Request) -> Response:
        """Take the address back."""
        study_of(self.work, request).change(shared="")
        return JSONResponse({})

    async def place(self, request: Request) -> Response:
        study, wishes = study_of(self.work, request), await object_of(request)
        return JSONResponse(await self._choose(study, wishes, choose_again))

    async def need(self, request: Request) -> Response:
        """How cheap the sensor may be at places by name, or at those that the run recommends."""
        study, asked = study_of(self.work, request), await object_of(request)
        place = str(asked.get("place", ""))
        return JSONResponse({"needs": await self._worked(study, self.work.tryer, cheapest, place)})

    async def recorded(self, how: Callable[..., Any], request: Request) -> Response:
        """What a function makes of uploaded recordings, worn where the request says."""
        study = study_of(self.work, request)
        async with self.receiver.laid(request, study) as (folder, at, arrived):
            found = await self._worked(study, self.work.tryer, how, (folder, at))
            return JSONResponse(found | {"skipped": [*found["skipped"], *arrived.refused.items()]})

    async def _choose(
        self, study: Study, wishes: dict[str, Any], how: Callable[..., Any], worker: Reader | None = None
    ) -> Any:
        """What a function makes of a study's results and wishes, in a worker that remembers them."""
        if unknown := wishes.keys() - {*WISHES, "compare"}:
            raise RefusedError(400, f"there is no wish {min(unknown)[:80]!r}")
        given = {**dict.fromkeys(wishes, ""), **checked_parameters({**wishes, "compare": ""})}
        given["compare"] = str(wishes.get("compare", ""))
        return await self._worked(study, worker or self.work.chooser, how, given)

    async def _worked(self, study: Study, worker: Reader, how: Callable[..., Any], asked: Any) -> Any:
        if not study.answer() or self.work.waits(study):
            raise RefusedError(409, NO_RESULTS)
        with restated(
            lambda error: study.without_paths(sentence_of(error)), (ValueError, OSError), refused(400)
        ):
            found = await worker.ask(how, study.results, asked)
        if found is None:
            raise RefusedError(503, "There is too little memory to choose again")
        return found

    async def file(self, request: Request) -> Response:
        study, name = study_of(self.work, request), request.path_params["name"]
        with restated("There is no such file", ValueError, refused(404)):
            path = inside(study.results, name)
        if name.startswith(".") or not path.is_file():
            raise RefusedError(404, "There is no such file")
        if name == REPORT:
            return await self._report(study, dict(request.query_params))
        kind = mimetypes.guess_type(name)[0] if path.suffix in (".png", ".csv", ".json") else None
        return FileResponse(path, media_type=kind or "application/octet-stream", filename=path.name)

    async def _report(self, study: Study, wishes: dict[str, Any]) -> Response:
        """The report as the run wrote it, or under the wishes that the address gives, as JSON in `wishes`.

        With `need`, its first card says how cheap the sensor there may be.
        """
        if "wishes" in wishes:
            given = parsed(wishes["wishes"])
            how, worker = (report_needing, self.work.tryer) if "need" in wishes else (report_again, None)
            text = await self._choose(study, given if isinstance(given, dict) else {}, how, worker)
        else:
            text = (study.results / REPORT).read_text(encoding="utf-8")
            self.work.prepare(study.results, get_ready)
        return HTMLResponse(text, headers={"content-security-policy": report_policy(text)})

    async def archive(self, request: Request) -> Response:
        study = study_of(self.work, request)
        if not study.answer():
            raise RefusedError(409, NO_RESULTS)
        headers = {"content-disposition": f'attachment; filename="w2w-{study.id[:8]}.zip"'}
        return StreamingResponse(zipped(study.results), media_type="application/zip", headers=headers)


class _Pieces(bytearray):
    """What a zip has written and nobody has sent yet."""

    def write(self, data: bytes) -> int:
        self += data
        return len(data)

    def flush(self) -> None:
        """Keep all for the reader."""


def zipped(folder: Path) -> Iterator[bytes]:
    """A results folder as a zip, in pieces as they are made.

    Without what belongs to a process at work, and without links: they may lead out of the folder.
    """
    pieces = _Pieces()
    with ZipFile(pieces, "w") as archive:  # type: ignore[call-overload]
        for path in sorted(_files(folder)):
            name = path.relative_to(folder).as_posix()
            if name.startswith((f"{WORK}/lock", f"{WORK}/holder", f"{WORK}/running")):
                continue
            with path.open("rb") as stream, archive.open(name, "w", force_zip64=True) as member:
                while piece := stream.read(PIECE):
                    member.write(piece)
                    yield bytes(pieces)
                    pieces.clear()
    yield bytes(pieces)


def _files(folder: Path) -> Iterator[Path]:
    for place, _, names in os.walk(folder):
        paths = (Path(place, name) for name in names)
        yield from (path for path in paths if path.is_file() and not path.is_symlink())
