# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may come in, and what a browser is told to allow."""

import base64
import hashlib
import re

import pytest

from w2w.web.guard import Doors, report_policy

from .conftest import made

FIRST, SECOND = "first-token-1", "second-token-2"


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "", "10.0.0.1", "[::1"])
def test_another_host_is_refused(client, host):
    reply = client.get("/api/studies", headers={"host": host})
    assert reply.status_code == 421
    assert "name" in reply.json()["problem"]


@pytest.mark.parametrize("host", ["127.0.0.1:8000", "localhost:8000", "[::1]:8000", "LOCALHOST"])
def test_this_machine_s_names_are_known(client, host):
    assert client.get("/api/studies", headers={"host": host}).status_code == 200


def test_a_server_for_others_knows_addresses_and_the_names_that_it_was_given():
    doors = Doors("0.0.0.0", ["lab.example"], [FIRST], 1)
    assert doors.called("10.1.2.3:80")
    assert doors.called("lab.example")
    assert not doors.called("evil.example")


@pytest.mark.parametrize(
    "headers",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": "http://127.0.0.1:9000"},
        {"sec-fetch-site": "cross-site"},
        {"sec-fetch-site": "same-site"},
    ],
)
def test_another_site_s_page_changes_nothing(client, headers):
    assert client.post("/api/studies", headers=headers).status_code == 403
    assert client.get("/api/studies").json() == []


def test_an_own_page_may(client):
    own = {"origin": "http://127.0.0.1:8000", "sec-fetch-site": "same-origin"}
    assert client.post("/api/studies", headers=own).status_code == 201


def test_every_answer_has_the_headers(client):
    for path in ("/", "/static/app.js", "/api/about", "/nowhere", "/api/studies/0"):
        headers = client.get(path).headers
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
        assert headers["x-content-type-options"] == "nosniff"


def test_the_page_has_no_inline_script_or_style(client):
    page = client.get("/").text
    assert not re.search(r"<script(?![^>]*\ssrc=)|\son\w+=|\sstyle=|<style|https?://", page)


REPORT = (
    '<h1><script>alert("a label")</script></h1>\n<script type="application/json" id="w2w-data">{}</script>\n'
    "<script>\nview()\n</script>\n<script>\npage()\n</script>\n</body>\n</html>\n"
)


def test_a_report_s_own_scripts_alone_are_allowed_whatever_version_wrote_it():
    scripts = re.search(r"script-src ([^;]*)", report_policy(REPORT))[1].split()
    sums = [hashlib.sha256(f"\n{name}()\n".encode()).digest() for name in ("view", "page")]
    assert scripts == [f"'sha256-{base64.b64encode(digest).decode()}'" for digest in sums]
    assert "script-src 'none'" in report_policy("<h1>no report</h1><script>alert(1)</script>")


def test_without_the_token_nobody_comes_in(opened):
    client = opened([FIRST])
    for headers in ({}, {"authorization": "Bearer wrong"}, {"cookie": "w2w_token=wrong"}):
        for path in ("/api/studies", "/static/app.js", "/api/studies/0/files/report.html"):
            assert client.get(path, headers=headers).status_code == 401
    page = client.get("/", headers={"accept": "text/html"})
    assert page.status_code == 401
    assert 'name="token"' in page.text


def test_the_token_in_the_address_becomes_a_cookie_that_no_script_reads(opened):
    client = opened([FIRST])
    reply = client.get(f"/?token={FIRST}", follow_redirects=False)
    assert reply.status_code == 303
    assert reply.headers["location"] == "/"
    cookie = reply.headers["set-cookie"].lower()
    assert "httponly" in cookie
    assert "samesite=lax" in cookie  # a link in a mail leads where it should
    assert client.get("/api/studies").status_code == 200


def test_a_token_that_is_typed_leads_on_to_the_page_that_was_asked_for(opened):
    client = opened([FIRST])
    page = client.get("/studies/0123", headers={"accept": "text/html"})
    assert 'name="next" value="/studies/0123"' in page.text
    wrong = client.post("/enter", data={"token": "wrong", "next": "/studies/0123"})
    assert wrong.status_code == 401
    assert 'role="alert">That token is wrong' in wrong.text
    reply = client.post("/enter", data={"token": FIRST, "next": "/studies/0123"}, follow_redirects=False)
    assert (reply.status_code, reply.headers["location"]) == (303, "/studies/0123")
    assert client.get("/api/studies").status_code == 200


@pytest.mark.parametrize(
    "path",
    [
        "//evil.example/x",
        "/\\evil.example/x",
        "///evil.example",
        "/\\/\\evil.example",
        "\\\\evil.example",
        "https://evil.example",
        "/\t/evil.example",
    ],
)
def test_nobody_is_sent_to_another_server(opened, path):
    client = opened([FIRST])
    reply = client.post("/enter", data={"token": FIRST, "next": path}, follow_redirects=False)
    assert re.fullmatch(r"/(?![/\\]).*", reply.headers["location"])
    reply = client.get(f"http://127.0.0.1:8000//evil.example/x?token={FIRST}", follow_redirects=False)
    assert reply.headers["location"] == "/evil.example/x"


def test_another_site_s_page_enters_nobody(opened):
    client = opened([FIRST])
    strange = {"origin": "http://evil.example", "sec-fetch-site": "cross-site"}
    assert client.post("/enter", data={"token": FIRST}, headers=strange).status_code == 403


def test_the_door_shows_no_page_of_the_app(opened):
    client = opened([FIRST])
    for name in ("app.css", "style.css", "enter.js"):
        assert client.get(f"/static/{name}").status_code == 200
    page = client.get('/"><script>alert(1)</script>', headers={"accept": "text/html"}).text
    assert "<script>alert" not in page


def test_a_second_token_sees_its_own_studies_only(opened):
    client = opened([FIRST, SECOND])
    first, second = ({"authorization": f"Bearer {token}"} for token in (FIRST, SECOND))
    client.headers = first
    study = made(client)
    assert client.get(study).status_code == 200
    for method in ("get", "delete"):
        assert getattr(client, method)(study, headers=second).status_code == 404
    assert client.post(f"{study}/run", headers=second, json={}).status_code == 404
    assert client.get("/api/studies", headers=second).json() == []
    assert len(client.get("/api/studies").json()) == 1


@pytest.mark.parametrize("guess", ["0" * 32, "%2e%2e", "local", "0" * 32 + "/files/x"])
def test_a_guessed_id_finds_nothing(client, guess):
    made(client)
    assert client.get(f"/api/studies/{guess}").status_code == 404
