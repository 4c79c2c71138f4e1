# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w serve`: one server a data folder, a token that is kept, and what is asked of the app."""

from socket import create_server

import uvicorn
from filelock import FileLock
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w.web import app as web_app_module


def serve(*words):
    result = CliRunner().invoke(APP, ["serve", *map(str, words)], env={"COLUMNS": "400"})
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result.exit_code, result.output


def test_a_data_folder_in_use_is_told_from_one_that_cannot_be_made(tmp_path):
    with FileLock(tmp_path / "lock"):
        assert serve("--data", tmp_path) == (4, f"Another server uses {tmp_path}\n")
    (tmp_path / "file").write_text("")
    code, said = serve("--data", tmp_path / "file")
    assert code == 2
    assert str(tmp_path / "file") in said
    assert "Another server" not in said


def test_the_token_is_drawn_once_and_only_its_owner_reads_it(tmp_path, monkeypatch):
    monkeypatch.setattr(uvicorn, "run", lambda *_, **__: None)
    first = serve("--data", tmp_path, "--host", "0.0.0.0")[1]
    token = (tmp_path / "token").read_text()
    assert len(token) > 20
    assert first.strip().endswith(f"/#token={token}")
    assert (tmp_path / "token").stat().st_mode & 0o777 == 0o600
    assert serve("--data", tmp_path, "--host", "0.0.0.0")[1] == first
    assert "token" not in serve("--data", tmp_path / "local")[1]


def test_days_and_megabytes_reach_the_app_in_its_units(tmp_path, monkeypatch):
    made = []
    monkeypatch.setattr(uvicorn, "run", lambda *_, **__: None)
    monkeypatch.setattr(web_app_module, "web_app", lambda work, doors: made.append((work, doors)))
    assert serve("--data", tmp_path, "--keep-days", 2, "--most-mb", 3)[0] == 0
    ((work, doors),) = made
    assert work.keep_s == 2 * 24 * 60 * 60
    assert doors.most == 3_000_000


def test_a_port_that_is_taken_is_said_before_any_address(tmp_path):
    with create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        code, said = serve("--data", tmp_path, "--port", port)
    assert code == 2
    assert said == f"http://127.0.0.1:{port}/ is taken by another program: give another --port\n"
