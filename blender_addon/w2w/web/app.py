# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app: its pages, and the interface for programs under /api."""

import asyncio
import json
import mimetypes
import secrets
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from functools import lru_cache
from html import escape
from operator import itemgetter
from pathlib import Path
from typing import Any
from zipfile import ZipFile

from starlette.applications import Starlette
from starlette.datastructures import UploadFile
from starlette.exceptions import HTTPException
from starlette.formparsers import MultiPartParser
from starlette.middleware import Middleware
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import Route

from ..core.findings.advice_content import advice_content, place_content
from ..core.imu.presets import PRESETS
from ..core.inside import inside
from ..core.library.library import LABELS
from ..core.patches.body_parts import ALL, PRODUCTS
from ..core.ranking.stream import Stream
from ..core.selection.joint import grow_unwished
from ..core.selection.set_tests import SetTests
from ..core.study.choosing import advised, advised_by, compared, prepared_tests, ranked_again, stream_in
from ..core.study.clip_files import WORK
from ..core.study.results import StudyResults
from ..headless.commands.place import FIGURES, Wishes
from ..headless.options import words
from ..report.page import PAGE, REPORT
from .guard import Doors, Guard, report_policy
from .study import INPUT, Study, checked_parameters
from .uploads import MOST_FILES, PIECE, SUFFIXES, RefusedError, own_name, store, unpack
from .work import Work

PAGES = Path(__file__).resolve().parent / "pages"

MOST_AT_ONCE, MOST_UPLOADS = 200, 4
"""Files of a request, and requests with files that are read at the same time."""

IN_ALL = 10
"""All studies together may take so many times what one may."""

SPOOLED = 2**16
"""Bytes of an upload that wait in memory; more wait in a temporary file without a name."""

LOOK_EVERY_S = 0.5

PICTURE = "heatmaps/mean.png"

WORDS = "only", "forbid", "must", "background"
"""Wishes that `place` takes besides figures."""


