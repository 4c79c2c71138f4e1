# SPDX-License-Identifier: GPL-3.0-or-later
"""What the study of placements leaves: figure, verdicts on claims, a page; files of others stay."""

import csv
import shutil

import pytest
from rich.console import Console

from w2w.core.study.results import StudyResults
from w2w_studies.placements.placement_study import (
    CLAIMS,
    FIGURE,
    PAGE,
    TRENDS,
    figure_rows,
    write_placement_study,
)
from w2w_studies.placements.trend_table import trend_markdown
from w2w_studies.placements.trends import Claim, judge, read_claims


@pytest.fixture
def study(drawn_results, tmp_path):
    return StudyResults.load(shutil.copytree(drawn_results, tmp_path / "out"))


@pytest.fixture
def groups(study):
    other, lift, sit = study.utility.activities
    return {lift: "communicative_gesture", sit: "locomotion_posture", other: "asymmetric"}


def written(study, groups, claims, tmp_path):
    console = Console(record=True, width=220, file=(tmp_path / "log").open("w"))
    write_placement_study(study, groups, "left", claims, ["Asked for, but not there: diving."], console)
    return console.export_text()


def test_figure_verdicts_and_page(study, groups, tmp_path):
    claims = [*read_claims(CLAIMS), Claim("Raising | arms", "communicative_gesture", ("left arm",), ("leg",))]
    told = written(study, groups, claims, tmp_path)
    trends = judge(study.utility, study.patches, claims, groups)
    with (study.out / TRENDS).open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["verdict"] for row in rows] == [trend.verdict for trend in trends]
    assert trends[-1].difference > 0.05  # raising the arm is told best on the left arm
    assert float(rows[-1]["difference"]) == pytest.approx(trends[-1].difference, abs=1e-6)
    assert rows[-2]["group"] == "all"
    page = (study.out / PAGE).read_text(encoding="utf-8")
    assert "Asked for, but not there: diving." in page
    assert f"({FIGURE})" in page
    assert "Raising \\| arms" in page
    assert trend_markdown(trends) in page
    assert (study.out / FIGURE).stat().st_size > 10_000
    assert "Claims about parts of the body" in told
    assert f"{trends[-1].difference:+.2f}" in told


def test_rows_stand_in_the_papers_order_of_groups(study, groups):
    rows = figure_rows(study, groups, [0, 5])
    assert [row.group for row in rows] == ["locomotion_posture", "asymmetric", "communicative_gesture"]
