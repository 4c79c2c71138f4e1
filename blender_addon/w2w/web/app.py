# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app: its pages, and the interface for programs under /api."""

import asyncio
import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from operator import itemgetter
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartParser
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from ..core.imu.presets import PRESETS
from ..core.library.library import LABELS
from ..core.patches.body_parts import ALL, PARTS, PRODUCTS, SIDES
from ..core.ranking.f1 import FEWEST_CLIPS
from .answers import Answers
from .guard import Doors, Guard
from .receiving import Receiver, content_of, object_of, study_of
from .request import INPUT
from .shown import Pages, operates, operator_page
from .study import Study, checked_parameters, damaged
from .uploads import DISK_FULL, NO_DISK, SUFFIXES, RefusedError
from .work import DAY_S, Work

SPOOLED = 2**16
"""Bytes of an upload that wait in memory; more wait in a temporary file without a name."""

LOOK_EVERY_S = 0.5

BEAT_S = 15.0
"""Seconds without news after which a listener is told that the server lives."""


class App:
    """The requests that the app answers."""

    def __init__(self, work: Work, doors: Doors) -> None:
        self.work, self.doors, self.receiver = work, doors, Receiver(work, doors.most)

    def routes(self) -> list[Route]:
        """All addresses."""
        one = "/api/studies/{id}"
        return [
            Route("/operator", self.operate),
            Route("/api/about", self.about),
            Route("/api/studies", self.all, methods=["GET"]),
            Route("/api/studies", self.make, methods=["POST"]),
            Route(one, self.show, methods=["GET"]),
            Route(one, self.delete, methods=["DELETE"]),
            Route(f"{one}/files", self.add, methods=["POST"]),
            Route(f"{one}/labels", self.label, methods=["PUT"]),
            Route(f"{one}/parameters", self.wish, methods=["PUT"]),
            Route(f"{one}/run", self.run, methods=["POST"]),
            Route(f"{one}/cancel", self.cancel, methods=["POST"]),
            Route(f"{one}/keep", self.keep, methods=["POST"]),
            Route(f"{one}/events", self.events),
            Route(f"{one}/remove", self.remove, methods=["POST"]),
            Route(f"{one}/figure", self.figure),
        ]

    async def about(self, _: Request) -> Response:
        about: dict[str, Any] = {"sensors": [*PRESETS], "places": [*PRODUCTS, *ALL], "suffixes": SUFFIXES}
        about |= {"products": [*PRODUCTS], "parts": [*SIDES, *PARTS], "enough": FEWEST_CLIPS}
        return JSONResponse(about | {"most": self.doors.most, "clip_s": self.work.clip_s})

    async def operate(self, request: Request) -> Response:
        """The operator's page."""
        if not operates(self.doors, request.state.owner):
            raise RefusedError(403, "This page is for whoever runs the server: w2w serve --invite operator")
        return HTMLResponse(
            await asyncio.to_thread(operator_page, self.work, self.doors, dict(self.receiver.of_one))
        )

    async def all(self, request: Request) -> Response:
        folder, found = self._folder(request), []
        for study in (each for each in self.work.studies() if each.folder.parent == folder):
            with suppress(RefusedError):  # it was deleted meanwhile
                found.append(self._short(study))
        return JSONResponse(sorted(found, key=itemgetter("made"), reverse=True))

    async def make(self, request: Request) -> Response:
        """Make a study: empty, the demo, or with files, and run it if parameters are given."""
        kind = request.headers.get("content-type", "")
        given = await object_of(request) if kind.startswith("application/json") else {}
        study = Study.make(self._folder(request), demo=bool(given.get("demo")))
        try:
            found = {}
            if kind.startswith("multipart/form-data"):
                found = await self.receiver.receive(request, study)
            if "parameters" in found:
                await self._ask(study, found.pop("parameters"))
            else:
                self.work.judge(study)
        except BaseException:
            await self.work.delete(study)
            raise
        return JSONResponse(found | self._short(study), 201)

    async def show(self, request: Request) -> Response:
        study = self._study(request)
        asked = study.request()["parameters"]
        study.set_idle(min(study.idle_s(), 0.0))
        rows, problem = await asyncio.to_thread(study.table)
        if any(row["judged"] is None for row in rows) and not study.waits:
            self.work.judge(study)
        shown = {"table": rows, "problem": problem, "parameters": asked, "files": _files(study.results)}
        shown["link"] = ""
        if secret := study.request()["shared"]:
            shown["link"] = str(request.url_for("shared", link=f"{study.id}.{secret}"))
        shown["stale"] = await asyncio.to_thread(study.stale)
        return JSONResponse({**self._short(study), **shown, "days_left": self._days_left(study)})

    async def delete(self, request: Request) -> Response:
        await self.work.delete(self._study(request))
        return JSONResponse({})

    async def add(self, request: Request) -> Response:
        study = self._idle(request)
        found = await self.receiver.receive(request, study)
        found["said"] = await asyncio.to_thread(study.added, found["files"])
        self.work.judge(study)
        return JSONResponse(found, 201 if found["files"] else 400)

    async def label(self, request: Request) -> Response:
        study, rows = self._idle(request), await content_of(request)
        study.note_answered()
        await asyncio.to_thread(study.label, rows)
        return JSONResponse({"stale": await asyncio.to_thread(study.stale)})

    async def wish(self, request: Request) -> Response:
        """Keep wishes for the next run as they are typed."""
        study, given = self._idle(request), await content_of(request)
        study.note_answered()
        study.change(parameters=checked_parameters(given))
        return JSONResponse({"stale": await asyncio.to_thread(study.stale)})

    async def run(self, request: Request) -> Response:
        study = self._idle(request)
        await self._ask(study, await content_of(request))
        return JSONResponse(self._short(study), 202)

    async def cancel(self, request: Request) -> Response:
        study = self._study(request)
        await self.work.cancel(study)
        return JSONResponse(self._short(study))

    async def keep(self, request: Request) -> Response:
        """Keep a study for as long again after the last visit."""
        study = self._study(request)
        study.set_idle(-self.work.keep_s)
        return JSONResponse({"days_left": self._days_left(study)})

    async def events(self, request: Request) -> Response:
        study = self._study(request)

        async def told() -> AsyncIterator[str]:
            before, quiet = None, 0.0
            while (study.folder / INPUT).exists():
                if (now := self._short(study)) != before or quiet > BEAT_S:
                    yield f"data: {json.dumps(now)}\n\n"
                    quiet = 0.0
                if now["state"] not in ("queued", "running"):
                    return
                before, quiet = now, quiet + LOOK_EVERY_S
                await asyncio.sleep(LOOK_EVERY_S)

        return StreamingResponse(told(), media_type="text/event-stream")

    async def remove(self, request: Request) -> Response:
        """Delete files of a study."""
        study, given = self._idle(request), await content_of(request)
        if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
            raise RefusedError(400, "what to delete is a list of files")
        study.note_answered()
        study.remove(given)
        return JSONResponse({})

    async def figure(self, request: Request) -> Response:
        """The small picture of a clip's motion."""
        study, file = self._study(request), request.query_params.get("file", "")
        path = study.figure_of(file)
        if not path.is_file():
            await self.work.draw(study, file)
        if not path.is_file():
            raise RefusedError(404, "There is no picture of it")
        return FileResponse(path, headers={"cache-control": "private, max-age=86400"})

    def _folder(self, request: Request) -> Path:
        return self.work.data / request.state.owner

    def _study(self, request: Request) -> Study:
        return study_of(self.work, request)

    def _idle(self, request: Request) -> Study:
        """The request's study, which no run is using."""
        study = self._study(request)
        if self.work.waits(study):
            raise RefusedError(409, "The study is running: cancel it first, or wait")
        return study

    async def _ask(self, study: Study, parameters: Any) -> None:
        """Ask for a study's run, unless somebody else has done so meanwhile."""
        changes = await asyncio.to_thread(study.checked, parameters)
        if self.work.waits(study):
            raise RefusedError(409, "The study is running: cancel it first, or wait")
        study.ask(changes)
        self.work.run(study)

    def _short(self, study: Study) -> dict[str, Any]:
        try:
            request = study.request()
        except RefusedError as error:
            if error.status == 404:
                raise
            return damaged(study)
        files = [file for file in request["files"] if file != LABELS]
        facts = {"id": study.id, "made": request["made"], "clips": len(files)}
        facts["title"] = request["parameters"].get("title", "")
        progress = study.progress(study.id in self.work.running, self.work.queue.before(study))
        if (problem := self.work.failed(study)) and study.waits:
            progress = {"state": "failed", "sentence": problem, "answer": study.answer()}
        return facts | progress

    def _days_left(self, study: Study) -> float:
        """Days that the study is kept from now on if nobody looks at it."""
        return round((self.work.keep_s - study.idle_s()) / DAY_S, 2)


