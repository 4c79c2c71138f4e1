# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages of the web app: its own, the door, shared answers, the operator's."""

import asyncio
import json
import shutil
from collections.abc import Mapping
from contextlib import suppress
from html import escape
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, JSONResponse, Response
from starlette.routing import Route

from ..core.given import inside
from ..core.study.results import REPORT
from ..report.page import PAGE
from .guard import OPERATOR, PAGES, Doors, enter_page, entered, folder_of_person, report_policy
from .receiving import IN_ALL, OF_ONE, folder_size
from .study import PARAMETERS, WISHES, Study
from .uploads import RefusedError
from .work import DAY_S, Work

WRONG_S = 1.0
"""Seconds that whoever guesses a token waits."""

SCRIPTS = ("app", "answer", "clips", "enter", "figures", "page", "pilot", "uploads")

STATIC = ("app.css", "style.css", "demo.json", *(f"{name}.js" for name in SCRIPTS))

PICTURE = "heatmaps/mean.png"


class Pages:
    """The pages, over the same work as the interface."""

    def __init__(self, work: Work, doors: Doors) -> None:
        self.work, self.doors = work, doors

    def routes(self) -> list[Route]:
        """All addresses of pages."""
        return [
            Route("/", self.page),
            Route("/studies/{id}", self.page),
            Route("/static/{name}", self.static),
            Route("/shared/{link}", self.shared),
            Route("/shared/{link}/picture.png", self.shared_picture),
            Route("/enter", self.enter, methods=["POST"]),
            Route("/api", self.interface),
        ]

    async def page(self, request: Request) -> Response:
        """The page; that of a study with its sentence and picture for whoever shows a preview of the link."""
        text = (PAGES / "index.html").read_text(encoding="utf-8")
        with suppress(RefusedError, KeyError):
            study = Study.of(self.work.data / request.state.owner, request.path_params["id"])
            if study.answer():
                picture = request.url_for("file", id=study.id, name=PICTURE)
                text = with_preview(text, study, str(request.url), str(picture))
        return HTMLResponse(text)

    async def static(self, request: Request) -> Response:
        name = request.path_params["name"]
        folder = PAGE if name == "style.css" else PAGES
        if name not in STATIC:
            raise RefusedError(404, "There is no such page")
        return FileResponse(folder / name)

    async def interface(self, _: Request) -> Response:
        """The interface as OpenAPI describes it, with the parameters as they are declared."""
        described = json.loads((PAGES / "openapi.json").read_text(encoding="utf-8"))
        schemas = {"Parameters": PARAMETERS, "Wishes": WISHES | {"compare": (str,)}}
        described["components"] = {"schemas": {name: _schema(each) for name, each in schemas.items()}}
        return JSONResponse(described)

    async def enter(self, request: Request) -> Response:
        """Let in whoever sends the token, and lead on to where they wanted to go."""
        async with request.form() as form:
            token, path = str(form.get("token", "")), str(form.get("next", "/"))
        if not self.doors.owner(token):
            await asyncio.sleep(WRONG_S)
            return enter_page(path, wrong=True)
        return entered(request, token, path)

    async def shared(self, request: Request) -> Response:
        """The report of a study that was shared."""
        study = Study.shared(self.work.data, request.path_params["link"])
        report = study.results / REPORT
        picture = request.url_for("shared_picture", link=request.path_params["link"])
        text = with_preview(report.read_text(encoding="utf-8"), study, str(request.url), str(picture))
        return HTMLResponse(text, headers={"content-security-policy": report_policy(text)})

    async def shared_picture(self, request: Request) -> Response:
        study = Study.shared(self.work.data, request.path_params["link"])
        return FileResponse(inside(study.results, PICTURE))


JSON_KINDS = {str: "string", bool: "boolean", int: "integer", float: "number"}


def _schema(parameters: dict[str, tuple[type, ...]]) -> dict[str, Any]:
    """The schema of an object of parameters, each with its types."""
    types = {name: {"type": JSON_KINDS[kinds[-1]]} for name, kinds in parameters.items()}
    return {"type": "object", "properties": types}


def with_preview(page: str, study: Study, address: str, picture: str) -> str:
    """A page with the answer of a study, and its picture, for whoever shows a preview of its address."""
    title = study.request()["parameters"].get("title", "") or "Where to wear"
    facts = {"title": title, "description": study.answer(), "url": address, "image": picture}
    metas = (f'<meta property="og:{name}" content="{escape(fact)}">\n' for name, fact in facts.items())
    return page.replace("</head>", f"{''.join(metas)}</head>", 1)


MEGABYTE = 1e6


def operates(doors: Doors, owner: str) -> bool:
    """Whether an owner runs the server: whoever is on this machine, else the person `operator`."""
    return not doors.asks or owner == folder_of_person(OPERATOR)


def operator_page(work: Work, doors: Doors, uploads: Mapping[str, int]) -> str:
    """The page, with a row for each person; `uploads` that arrive now by their folders."""
    names = {folder_of_person(name): name for name in doors.people.hashes()} | {"local": "this machine"}
    rows, total = [], 0
    came = {folder for name in names if (folder := work.data / name).is_dir()}
    for folder in sorted({study.folder.parent for study in work.studies()} | came):
        studies = [study for study in work.studies() if study.folder.parent == folder]
        size = folder_size(folder)
        running = sum(study.id in work.running for study in studies)
        waiting = sum(_waits(work, study) for study in studies) - running
        idle = min((max(0.0, study.idle_s()) for study in studies), default=0.0) / DAY_S
        megabytes, arriving = f"{size / MEGABYTE:.0f}", uploads.get(folder.name, 0)
        cells = [len(studies), megabytes, arriving, running, waiting, f"{idle:.0f}"]
        numbers = "".join(f'<td class="n">{cell}</td>' for cell in cells)
        rows.append(f'<tr><th scope="row">{escape(names.get(folder.name, "a token"))}</th>{numbers}</tr>')
        total += size
    most, free = doors.most / MEGABYTE, shutil.disk_usage(work.data).free / MEGABYTE
    used = f"{total / MEGABYTE:.0f} of {IN_ALL * most:.0f} MB are used"
    sentence = f"{used}; one person may use {OF_ONE * most:.0f} MB. The disk has {free:.0f} MB left."
    text = (PAGES / "operator.html").read_text(encoding="utf-8")
    return text.replace("{{ sentence }}", sentence).replace("{{ rows }}", "\n".join(rows))


def _waits(work: Work, study: Study) -> bool:
    with suppress(RefusedError):
        return work.waits(study)
    return False
