# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w need` says on the cards of a finished run how cheap each recommended sensor may be."""

import csv
import json
import shutil
from functools import partial

import pytest

import w2w
from w2w.core.study.choosing import find_needs
from w2w.core.study.results import StudyResults

from ...command_line import cli
from ..conftest import run_paces

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("one_worker", "few_orders")]


@pytest.fixture(scope="module")
def folder(made_once):
    """A run of four clips an activity."""
    return made_once("need", partial(run_paces, 48)) / "out"


def test_the_cards_say_it_and_twice_is_the_same(folder, tmp_path):
    outs = [shutil.copytree(folder, tmp_path / name) for name in ("first", "second")]
    for out in outs:
        code, output = cli("need", out)
        assert code == 0, output
    cards = json.loads((outs[0] / "summary.json").read_text(encoding="utf-8"))["cards"]
    assert cards
    with (outs[0] / "placements.csv").open(newline="", encoding="utf-8") as stream:
        table = list(csv.DictReader(stream))
    page = (outs[0] / "report.html").read_text(encoding="utf-8")
    for card, row in zip(cards, table, strict=True):
        assert row["needs"] == card["needs"]["sentence"]
        assert card["needs"]["sentence"].startswith("Works down to ")
        assert f"<p>{row['needs']}.</p>" in page
        assert " ".join(output.split()).count(" ".join(row["needs"].split()[:4]))
    for name in ("summary.json", "placements.csv", "report.html"):
        assert (outs[0] / name).read_bytes() == (outs[1] / name).read_bytes()


def test_a_choice_anew_keeps_what_is_needed_where_a_sensor_stays(folder, tmp_path):
    out = shutil.copytree(folder, tmp_path / "out")
    assert cli("need", out)[0] == 0
    before = json.loads((out / "summary.json").read_text(encoding="utf-8"))["cards"]
    assert cli("place", out, "--redraw", "--target", "0.5")[0] == 0
    after = json.loads((out / "summary.json").read_text(encoding="utf-8"))["cards"]
    assert after == before
    page = (out / "report.html").read_text(encoding="utf-8")
    assert f"<p>{before[0]['needs']['sentence']}.</p>" in page
    assert cli("place", out, "--redraw", "--weights", _weights(tmp_path))[0] == 0
    weighed = json.loads((out / "summary.json").read_text(encoding="utf-8"))["cards"]
    assert not any("needs" in card for card in weighed)


def _weights(folder):
    path = folder / "weights.csv"
    path.write_text("activity,weight\nslow,3\n")
    return path


def test_another_place_is_only_printed(folder):
    before = (folder / "summary.json").read_bytes()
    code, output = cli("need", folder, "--place", "belt clip, chest strap")
    assert code == 0, output
    assert (folder / "summary.json").read_bytes() == before
    assert output.count(": F1 ") == 2
    need = w2w.open_results(folder).needs("belt clip")
    assert need.sentence() in " ".join(output.split())
    assert need == find_needs(StudyResults.load(folder), ["belt clip"])[0]


def test_a_place_that_nothing_is_called_is_refused(folder):
    code, output = cli("need", folder, "--place", "mood ring")
    assert (code, "mood ring" in output) == (2, True)
