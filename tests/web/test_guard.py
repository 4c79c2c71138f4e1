# SPDX-License-Identifier: GPL-3.0-or-later
"""Who may come in, and what a browser is told to allow."""

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


def test_the_report_s_own_scripts_alone_are_allowed():
    scripts = re.search(r"script-src ([^;]*)", report_policy())[1].split()
    assert len(scripts) == 2
    assert all(re.fullmatch(r"'sha256-[\w+/=]{44}'", script) for script in scripts)


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
    assert "samesite=strict" in cookie
    assert client.get("/api/studies").status_code == 200


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
