# SPDX-License-Identifier: GPL-3.0-or-later
"""Visitors who are slow, silent or many: they never keep others waiting."""

import socket
import threading
import time
import urllib.request
from contextlib import ExitStack, contextmanager, suppress

import pytest
import uvicorn

from w2w.web import connections, guard
from w2w.web.app import web_app
from w2w.web.connections import AT_ONCE, Connection, with_room
from w2w.web.guard import Doors
from w2w.web.study import Study
from w2w.web.work import Work

from ..patience import HANG_S

LARGE = 60_000_000

UPLOAD = (
    b"POST /api/studies HTTP/1.1\r\nHost: localhost\r\nContent-Length: 90000\r\n"
    b"Content-Type: multipart/form-data; boundary=x\r\n\r\n--x\r\n"
)


@contextmanager
def serving(tmp_path):
    """A server's port."""
    (tmp_path / "data").mkdir()
    app = web_app(Work(tmp_path / "data", 1, "", 30.0), Doors("127.0.0.1", (), (), 10**8))
    config = uvicorn.Config(
        app, port=0, log_level="warning", http=with_room(), backlog=AT_ONCE, timeout_graceful_shutdown=1
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    end = time.monotonic() + HANG_S
    while not server.started:
        assert time.monotonic() < end
        time.sleep(0.02)
    yield server.servers[0].sockets[0].getsockname()[1]
    server.should_exit = True
    thread.join(HANG_S)


@pytest.fixture
def port(tmp_path):
    with serving(tmp_path) as port:
        yield port


@pytest.fixture
def connect(port):
    """Opens connections that send some bytes and then nothing."""
    with ExitStack() as stack:

        def connected(sent=b""):
            one = stack.enter_context(socket.create_connection(("127.0.0.1", port), HANG_S))
            one.sendall(sent)
            return one

        yield connected


def get(port, path="/api/studies"):
    with urllib.request.urlopen(f"http://127.0.0.1:{port}{path}", timeout=HANG_S) as reply:
        return reply.read()


@pytest.mark.parametrize("sent", [b"", b"GET / HT", b"GET / HTTP/1.1\r\nHost: localhost\r\n"])
def test_a_head_that_never_ends_is_given_up(connect, monkeypatch, sent):
    monkeypatch.setattr(connections, "HEAD_S", 0.2)
    assert closed(connect(sent))


def test_a_second_head_that_never_ends_is_given_up(connect, monkeypatch):
    monkeypatch.setattr(connections, "HEAD_S", 0.2)
    one = connect(b"GET /api HTTP/1.1\r\nHost: localhost\r\n\r\n")
    assert one.recv(15) == b"HTTP/1.1 200 OK"
    one.sendall(b"GET /api HT")
    assert closed(one)


def closed(one):
    with suppress(ConnectionResetError):
        while one.recv(2**16):
            pass
    return True


def test_silent_connections_give_way_to_new_ones(port, connect, monkeypatch):
    monkeypatch.setattr(Connection, "most", 8)
    silent = [connect(b"GET / HT") for _ in range(40)]
    assert get(port) == b"[]"
    assert closed(silent[0])


def test_silent_uploads_stop_nobody_and_are_given_up(port, connect, monkeypatch):
    monkeypatch.setattr(guard, "SILENT_S", 1.0)
    silent = [connect(UPLOAD) for _ in range(12)]
    request = urllib.request.Request(
        f"http://127.0.0.1:{port}/api/studies",
        b'--x\r\nContent-Disposition: form-data; name="files"; filename="walk/a.bvh"\r\n\r\nM\r\n--x--\r\n',
        {"Content-Type": "multipart/form-data; boundary=x"},
    )
    with urllib.request.urlopen(request, timeout=HANG_S) as reply:
        assert b'"walk/a.bvh"' in reply.read()
    answer = silent[0].recv(2**16)
    assert answer.startswith(b"HTTP/1.1 408")
    assert len(get(port)) > 2


def test_an_upload_that_trickles_is_given_up(connect, monkeypatch):
    monkeypatch.setattr(guard, "SILENT_S", 0.5)
    one = connect(UPLOAD)
    one.settimeout(0.1)
    end, answer = time.monotonic() + HANG_S, b""
    while not answer:
        assert time.monotonic() < end
        try:
            one.sendall(b"x")
            answer = one.recv(100)
        except TimeoutError:
            continue
    assert answer.startswith(b"HTTP/1.1 408")


def test_an_answer_that_nobody_reads_is_given_up(connect, tmp_path, monkeypatch):
    monkeypatch.setattr(connections, "UNREAD_S", 0.3)
    study = Study.make(tmp_path / "data/local")
    study.results.mkdir()
    (study.results / "report.html").touch()
    (study.results / "summary.json").write_text('{"answer": {"sentence": "A watch."}}')
    with (study.results / "large.csv").open("wb") as stream:
        stream.truncate(LARGE)
    one = connect(f"GET /api/studies/{study.id}/results.zip HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
    time.sleep(1.0)
    read = 0
    with suppress(ConnectionResetError):
        while some := one.recv(2**16):
            read += len(some)
    assert read < LARGE