def _files(results: Path) -> list[str]:
    """Names of the result files that people open: tables, pictures, report, Blender file."""
    paths = [*results.glob("*"), *results.glob("heatmaps/*")]
    names = (path.relative_to(results).as_posix() for path in paths if path.is_file())
    return sorted(name for name in names if not name.startswith("."))


async def _say(_: Request, error: Exception) -> Response:
    """The answer to a request that is refused."""
    if isinstance(error, ClientDisconnect):
        error = RefusedError(400, "The connection broke before all of it was here")
    if isinstance(error, OSError) and error.errno in DISK_FULL:
        error = RefusedError(507, NO_DISK[0].upper() + NO_DISK[1:])
    if isinstance(error, HTTPException):
        return JSONResponse({"problem": error.detail}, error.status_code)
    status = error.status if isinstance(error, RefusedError) else 500
    sentence = (
        str(error) if isinstance(error, RefusedError) else "That failed: its reason is in the server's log"
    )
    return JSONResponse({"problem": sentence}, status)


def web_app(work: Work, doors: Doors) -> Starlette:
    """The app over a data folder's work."""
    MultiPartParser.spool_max_size = SPOOLED

    @asynccontextmanager
    async def at_work(_: Starlette) -> AsyncIterator[None]:
        work.start()
        yield
        await work.stop()

    app = Starlette(
        routes=[route for each in (Pages, App, Answers) for route in each(work, doors).routes()],
        middleware=[Middleware(Guard, doors=doors)],
        exception_handlers=dict.fromkeys(
            (RefusedError, ClientDisconnect, HTTPException, OSError, Exception), _say
        ),
        lifespan=at_work,
    )
    app.state.work = work
    return app
