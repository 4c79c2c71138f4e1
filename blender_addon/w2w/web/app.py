# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app: its pages, and the interface for programs under /api."""

import asyncio
import json
import mimetypes
import secrets
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
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
from ..core.inside import inside
from ..core.library.library import LABELS
from ..core.patches.body_parts import ALL, PARTS, PRODUCTS, SIDES
from ..core.ranking.f1 import FEWEST_CLIPS
from ..headless.commands.place import FIGURES
from ..headless.console import sentence_of
from ..report.page import REPORT
from .archive import zipped
from .choosing import WORDS, choose_again, get_ready, report_again
from .guard import Doors, Guard, report_policy
from .receiving import Receiver, parsed
from .request import INPUT
from .shown import Pages
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
            Route(f"{one}/share", self.share, methods=["POST"]),
            Route(f"{one}/share", self.unshare, methods=["DELETE"]),
            Route(f"{one}/place", self.place, methods=["POST"]),
            Route(f"{one}/results.zip", self.archive),
            Route(f"{one}/files/{{name:path}}", self.file),
        ]

    async def about(self, _: Request) -> Response:
        about: dict[str, Any] = {"sensors": [*PRESETS], "places": [*PRODUCTS, *ALL], "suffixes": SUFFIXES}
        about |= {"products": [*PRODUCTS], "parts": [*SIDES, *PARTS], "enough": FEWEST_CLIPS}
        return JSONResponse(about | {"most": self.doors.most, "clip_s": self.work.clip_s})

    async def all(self, request: Request) -> Response:
        folder = self._folder(request)
        found = [self._short(study) for study in self.work.studies() if study.folder.parent == folder]
        return JSONResponse(sorted(found, key=itemgetter("made"), reverse=True))

    async def make(self, request: Request) -> Response:
        """Make a study: empty, the demo, or with files, and run it if parameters are given."""
        kind = request.headers.get("content-type", "")
        given = await _object(request) if kind.startswith("application/json") else {}
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
        study, rows = self._idle(request), await _json(request)
        study.note_answered()
        await asyncio.to_thread(study.label, rows)
        return JSONResponse({"stale": await asyncio.to_thread(study.stale)})

    async def wish(self, request: Request) -> Response:
        """Keep wishes for the next run as they are typed."""
        study, given = self._idle(request), await _json(request)
        study.note_answered()
        study.change(parameters=checked_parameters(given))
        return JSONResponse({"stale": await asyncio.to_thread(study.stale)})

    async def run(self, request: Request) -> Response:
        study = self._idle(request)
        await self._ask(study, await _json(request))
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
        study, given = self._idle(request), await _json(request)
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

    async def share(self, request: Request) -> Response:
        """Give the answer an address of its own, which shows it to whoever has it."""
        study = self._study(request)
        secret = study.request()["shared"] or secrets.token_urlsafe(16)
        study.change(shared=secret)
        return JSONResponse({"link": str(request.url_for("shared", link=f"{study.id}.{secret}"))})

    async def unshare(self, request: Request) -> Response:
        """Take the address back."""
        self._study(request).change(shared="")
        return JSONResponse({})

    async def place(self, request: Request) -> Response:
        study, wishes = self._study(request), await _object(request)
        return JSONResponse(await self._choose(study, wishes, choose_again))

    async def _choose(self, study: Study, wishes: dict[str, Any], how: Callable[..., Any]) -> Any:
        """What a function makes of a study's results and wishes, in the worker that remembers them."""
        if not study.answer() or self.work.waits(study):
            raise RefusedError(409, "The study has no results yet: run it first")
        if unknown := wishes.keys() - {*FIGURES, *WORDS, "compare"}:
            raise RefusedError(400, f"there is no wish {min(unknown)[:80]!r}")
        given = {**dict.fromkeys(wishes, ""), **checked_parameters({**wishes, "compare": ""})}
        given["compare"] = str(wishes.get("compare", ""))
        try:
            chosen = await self.work.chooser.ask(how, study.results, given)
        except (ValueError, OSError) as error:
            raise RefusedError(400, study.shown(sentence_of(error))) from error
        if chosen is None:
            raise RefusedError(503, "There is too little memory to choose again")
        return chosen

    async def file(self, request: Request) -> Response:
        study, name = self._study(request), request.path_params["name"]
        try:
            path = inside(study.results, name)
        except ValueError as error:
            raise RefusedError(404, "There is no such file") from error
        if name.startswith(".") or not path.is_file():
            raise RefusedError(404, "There is no such file")
        if name == REPORT:
            return await self._report(study, dict(request.query_params))
        kind = mimetypes.guess_type(name)[0] if path.suffix in (".png", ".csv", ".json") else None
        return FileResponse(path, media_type=kind or "application/octet-stream", filename=path.name)

    async def _report(self, study: Study, wishes: dict[str, Any]) -> Response:
        """The report as the run wrote it, or under the wishes that the address gives, as JSON in `wishes`."""
        if "wishes" in wishes:
            given = parsed(wishes["wishes"])
            text = await self._choose(study, given if isinstance(given, dict) else {}, report_again)
        else:
            text = (study.results / REPORT).read_text(encoding="utf-8")
            self.work.prepare(study.results, get_ready)
        return HTMLResponse(text, headers={"content-security-policy": report_policy(text)})

    async def archive(self, request: Request) -> Response:
        study = self._study(request)
        if not study.answer():
            raise RefusedError(409, "The study has no results yet: run it first")
        headers = {"content-disposition": f'attachment; filename="w2w-{study.id[:8]}.zip"'}
        return StreamingResponse(zipped(study.results), media_type="application/zip", headers=headers)

    def _folder(self, request: Request) -> Path:
        return self.work.data / request.state.owner

    def _study(self, request: Request) -> Study:
        return Study.of(self._folder(request), request.path_params["id"])

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
        except RefusedError:
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


async def _json(request: Request) -> Any:
    return parsed(await request.body())


async def _object(request: Request) -> dict[str, Any]:
    given = await _json(request)
    if not isinstance(given, dict):
        raise RefusedError(400, "That is no JSON object")
    return given


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
        routes=[*Pages(work, doors).routes(), *App(work, doors).routes()],
        middleware=[Middleware(Guard, doors=doors)],
        exception_handlers=dict.fromkeys(
            (RefusedError, ClientDisconnect, HTTPException, OSError, Exception), _say
        ),
        lifespan=at_work,
    )
    app.state.work = work
    return app
