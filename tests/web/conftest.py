# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app over a data folder of its own, asked as by a browser on this machine."""

import time
from importlib.util import find_spec

import pytest

from ..headless.conftest import write_motions
from ..patience import HANG_S

collect_ignore_glob = [] if find_spec("starlette") else ["test_*.py"]
"""Without the extra `web` there is nothing to test."""

MOST = 3_000_000


@pytest.fixture
def opened(tmp_path):
    """Opens an app, with other doors if they are given."""
    # Loaded before there are threads: pytest rewrites it, and in a thread CPython 3.11 may fail to parse it.
    from anyio import open_file  # noqa: F401
    from starlette.testclient import TestClient

    from w2w.web.app import web_app
    from w2w.web.guard import Doors
    from w2w.web.work import Work

    clients = []

    def client(tokens=(), host="127.0.0.1", names=(), most=MOST):
        data = tmp_path / "data"
        data.mkdir(exist_ok=True)
        app = web_app(Work(data, 1, "", 30.0), Doors(host, names, tokens, most))
        clients.append(TestClient(app, base_url="http://127.0.0.1:8000", raise_server_exceptions=True))
        return clients[-1].__enter__()

    yield client
    for each in clients:
        each.__exit__(None, None, None)


@pytest.fixture(autouse=True)
def read_here(monkeypatch, request):
    """Files are opened in the tests' own process: a worker takes a second to start."""
    from w2w.web.work import Reader

    if "own_reader" not in request.fixturenames:
        monkeypatch.setattr(Reader, "_ask", lambda _, work, *args: work(*args))


@pytest.fixture
def own_reader():
    """Files are opened in a worker, as they are for users."""


@pytest.fixture
def client(opened):
    """The app on this machine, without a token."""
    return opened()


def made(client):
    """A new study's address."""
    return f"/api/studies/{client.post('/api/studies').json()['id']}"


def sent(client, files, study=""):
    """The answer to files sent by name to a new study, or one that is there."""
    study = study or made(client)
    parts = [("files", (name, content)) for name, content in files.items()]
    return study, client.post(f"{study}/files", files=parts)


PACES = {"slow": 0.5, "fast": 2.0}
FEW = {"patches": 24, "seed": 3}


@pytest.fixture(scope="module")
def motions(made_once):
    """Eight npz motions of two activities, by their paths in the library."""
    folder = made_once("web motions", lambda folder: write_motions(folder, PACES, 4))
    return folder, {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*.npz")}


def ended(client, study):
    until = time.monotonic() + HANG_S
    while (now := client.get(study).json())["state"] in ("queued", "running"):
        assert time.monotonic() < until
        time.sleep(0.05)
    return now


def folder_of(study, tmp_path):
    return tmp_path / "data" / "local" / study.rpartition("/")[2]


def judged(client, study):
    """What is shown of a study once all of its files are judged."""
    until = time.monotonic() + HANG_S
    now = client.get(study).json()
    while any(row["judged"] is None for row in now["table"]):
        assert time.monotonic() < until
        now = client.get(study).json()
    return now
