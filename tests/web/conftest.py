# SPDX-License-Identifier: GPL-3.0-or-later
"""The web app over a data folder of its own, asked as by a browser on this machine."""

from importlib.util import find_spec

import pytest

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
