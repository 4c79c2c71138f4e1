# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app's door: who may come in, from where, with how much."""

import base64
import hashlib
import hmac
import ipaddress
import re
import socket
from collections.abc import Sequence
from dataclasses import dataclass
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from ..report.page import PAGE
from .uploads import RefusedError

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

ASK_TOKEN = """<!doctype html><html lang="en"><meta charset="utf-8"><title>Where to wear</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<h1>Where to wear</h1><form action="/"><p><label>The token of this server, which whoever started it has:
<input name="token" type="password"></label> <button>Open</button></p></form>"""


def report_policy() -> str:
    """The Content-Security-Policy for a report: of inline scripts, the report's own two by their hashes."""
    scripts = (f"\n{(PAGE / name).read_text(encoding='utf-8')}\n" for name in ("viewer.js", "page.js"))
    digests = (base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in digests)
    inline = f"script-src {allowed}; style-src 'unsafe-inline'"
    return HEADERS["content-security-policy"].replace(OWN_SCRIPTS, inline)


def is_local(host: str) -> bool:
    """Whether nobody but this machine reaches an address or name."""
    return host == "localhost" or (_is_address(host) and ipaddress.ip_address(host).is_loopback)


def _is_address(host: str) -> bool:
    try:
        ipaddress.ip_address(host)
    except ValueError:
        return False
    return True


@dataclass(frozen=True)
class Doors:
    """What the server is called, who may come in, and how many bytes a request may bring."""

    host: str
    names: Sequence[str]  # further names in the Host header, such as a reverse proxy's
    tokens: Sequence[str]  # none: whoever is on this machine
    most: int

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
        if not self.tokens:
            return "local"
        given = token.encode()
        known = [hmac.compare_digest(given, one.encode()) for one in self.tokens]
        return hashlib.sha256(given).hexdigest()[:32] if any(known) else ""


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
        try:
            ours = self.doors.called(host)
        except ValueError:
            ours = False
        if not ours:
            return _no(421, "This server does not go by that name: see --name")
        site = request.headers.get("sec-fetch-site", "same-origin")
        strange = site not in ("same-origin", "none") or (origin and urlsplit(origin).netloc != host)
        if request.method not in SAFE_METHODS and strange:
            return _no(403, "The request comes from another site's page")
        given = request.query_params.get("token")
        header = re.fullmatch(r"Bearer (\S+)", request.headers.get("authorization", ""))
        token = header[1] if header else given or request.cookies.get(COOKIE, "")
        owner = self.doors.owner(token)
        if not owner:
            wants_page = "text/html" in request.headers.get("accept", "")
            return HTMLResponse(ASK_TOKEN, 401) if wants_page else _no(401, "The token is missing or wrong")
        request.state.owner = owner
        if given and self.doors.tokens and request.method in SAFE_METHODS:
            answer = RedirectResponse(request.url.path, 303)
            secure = request.url.scheme == "https"
            answer.set_cookie(COOKIE, token, httponly=True, samesite="strict", secure=secure)
            return answer
        return None

    def _counted(self, headers: Headers, receive: Receive) -> Receive:
        """The request's body, refused once it has more bytes than it may."""
        brings_files = headers.get("content-type", "").startswith("multipart/form-data")
        most, so_far = self.doors.most if brings_files else MOST_TEXT, 0

        async def counted() -> Message:
            nonlocal so_far
            message = await receive()
            so_far += len(message.get("body", b""))
            if so_far > most or int(headers.get("content-length", "0")) > most:
                raise RefusedError(413, f"more than {most / 1e6:.0f} MB at once are not taken")
            return message

        return counted


def _no(status: int, sentence: str) -> Response:
    return JSONResponse({"problem": sentence}, status)
