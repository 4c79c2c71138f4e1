# SPDX-License-Identifier: GPL-3.0-or-later
"""The pages: small, without a build, and a first picture that a run of the demo makes."""

import json
from pathlib import Path

import pytest

from tools.make_web_demo import TARGET, picture
from w2w.core.patches.body_parts import PRODUCTS
from w2w.web.guard import PAGES
from w2w.web.shown import STATIC

from ..command_line import cli
from ..headless.conftest import drawn, drawn_results, made_once_here, one_worker

__all__ = ["drawn", "drawn_results", "made_once_here", "one_worker"]

MOST_BYTES = 200_000


def test_all_files_of_the_page_are_small_and_served(client):
    assert sum(file.stat().st_size for file in PAGES.iterdir()) <= MOST_BYTES
    pages = {"openapi.json", *(f"{name}.html" for name in ("index", "enter", "operator"))}
    assert {file.name for file in PAGES.iterdir()} - pages == {*STATIC} - {"style.css"}
    for name in STATIC:
        assert client.get(f"/static/{name}").status_code == 200
    assert client.get("/static/index.html").status_code == 404
    assert client.get("/static/..%2fapp.py").status_code == 404


def test_the_first_picture_is_whole():
    shown = json.loads(TARGET.read_text(encoding="utf-8"))
    corners = len(shown["places"]) // 3
    assert len(shown["share"]) == corners == 512
    assert set(shown["share"]) <= {*range(101)}
    assert {min(shown["share"]), max(shown["share"])} == {0, 100}
    assert len(shown["colours"]) == 11
    assert max(shown["faces"]) < corners
    assert all(product["name"] in PRODUCTS and product["patch"] < corners for product in shown["products"])


def test_the_picture_of_a_run_has_its_figures(drawn_results):
    summary = json.loads((Path(drawn_results) / "summary.json").read_text())
    shown = picture(drawn_results)
    f1 = {each["name"]: each["expected_f1"] for each in summary["answer"]["products"]}
    assert all(product["f1"] == round(f1[product["name"]], 2) for product in shown["products"])
    assert shown["clips"] == summary["clips"]["used"]
    assert shown["sentence"] == summary["answer"]["sentence"]


@pytest.mark.slow
def test_the_first_picture_is_that_of_the_demo(tmp_path):
    assert cli("demo", "--out", tmp_path)[0] == 0
    made, kept = picture(tmp_path / "results"), json.loads(TARGET.read_text(encoding="utf-8"))
    assert (made["clips"], made["activities"]) == (kept["clips"], kept["activities"])
    assert made["sentence"] == kept["sentence"]
    ours = {product["name"]: product["f1"] for product in kept["products"]}
    for product in made["products"]:
        assert product["f1"] == pytest.approx(ours[product["name"]], abs=0.02)
