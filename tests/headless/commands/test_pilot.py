# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w pilot` writes what people's recordings say beside the answer, into summary and report."""

import json
import shutil
from functools import partial

import pytest

from w2w.core.patches.naming import resolve
from w2w.core.study.results import StudyResults

from ...command_line import cli
from ...phone_exports import worn_like_clips
from ..conftest import run_paces

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("one_worker")]


@pytest.fixture(scope="module")
def folder(made_once):
    """A run of four clips an activity."""
    return made_once("pilot", partial(run_paces, 128)) / "out"


def export(study: StudyResults, folder):
    """Files of two people with a phone on the left wrist, as an app in Germany writes them."""
    return worn_like_clips(
        study, folder, resolve("left wrist", study.body(), study.patches), mark=";", comma=True
    )


def test_the_folder_says_both_and_twice_is_the_same(folder, tmp_path):
    outs = [shutil.copytree(folder, tmp_path / name) for name in ("first", "second")]
    worn = export(StudyResults.load(folder), tmp_path / "worn")
    for out in outs:
        code, output = cli("pilot", out, worn, "--at", "left wrist")
        assert code == 0, output
    summary = json.loads((outs[0] / "summary.json").read_text(encoding="utf-8"))
    found = summary["pilot"]
    assert found["sentence"].startswith("With your pilot (left wrist, 2 people, ")
    assert found["without"] == pytest.approx(summary["answer"]["expected_f1"], abs=1e-4)
    assert " ".join(found["sentence"].split()) in " ".join(output.split())
    page = (outs[0] / "report.html").read_text(encoding="utf-8")
    assert f"<b>{found['sentence']}</b>" in page
    for name in ("summary.json", "report.html"):
        assert (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes()
    before = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert {name: value for name, value in summary.items() if name != "pilot"} == before


def test_a_choice_of_another_place_does_not_show_it(folder, tmp_path):
    out = shutil.copytree(folder, tmp_path / "out")
    worn = export(StudyResults.load(folder), tmp_path / "worn")
    assert cli("pilot", out, worn, "--at", "left wrist")[0] == 0
    answer = json.loads((out / "summary.json").read_text(encoding="utf-8"))["answer"]
    part = answer["name"].split()[-1]
    assert cli("place", out, "--redraw", "--forbid", part)[0] == 0
    assert (
        json.loads((out / "summary.json").read_text(encoding="utf-8"))["answer"]["patch"] != answer["patch"]
    )
    assert "With your pilot" not in (out / "report.html").read_text(encoding="utf-8")


def test_what_cannot_be_used_is_said_and_leaves_the_folder_as_it_was(folder, tmp_path):
    out = shutil.copytree(folder, tmp_path / "out")
    worn = export(StudyResults.load(folder), tmp_path / "worn")
    before = {path.name: path.read_bytes() for path in out.glob("*.*") if path.is_file()}
    for at, why in (
        ("left wirst", "did you mean left wrist"),
        ("", "say where it was worn, as by --at watch (watch, "),
        ("", 'region is called "fast 1"'),
    ):
        code, output = cli("pilot", out, worn, *(("--at", at) if at else ()))
        assert code == 2
        assert why in " ".join(output.split())
    assert {path.name: path.read_bytes() for path in out.glob("*.*") if path.is_file()} == before


def test_a_summary_whose_pilot_is_not_whole_is_refused(folder, tmp_path):
    out = shutil.copytree(folder, tmp_path / "out")
    content = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    (out / "summary.json").write_text(json.dumps(content | {"pilot": {"sentence": "All is well."}}))
    with pytest.raises(ValueError, match="its pilot is not whole"):
        StudyResults.load(out)
