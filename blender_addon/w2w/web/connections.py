# SPDX-License-Identifier: GPL-3.0-or-later
"""Connections that nobody can hold on to: each part of a request has its time, and the idle make way."""

import asyncio
from contextlib import suppress
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

resource: Any = import_module("resource") if find_spec("resource") else None  # Windows has none

HEAD_S = 10.0
"""Seconds for the head of a request, from the connection or the last answer on."""

UNREAD_S = 60.0
"""Seconds for which an answer may wait to be read."""

MOST_FILES = 4096
"""Files and connections that the process asks the system for."""

AT_ONCE = 16
"""Connections that are accepted in one go, before any is looked at."""


class Connection(H11Protocol):
    """A connection as uvicorn has it, closed when it is silent for too long, or in the way of others."""

    most = 1000
    _timer: asyncio.TimerHandle | None = None
    _unread: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection; if there are too many, the one that has been idle the longest ends."""
        super().connection_made(transport)
        self._await_head()
        if len(self.connections) > self.most:
            next(iter(_IDLE)).transport.abort()

    def connection_lost(self, exc: Exception | None) -> None:
        self._begun()
        if self._unread:
            self._unread.cancel()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._look()

    def on_response_complete(self) -> None:
        self._await_head()
        super().on_response_complete()
        self._look()

    def _look(self) -> None:
        """Stop waiting for a head once there is a request."""
        if self.cycle is not None and not self.cycle.response_complete:
            self._begun()

    def pause_writing(self) -> None:
        """The other side does not read: not for ever."""
        super().pause_writing()
        self._unread = self._unread or self.loop.call_later(UNREAD_S, self.transport.abort)

    def resume_writing(self) -> None:
        super().resume_writing()
        if self._unread:
            self._unread.cancel()
            self._unread = None

    def _await_head(self) -> None:
        self._begun()
        _IDLE[self] = None
        self._timer = self.loop.call_later(HEAD_S, self.transport.abort)

    def _begun(self) -> None:
        _IDLE.pop(self, None)
        if self._timer:
            self._timer.cancel()
            self._timer = None


_IDLE: dict[Connection, None] = {}
"""Connections without a request, the one that has waited longest first."""


def with_room() -> type[Connection]:
    """The kind of connections, as many as the system lets this process have with files to spare."""
    if resource is not None:
        soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
        wanted = MOST_FILES if hard == resource.RLIM_INFINITY else min(MOST_FILES, hard)
        with suppress(ValueError, OSError):
            resource.setrlimit(resource.RLIMIT_NOFILE, (max(soft, wanted), hard))
        Connection.most = max(8, min(1000, resource.getrlimit(resource.RLIMIT_NOFILE)[0] // 3))
    return Connection
