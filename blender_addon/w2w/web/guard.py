# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app's door: who may come in, from where, with how much."""

import asyncio
import base64
import hashlib
import hmac
import ipaddress
import re
import secrets
import socket
import time
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..core.files import write_text
from ..core.wording import restated
from .uploads import RefusedError, refused

SHORT = 32

OPERATOR = "operator"
"""The name of the person who runs the server, and sees who uses it."""


@dataclass(frozen=True)
class People:
    """A file with a line for each person: name, tab, SHA-256 of the token. Each question reads it anew."""

    file: Path | None

    def __bool__(self) -> bool:
        return bool(self.hashes())

    def hashes(self) -> dict[str, str]:
        """The hash of each person's token by name."""
        with suppress(OSError, ValueError):
            lines = self.file.read_text(encoding="utf-8").splitlines() if self.file else []
            rows = (line.rpartition("\t") for line in lines if not line.startswith("#"))
            return {name.strip(): digest.strip() for name, _, digest in rows if name.strip()}
        return {}

    def owner(self, token: str) -> str:
        """The folder of the person who has a token, whatever tokens they had before; "" if nobody has it."""
        given = _hash(token)
        found = [
            name
            for name, digest in self.hashes().items()
            if hmac.compare_digest(given.encode(), digest.encode())
        ]
        return folder_of_person(found[0]) if found else ""

    def invite(self, name: str) -> str:
        """Draw a token for a person, in the place of an earlier one; only its hash is written down."""
        if self.file is None or not name.strip() or not name.isprintable() or name.startswith("#"):
            raise ValueError(f"{name!r} is no name of a person")
        token = secrets.token_urlsafe(24)
        people = {**self.hashes(), name.strip(): _hash(token)}
        write_text(self.file, "".join(f"{one}\t{digest}\n" for one, digest in people.items()))
        self.file.chmod(0o600)
        return token


NOBODY = People(None)


def folder_of(token: str) -> str:
    """The name of the folder for the studies of a token that no person has."""
    return _hash(token)[:SHORT]


def folder_of_person(name: str) -> str:
    """The name of the folder for a person's studies."""
    return _hash(f"person\n{name}")[:SHORT]


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


PAGES = Path(__file__).resolve().parent / "pages"

COOKIE = "w2w_token"

SAFE_METHODS = ("GET", "HEAD")

MOST_TEXT = 2**21
"""Bytes of a request that brings no files."""

OWN_SCRIPTS = "script-src 'self'; style-src 'self'"

HEADERS = {
    "content-security-policy": f"default-src 'none'; {OWN_SCRIPTS}; img-src 'self' data:; "
    "connect-src 'self'; frame-src 'self'; form-action 'self'; base-uri 'none'; frame-ancestors 'self'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "cache-control": "no-store",
}

OPEN = ("/enter", "/static/app.css", "/static/style.css", "/static/enter.js")
"""Addresses that need no token."""

SHARED = "/shared/"
"""Beginning of addresses that need no token but a secret of their own."""

SILENT_S, PACE = 20.0, 1000
"""Seconds that a request may send nothing, and bytes a second that it sends at least after that."""

SLASHES = "/\\"

KEPT_S = 60 * 86400
"""Seconds for which a browser keeps a token."""


def report_policy(report: str) -> str:
    """The Content-Security-Policy for a report: of inline scripts, W2W's own by their hashes.

    They are at its end, after the data and all else that comes from a study: a report keeps them, whatever
    version wrote it.
    """
    end = report.rpartition('id="w2w-data">')[2].partition("</script>")[2]
    scripts = re.findall(r"<script>(.*?)</script>", end, re.DOTALL)
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests) or "'none'"
    inline = f"script-src {allowed}; style-src 'unsafe-inline'"
    return HEADERS["content-security-policy"].replace(OWN_SCRIPTS, inline)


def is_local(host: str) -> bool:
    """Whether nobody but this machine reaches an address or name."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(host: str) -> bool:
    with suppress(ValueError):
        ipaddress.ip_address(host)
        return True
    return False


@dataclass(frozen=True)
class Doors:
    """What the server is called, who may come in, and how many bytes a request may bring."""

    host: str
    names: Sequence[str]  # further names in the Host header, such as a reverse proxy's
    tokens: Sequence[str]  # none, and no people: whoever is on this machine
    most: int
    people: People = NOBODY

    @property
    def asks(self) -> bool:
        """Whether a token is needed."""
        return bool(self.tokens or self.people)

    def called(self, host: str) -> bool:
        """Whether a Host header, with or without its port, names this server.

        A name may be pointed anywhere by a stranger's page, an address may not.
        """
        name = urlsplit(f"//{host}").hostname or ""
        if is_local(self.host):
            return is_local(name) or name in self.names
        return _is_address(name) or name in ("localhost", socket.gethostname().lower(), *self.names)

    def owner(self, token: str) -> str:
        """The folder of a token's studies; "" if the token is none of ours."""
        if not self.asks:
            return "local"
        given = token.encode()
        known = [hmac.compare_digest(given, one.encode()) for one in self.tokens]
        return folder_of(token) if any(known) else self.people.owner(token)


