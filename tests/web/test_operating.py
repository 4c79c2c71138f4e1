# SPDX-License-Identifier: GPL-3.0-or-later
"""The operator's page: who uses how much, for whoever runs the server alone."""

import re

import pytest
from starlette.testclient import TestClient

from w2w.web.app import web_app
from w2w.web.guard import OPERATOR, Doors, People
from w2w.web.work import Work

from .conftest import made, sent

NAME = "Anna <b>Ö."


@pytest.fixture
def asked(tmp_path):
    """Asks a server of two people as one of them, with at most 1,000 bytes a study."""
    data = tmp_path / "data"
    data.mkdir()
    people = People(data / "people")
    tokens = {name: people.invite(name) for name in (NAME, OPERATOR)}
    app = web_app(Work(data, 1, "", 30.0), Doors("127.0.0.1", (), (), 1000, people))
    with TestClient(app, base_url="http://127.0.0.1:8000") as client:

        def by(name):
            client.headers["authorization"] = f"Bearer {tokens[name]}" if name else "Bearer none"
            return client

        yield by


def row_of(page, name):
    """The figures of a person's row."""
    row = re.search(rf'<th scope="row">{name}</th>(.*?)</tr>', page)
    return re.findall("<td[^>]*>([^<]*)</td>", row[1])


def test_the_operator_sees_who_uses_what_and_nobody_else_does(asked):
    sent(asked(NAME), {"secret walk.bvh": bytes(600)})
    made(asked(NAME))
    assert asked(NAME).get("/operator").status_code == 403
    assert asked("").get("/operator").status_code == 401
    page = asked(OPERATOR).get("/operator")
    assert page.status_code == 200
    assert row_of(page.text, "Anna &lt;b&gt;Ö.") == ["2", "0", "0", "0", "0", "0"]
    assert "secret" not in page.text
    assert "one person may use 0 MB" in page.text


def test_whoever_is_on_this_machine_runs_the_server(client):
    made(client)
    assert row_of(client.get("/operator").text, "this machine")[0] == "1"


def test_a_person_has_a_share_of_the_disk_and_leaves_the_others_theirs(asked):
    kept = [sent(asked(NAME), {"a.bvh": bytes(500)})[1].json()["refused"] for _ in range(6)]
    assert kept[0] == {}
    assert "no room" in kept[-1]["a.bvh"]
    assert sent(asked(OPERATOR), {"a.bvh": bytes(500)})[1].json()["refused"] == {}
