# SPDX-License-Identifier: GPL-3.0-or-later
"""Who copies people scores what people do, and nobody scores by luck of the run."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w_studies.comparisons.challenge import (
    UTD,
    judge_of,
    judge_of_utd,
    judged,
    method_csv,
    read_method,
    table_of,
)
from w2w_studies.validation.mhad import MHAD
from w2w_studies.validation.sites import of_the_whole


@pytest.fixture
def few(some_mhad) -> Path:
    return some_mhad(6, ("a03", "a05", "a06"), ("r01", "r02"))


def by_site(judge, table):
    """A method's scores from a table (S, A)."""
    return {
        judge.name: {
            (activity, site): float(table[row, column])
            for row, site in enumerate(judge.sites)
            for column, activity in enumerate(judge.activities)
        }
    }


@pytest.mark.slow
def test_half_of_the_people_reach_the_ceiling(some_mhad):
    judge = judge_of(MHAD, some_mhad(12, ("a03", "a05", "a06"), ("r01", "r02")))
    found = []
    for first, second in zip(*judge.scores.halves[:, :40], strict=True):
        other = judge._replace(scores=replace(judge.scores, f1=np.nan_to_num(second)))
        found.append(judged(other, by_site(judge, np.nan_to_num(first))).mean_rho)
    ceiling = judged(judge, by_site(judge, judge.scores.f1)).ceiling.value
    assert 0.3 < ceiling < 1
    assert of_the_whole(np.mean(found)) == pytest.approx(ceiling, abs=0.1)


def test_people_themselves_are_right_and_their_reverse_is_wrong(few):
    judge = judge_of(MHAD, few)
    same, reverse = (judged(judge, by_site(judge, way * judge.scores.f1)) for way in (1, -1))
    assert (same.overall.spearman, same.mean_rho, same.regret.lost) == pytest.approx((1, 1, 0))
    assert (reverse.overall.spearman, reverse.mean_rho) == pytest.approx((-1, -1))
    assert reverse.regret.lost > reverse.regret.at_random


def test_one_score_a_site_stands_for_all_activities(few, tmp_path):
    judge = judge_of(MHAD, few)
    lines = [
        f"{judge.name},{site},{score}" for site, score in zip(judge.sites, judge.scores.mean, strict=True)
    ]
    (tmp_path / "mine.csv").write_text("\n".join(["data_set,site,score", *lines]))
    found = judged(judge, read_method(tmp_path / "mine.csv"))
    assert found.overall.spearman == pytest.approx(1)
    assert found.regret.lost == 0


def test_at_utd_mhads_wrist_activities_are_ranked(shared_data):
    judge = judge_of_utd(shared_data / "imu" / "utd_mhad" / "utd_mhad_subjects_1_4.npz")
    assert len(judge.activities) == 21
    people = by_site(judge, judge.scores.f1.T)
    assert judged(judge, people).overall.spearman == pytest.approx(1)
    sites_alone = {UTD: {("", judge.sites[0]): 0.5}}
    rows = table_of([judge], {"people": people, "sites": sites_alone, "silent": {}})
    assert [row[1] for row in rows] == ["random", "people", "sites", "silent"]
    assert rows[1][3].startswith("1.00 (")
    assert rows[2][3] == "no order"
    assert rows[3][3] == "not given"


def test_a_ranking_comes_back_as_it_was_written(tmp_path):
    method = {"UMAFall": {("walk", "ankle"): 0.5, ("", "wrist"): -1.0}, "DSADS": {("", "torso"): 2.0}}
    (tmp_path / "a.csv").write_text(method_csv(method))
    assert read_method(tmp_path / "a.csv") == method


@pytest.mark.parametrize("score", ["", "high", "nan", "inf"])
def test_what_is_no_score_is_refused_with_its_line(tmp_path, score):
    (tmp_path / "a.csv").write_text(f"data_set,site,score\nDSADS,torso,1\nDSADS,left arm,{score}\n")
    with pytest.raises(ValueError, match=r"a\.csv, line 3: .* is no score"):
        read_method(tmp_path / "a.csv")


@pytest.mark.slow
def test_the_command_gives_the_same_bytes_twice_and_names_a_missing_site(few, tmp_path):
    ranking = tmp_path / "mine.csv"
    sites = ("left wrist", "right wrist", "left hip", "right hip", "left ankle", "right ankle")
    lines = [f"Berkeley MHAD,{site},{-number}" for number, site in enumerate(sites)]
    ranking.write_text("\n".join(["data_set,site,score", *lines]))

    def run(out):
        return CliRunner().invoke(APP, ["challenge", str(ranking), "--mhad", str(few), "--out", str(out)])

    for name in ("one", "two"):
        done = run(tmp_path / name)
        assert done.exit_code == 0, done.output
    pages = [(tmp_path / name / "challenge.md").read_bytes() for name in ("one", "two")]
    assert pages[0] == pages[1]
    assert b"| Berkeley MHAD | mine |" in pages[0]
    ranking.write_text("\n".join(["data_set,site,score", *lines[1:]]))
    done = run(tmp_path / "three")
    assert done.exit_code == 2
    assert "no score for the site 'left wrist'" in " ".join(done.output.split())
    assert not (tmp_path / "three").exists()


def test_no_data_set_is_no_challenge(tmp_path):
    done = CliRunner().invoke(APP, ["challenge", "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "Point it to a data set" in done.output
