# SPDX-License-Identifier: GPL-3.0-or-later
"""The demo has one answer, byte for byte: on the command line, in the panel, in the web app and in Python."""

import json
from pathlib import Path

import bpy
import pytest

import w2w
from w2w.core.findings.advice_content import answer_content
from w2w.headless.commands.demo import write_library
from w2w.ui.study import lists
from w2w.web.request import INPUT
from w2w.web.study import Study

from ..command_line import cli
from ..here import clips_here

PATCHES = 24
OPTIONS = ("--patches", PATCHES, "--no-pictures", "--no-report")


def as_text(answer: object) -> str:
    return json.dumps(json.loads(json.dumps(answer)), sort_keys=True)


@pytest.fixture(scope="module")
def answer(tmp_path_factory: pytest.TempPathFactory) -> str:
    """The answer of `w2w run` on the library of `w2w demo`."""
    folder = tmp_path_factory.mktemp("demo")
    write_library(folder / "library")
    return answer_to(folder / "library", folder / "results")


def answer_to(library: Path, out: Path) -> str:
    with clips_here():
        assert cli("run", library, "--out", out, *OPTIONS)[0] == 0
    return as_text(json.loads((out / "summary.json").read_text("utf-8"))["answer"])


@pytest.mark.later
@pytest.mark.usefixtures("blender")
def test_the_panel_says_the_same(answer: str) -> None:
    assert bpy.ops.w2w.add_body() == {"FINISHED"}
    body = bpy.context.scene.w2w.body
    body.w2w.patch_count = PATCHES
    assert bpy.ops.w2w.try_examples() == {"FINISHED"}
    assert as_text(lists.answer_of(body.w2w)) == answer


@pytest.mark.later
def test_python_says_the_same(answer: str) -> None:
    motions = w2w.example_motions()
    ranking = w2w.rank(w2w.synthesize(motions, w2w.sample_patches(motions.body, PATCHES)))
    assert as_text(answer_content(ranking.answer, ranking.patches, ranking.cautions)) == answer


@pytest.mark.later
def test_the_web_app_says_the_same(answer: str, tmp_path: Path) -> None:
    study = Study.make(tmp_path / "data" / "local", demo=True)
    assert answer_to(study.folder / INPUT, tmp_path / "results") == answer


def test_the_answer_surprises() -> None:
    """The demo is worth a look: the figures of the first page are those of an earbud, not of a habit."""
    shown = json.loads((Path(w2w.__file__).parent / "web/pages/demo.json").read_text("utf-8"))
    f1 = {product["name"]: product["f1"] for product in shown["products"]}
    assert f1["earbud"] > f1["watch"] + 0.2 > f1["belt clip"] + 0.3