class Guard:
    """Middleware that lets in whom `Doors` allow, and gives every answer its headers."""

    def __init__(self, app: ASGIApp, doors: Doors) -> None:
        self.app, self.doors = app, doors

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request or refuse it."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers.setdefault(name, value)
            await send(message)

        refused = self._refused(Request(scope))
        if refused is not None:
            await refused(scope, receive, with_headers)
        else:
            await self.app(scope, self._counted(Headers(scope=scope), receive), with_headers)

    def _refused(self, request: Request) -> Response | None:
        """The answer to a request that does not come in; its owner is noted on one that does."""
        host, origin = request.headers.get("host", ""), request.headers.get("origin")
        ours = False
        with suppress(ValueError):
            ours = self.doors.called(host)
        if not ours:
            return _no(421, "This server does not go by that name: see --name")
        site = request.headers.get("sec-fetch-site", "same-origin")
        strange = site not in ("same-origin", "none") or (origin and urlsplit(origin).netloc != host)
        if request.method not in SAFE_METHODS and strange:
            return _no(403, "The request comes from another site's page")
        if request.url.path in OPEN or request.url.path.startswith(SHARED):
            return None
        given = request.query_params.get("token")
        header = re.fullmatch(r"Bearer (\S+)", request.headers.get("authorization", ""))
        token = header[1] if header else given or request.cookies.get(COOKIE, "")
        owner = self.doors.owner(token)
        if not owner:
            wants_page = "text/html" in request.headers.get("accept", "")
            if wants_page:
                return enter_page(request.url.path, wrong=bool(given))
            return _no(401, "The token is missing or wrong")
        request.state.owner = owner
        if given and self.doors.asks and request.method in SAFE_METHODS:
            return entered(request, token, request.url.path)
        return None

    def _counted(self, headers: Headers, receive: Receive) -> Receive:
        """The request's body, refused once it has more bytes than it may, or comes too slowly."""
        brings_files = headers.get("content-type", "").startswith("multipart/form-data")
        most, so_far, ended = self.doors.most if brings_files else MOST_TEXT, 0, False
        begun = time.monotonic()

        async def counted() -> Message:
            nonlocal so_far, ended
            if ended:  # what comes now says that the connection broke
                return await receive()
            left = begun + SILENT_S + so_far / PACE - time.monotonic()
            silent = "The upload stood still for too long: send it again"
            with restated(silent, TimeoutError, refused(408)):
                message = await asyncio.wait_for(receive(), max(0.0, min(SILENT_S, left)))
            ended = not message.get("more_body", False)
            so_far += len(message.get("body", b""))
            if so_far > most or int(headers.get("content-length", "0")) > most:
                raise RefusedError(413, f"more than {most / 1e6:.0f} MB at once are not taken")
            return message

        return counted


def enter_page(path: str, wrong: bool = False) -> Response:
    """The page that asks for the token, and leads on to a path of this server."""
    text = (PAGES / "enter.html").read_text(encoding="utf-8")
    text = text.replace("{{ next }}", escape(own_path(path))).replace(
        "{{ hidden }}", "" if wrong else " hidden"
    )
    return HTMLResponse(text, 401)


def entered(request: Request, token: str, path: str) -> Response:
    """The way on for whoever has a token, which the browser keeps; links from elsewhere find it there."""
    answer = RedirectResponse(own_path(path), 303)
    secure = request.url.scheme == "https"
    answer.set_cookie(COOKIE, token, httponly=True, samesite="lax", secure=secure, max_age=KEPT_S)
    return answer


def own_path(path: str) -> str:
    """A path of this server, whatever was asked for: with two slashes of any kind it would be another's."""
    return f"/{path.lstrip(SLASHES)}" if path.isprintable() else "/"


def _no(status: int, sentence: str) -> Response:
    return JSONResponse({"problem": sentence}, status)