class App:
    """The requests that the app answers."""

    def __init__(self, work: Work, most: int) -> None:
        self.work, self.most = work, most
        self._uploads, self._keeping = asyncio.Semaphore(MOST_UPLOADS), asyncio.Lock()

    def routes(self) -> list[Route]:
        """All addresses."""
        one = "/api/studies/{id}"
        return [
            Route("/", self.page),
            Route("/studies/{id}", self.page),
            Route("/static/{name}", self.static),
            Route("/api", self.static),
            Route("/api/about", self.about),
            Route("/api/studies", self.all, methods=["GET"]),
            Route("/api/studies", self.make, methods=["POST"]),
            Route(one, self.show, methods=["GET"]),
            Route(one, self.delete, methods=["DELETE"]),
            Route(f"{one}/files", self.add, methods=["POST"]),
            Route(f"{one}/labels", self.label, methods=["PUT"]),
            Route(f"{one}/run", self.run, methods=["POST"]),
            Route(f"{one}/cancel", self.cancel, methods=["POST"]),
            Route(f"{one}/events", self.events),
            Route(f"{one}/place", self.place, methods=["POST"]),
            Route(f"{one}/results.zip", self.archive),
            Route(f"{one}/files/{{name:path}}", self.file),
        ]

    async def page(self, request: Request) -> Response:
        """The page; that of a study with its sentence and picture for whoever shows a preview of the link."""
        text = (PAGES / "index.html").read_text(encoding="utf-8")
        with suppress(RefusedError, KeyError):
            study = Study.of(self._folder(request), request.path_params["id"])
            if sentence := study.answer():
                picture = request.url_for("file", id=study.id, name=PICTURE)
                facts = {
                    "title": "Where to wear",
                    "description": sentence,
                    "url": request.url,
                    "image": picture,
                }
                metas = (
                    f'<meta property="og:{name}" content="{escape(str(fact))}">\n'
                    for name, fact in facts.items()
                )
                text = text.replace("</head>", f"{''.join(metas)}</head>")
        return HTMLResponse(text)

    async def static(self, request: Request) -> Response:
        name = request.path_params.get("name", "openapi.json")
        folder = {"app.js": PAGES, "app.css": PAGES, "openapi.json": PAGES, "style.css": PAGE}.get(name)
        if folder is None:
            raise RefusedError(404, "There is no such page")
        return FileResponse(folder / name)

    async def about(self, _: Request) -> Response:
        places = [*PRODUCTS, *ALL]
        return JSONResponse(
            {"sensors": [*PRESETS], "places": places, "suffixes": SUFFIXES, "most": self.most}
        )

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
            found = await self._receive(request, study) if kind.startswith("multipart/form-data") else {}
            if "parameters" in found:
                study.ask(found.pop("parameters"))
                self.work.run(study)
            else:
                self.work.judge(study)
        except BaseException:
            await self.work.delete(study)
            raise
        return JSONResponse(found | self._short(study), 201)

    async def show(self, request: Request) -> Response:
        study = self._study(request)
        rows, problem = await asyncio.to_thread(study.table)
        if any(row["judged"] is None for row in rows) and not study.waits:
            self.work.judge(study)
        asked = {"parameters": study.request()["parameters"], "files": _files(study.results)}
        return JSONResponse({**self._short(study), "table": rows, "problem": problem, **asked})

    async def delete(self, request: Request) -> Response:
        await self.work.delete(self._study(request))
        return JSONResponse({})

    async def add(self, request: Request) -> Response:
        study = self._idle(request)
        found = await self._receive(request, study)
        study.added(found["files"])
        self.work.judge(study)
        return JSONResponse(found, 201 if found["files"] else 400)

    async def label(self, request: Request) -> Response:
        study = self._idle(request)
        study.label(await _json(request))
        return JSONResponse({})

    async def run(self, request: Request) -> Response:
        study = self._idle(request)
        study.ask(await _json(request))
        self.work.run(study)
        return JSONResponse(self._short(study), 202)

    async def cancel(self, request: Request) -> Response:
        study = self._study(request)
        await self.work.cancel(study)
        return JSONResponse(self._short(study))

    async def events(self, request: Request) -> Response:
        study = self._study(request)

        async def told() -> AsyncIterator[str]:
            before = None
            while (study.folder / INPUT).exists():
                if (now := self._short(study)) != before:
                    yield f"data: {json.dumps(now)}\n\n"
                if now["state"] not in ("queued", "running"):
                    return
                before = now
                await asyncio.sleep(LOOK_EVERY_S)

        return StreamingResponse(told(), media_type="text/event-stream")

    async def place(self, request: Request) -> Response:
        study, wishes = self._study(request), await _object(request)
        if not study.answer() or study.waits:
            raise RefusedError(409, "The study has no results yet: run it first")
        if unknown := wishes.keys() - {*FIGURES, *WORDS, "compare"}:
            raise RefusedError(400, f"there is no wish {min(unknown)[:80]!r}")
        given = {**dict.fromkeys(wishes, ""), **checked_parameters({**wishes, "compare": ""})}
        given["compare"] = str(wishes.get("compare", ""))
        try:
            chosen = await self.work.chooser.ask(choose_again, study.results, given)
        except (ValueError, OSError) as error:
            raise RefusedError(400, study.shown(str(error))) from error
        if chosen is None:
            raise RefusedError(503, "There is too little memory to choose again")
        return JSONResponse(chosen)

    async def file(self, request: Request) -> Response:
        study, name = self._study(request), request.path_params["name"]
        try:
            path = inside(study.results, name)
        except ValueError as error:
            raise RefusedError(404, "There is no such file") from error
        if name.startswith(".") or not path.is_file():
            raise RefusedError(404, "There is no such file")
        if name == REPORT:
            self.work.prepare(study.results, get_ready)
            return FileResponse(path, headers={"content-security-policy": report_policy()})
        kind = mimetypes.guess_type(name)[0] if path.suffix in (".png", ".csv", ".json") else None
        return FileResponse(path, media_type=kind or "application/octet-stream", filename=path.name)

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
        if study.waits:
            raise RefusedError(409, "The study is running: cancel it first, or wait")
        return study

    def _short(self, study: Study) -> dict[str, Any]:
        request = study.request()
        facts = {"id": study.id, "made": request["made"], "clips": len(request["files"])}
        return facts | study.progress(study.id in self.work.running)

    async def _receive(self, request: Request, study: Study) -> dict[str, Any]:
        """Store a request's files in a study; what was taken, what was refused and why."""
        files: dict[str, str] = {}
        refused: dict[str, str] = {}
        found: dict[str, Any] = {"files": files, "refused": refused}
        form_read = request.form(max_files=MOST_AT_ONCE, max_fields=8)
        async with self._uploads, form_read as form, self._keeping:
            here, all_ = [await asyncio.to_thread(_size, path) for path in (study.folder, self.work.data)]
            room = min(self.most - here, IN_ALL * self.most - all_)
            for field, value in form.multi_items():
                if not isinstance(value, UploadFile):
                    if field == "parameters":
                        found[field] = checked_parameters(_parsed(value))
                    continue
                name = LABELS if field == "labels" else value.filename or ""
                room -= value.size or 0
                try:
                    if room < 0:
                        raise RefusedError(413, "there is no room for it: delete files or studies first")
                    if name.lower().endswith(".zip"):
                        await self._unpack(value, study, found, room)
                    else:
                        own = await asyncio.to_thread(_keep, value, name, study)
                        _note(study, {own: name})
                        files[own] = name
                except RefusedError as refusal:
                    refused[name[:80]] = str(refusal)
        return found

    async def _unpack(self, value: UploadFile, study: Study, found: dict[str, Any], room: int) -> None:
        archive = study.folder / f"{secrets.token_hex(8)}.zip"
        try:
            await asyncio.to_thread(store, archive, iter(lambda: value.file.read(PIECE), b""))
            known = study.request()["files"]
            got = await self.work.reader.ask(unpack, archive, study.folder / INPUT, known, room)
        finally:
            archive.unlink(missing_ok=True)
        if not isinstance(got, dict):
            raise RefusedError(400, got or "it takes too long or too much memory to unpack")
        _note(study, got["files"])
        found["files"] |= got["files"]
        found["refused"] |= got["refused"]


