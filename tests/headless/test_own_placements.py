# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run --placements`: spots of one's own are simulated, ranked, and may be wished for."""

import csv
import json
import re
import shutil

import numpy as np
import pytest

from w2w.core.study.results import StudyResults

from ..command_line import cli
from .conftest import write_motions

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


@pytest.fixture(scope="module")
def finished(made_once):
    folder = made_once("own", _run)
    return folder / "out", (folder / "output.txt").read_text(encoding="utf-8")


def _run(folder):
    table = "name,vertex,x,y,z\nStrap pod,1234,,,\nclip,,0.14,-0.06,0.98\n"
    (folder / "own.csv").write_text(table, encoding="utf-8")
    write_motions(folder / "library", {"sitting": 0.5, "lifting": 0.8, "walking": 1.2}, 2)
    code, output = cli(
        *("run", folder / "library", "--out", folder / "out", "--patches", 12, "--no-pictures"),
        *("--no-report", "--workers", 1, "--placements", folder / "own.csv"),
    )
    assert code == 0, output
    (folder / "output.txt").write_text(output, encoding="utf-8")


def test_they_have_signals_scores_a_rank_and_a_cost(finished):
    out, output = finished
    study = StudyResults.load(out)
    assert len(study.patches) == 14
    summary = json.loads((out / "summary.json").read_text())
    own, base = (
        {entry["name"]: entry for entry in summary["own_placements"]},
        summary["answer"]["costs_are_against"],
    )
    assert list(own) == ["Strap pod", "clip"]
    assert own["Strap pod"]["vertex"] == 1234
    assert own["clip"]["region"].startswith("left")
    expected = study.utility.expected_mean
    for name, entry in own.items():
        patch = study.patches.names.index(name)
        assert entry["rank"] == 1 + int((expected[:12] > expected[patch]).sum())
        assert entry["costs"] == pytest.approx(
            round(float(expected[base].mean()), 2) - round(float(expected[patch]), 2), abs=1e-6
        )  # as shown
        assert entry["of"] == 13
        assert name in output
    assert "Your placements" in output
    with np.load(next((out / "signals").glob("*.npz"))) as signals:
        assert signals["acc"].shape[1] == 14
    with (out / "utility.csv").open(newline="") as stream:
        assert len(list(csv.DictReader(stream))) == 14


def test_the_report_shows_them_with_score_rank_and_cost(finished):
    out, _ = finished
    code, output = cli("report", out)
    assert code == 0, output
    page = (out / "report.html").read_text(encoding="utf-8")
    section = page[page.index('<section class="panel" id="own">') :].partition("</section>")[0]
    rows = [
        re.findall(r">([^<>]+)<", row.replace("\n", ""))
        for row in re.findall(r"<tr>(.*?)</tr>", section, re.DOTALL)[1:]
    ]
    told = json.loads((out / "summary.json").read_text())["own_placements"]
    for cells, own in zip(rows, told, strict=True):
        said = " ".join(cell.strip() for cell in cells)
        assert said.startswith(f"{own['name']} {own['region']} ")
        assert f"{own['expected_f1']:.2f}" in said
        assert f"{own['rank']} of {own['of']}" in said
        assert ("as good" in said) == own["as_good"]
        assert (f" {own['verdict'] or 'costs'} {own['costs']:.2f}" in said) != own["as_good"]
        assert f'data-patch="{own["patch"]}">{own["name"]}<' in section


def test_a_report_without_them_says_nothing_of_them(finished, tmp_path):
    out, _ = finished
    shutil.copytree(out, tmp_path / "out")
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    del summary["own_placements"]  # as of a run without any
    (tmp_path / "out" / "summary.json").write_text(json.dumps(summary))
    assert cli("report", tmp_path / "out")[0] == 0
    assert "Your placements" not in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")


@pytest.mark.slow
def test_they_may_be_wished_for_by_name(finished):
    out, _ = finished
    code, output = cli("place", out, "--must", "strap pod", "--max", 1, "--out", out / "choice.json")
    assert code == 0, output
    choice = json.loads((out / "choice.json").read_text())
    assert [place["name"] for place in choice["worn_together"]["places"]] == ["Strap pod"]


def test_one_that_is_off_the_body_is_wrong_use_and_said(finished, tmp_path):
    out, _ = finished
    (tmp_path / "own.csv").write_text("name,x,y,z\nkite,0,0,9\n", encoding="utf-8")
    library = out.parent / "library"
    own = ("--placements", tmp_path / "own.csv")
    code, output = cli("run", library, "--out", tmp_path / "out", *own, "--patches", 8)
    assert code != 0
    assert "'kite' lies" in output
    assert "from the skin" in output