def _keep(value: UploadFile, name: str, study: Study) -> str:
    """Store an uploaded file under the server's own name, which is returned."""
    files = study.request()["files"]
    own = own_name(name, files)
    if len(files) >= MOST_FILES and own not in files:
        raise RefusedError(413, f"a study holds at most {MOST_FILES} files")
    store(study.folder / INPUT / own, iter(lambda: value.file.read(PIECE), b""))
    return own


def _note(study: Study, files: dict[str, str]) -> None:
    """Add files to a study's list; one that came again is judged again, all if labels came."""
    request = study.request()
    kept = {} if LABELS in files else request["judged"]  # they may give rates
    judged = {file: facts for file, facts in kept.items() if file not in files}
    study.change(files={**request["files"], **files}, judged=judged)


def _size(folder: Path) -> int:
    """Bytes of all files in a folder."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def _files(results: Path) -> list[str]:
    """Names of the result files that people open: tables, pictures, report, Blender file."""
    paths = [*results.glob("*"), *results.glob("heatmaps/*")]
    names = (path.relative_to(results).as_posix() for path in paths if path.is_file())
    return sorted(name for name in names if not name.startswith("."))


def _parsed(text: str | bytes) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise RefusedError(400, "That is no JSON") from error


async def _json(request: Request) -> Any:
    return _parsed(await request.body())


async def _object(request: Request) -> dict[str, Any]:
    given = await _json(request)
    if not isinstance(given, dict):
        raise RefusedError(400, "That is no JSON object")
    return given


@lru_cache(maxsize=1)
def _opened(
    out: Path,
    written: int,  # noqa: ARG001
) -> tuple[StudyResults, SetTests | None, Stream | None, dict[int, int]]:
    """A results folder as it was `written`, with tests, stream and turns that remember: seconds to make."""
    study = StudyResults.load(out)
    config = study.config()
    return study, prepared_tests(study, config), stream_in(study, config), {}


def get_ready(out: Path) -> None:
    """Choose as the run did, and find what other wishes need, too."""
    choose_again(out, {"compare": ""})
    tests = _opened(out, (out / "summary.json").stat().st_mtime_ns)[1]
    if tests:
        grow_unwished(tests)


def choose_again(out: Path, wishes: dict[str, Any]) -> dict[str, Any]:
    """What `w2w place` would choose, or compare, in a results folder; "" takes back a wish of the run."""
    study, tests, stream, turned = _opened(out, (out / "summary.json").stat().st_mtime_ns)
    if wishes["compare"]:
        scores = compared(study, words(wishes["compare"]))
        return {"compared": [place_content(score, study.patches) for score in scores]}
    figures = {name: wishes.get(name) or None for name in FIGURES}
    config = Wishes(**figures, **{name: wishes.get(name) for name in WORDS}).over(study)
    again = ranked_again(study, config)
    same = again.utility is study.utility
    advice = advised_by(study, config, tests, stream, turned) if same else advised(again, config)
    return advice_content(advice, again.utility, again.patches)


class _Pieces(bytearray):
    """What a zip has written and nobody has sent yet."""

    def write(self, data: bytes) -> int:
        self += data
        return len(data)

    def flush(self) -> None:
        """Keep all for the reader."""


def zipped(folder: Path) -> Iterator[bytes]:
    """A results folder as a zip, in pieces as they are made; without what belongs to a process at work."""
    pieces = _Pieces()
    with ZipFile(pieces, "w") as archive:  # type: ignore[call-overload]
        for path in sorted(path for path in folder.rglob("*") if path.is_file()):
            name = path.relative_to(folder).as_posix()
            if name.startswith((f"{WORK}/lock", f"{WORK}/holder", f"{WORK}/running")):
                continue
            with path.open("rb") as stream, archive.open(name, "w", force_zip64=True) as member:
                while piece := stream.read(PIECE):
                    member.write(piece)
                    yield bytes(pieces)
                    pieces.clear()
    yield bytes(pieces)


async def _say(_: Request, error: Exception) -> Response:
    """The answer to a request that is refused."""
    if isinstance(error, ClientDisconnect):
        error = RefusedError(400, "The connection broke before all of it was here")
    if isinstance(error, HTTPException):
        return JSONResponse({"problem": error.detail}, error.status_code)
    status = error.status if isinstance(error, RefusedError) else 500
    return JSONResponse({"problem": str(error) if isinstance(error, RefusedError) else "That failed"}, status)


def web_app(work: Work, doors: Doors) -> Starlette:
    """The app over a data folder's work."""
    MultiPartParser.spool_max_size = SPOOLED

    @asynccontextmanager
    async def at_work(_: Starlette) -> AsyncIterator[None]:
        work.start()
        yield
        await work.stop()

    return Starlette(
        routes=App(work, doors.most).routes(),
        middleware=[Middleware(Guard, doors=doors)],
        exception_handlers=dict.fromkeys((RefusedError, ClientDisconnect, HTTPException, Exception), _say),
        lifespan=at_work,
    )
