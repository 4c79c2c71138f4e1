# SPDX-License-Identifier: GPL-3.0-or-later
"""What kills its process costs what it draws, and nothing else."""

import json
import os
import shutil
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from w2w.core.colours import Scale, score_range, span_note
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.results import StudyResults
from w2w.headless.console import Terminal
from w2w.headless.reports import draw
from w2w.headless.reports.draw import BLEND, HEATMAPS, draw_alone, marked_set, write_worn
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.workers import outcome
from w2w_studies.commands.study_rehab import FIGURE, draw_figure
from w2w_studies.paper.subsets import Subset

pytestmark = pytest.mark.usefixtures("few_orders")

ROOT = Path(__file__).resolve().parents[3]


def _abort():
    os.write(2, b"Fatal: no display\n")
    os.abort()


@pytest.mark.slow
def test_blender_aborts_while_it_draws():
    assert draw_alone(_abort) == "Blender crashed; its last words: Fatal: no display"


@pytest.mark.slow
def test_the_figure_of_a_finished_study_is_drawn_by_a_worker(drawn_results):
    subset = Subset((3, 7), (0.8, 0.9), 0.85, True, 0.95, 2.0)
    assert draw_alone(partial(draw_figure, drawn_results, subset=subset)) == ""
    assert (drawn_results / FIGURE).read_bytes().startswith(b"\x89PNG")


def test_heatmaps_show_the_expected_f1_and_mark_the_best_spot_of_the_summary(drawn_results, monkeypatch):
    """The drawing is left out: what it is given, and what is written beside it, counts here."""
    study, drawn, coloured = StudyResults.load(drawn_results), {}, []

    class Pictures:
        def __init__(self, body, _size):
            self.body = body

        def coloured(self, colours):
            coloured.append(colours)

        def locate(self, *_):
            pass

    def figure(path, _views, title, scale, subtitle):
        drawn[path.stem] = (title, scale, subtitle)

    def subset(_path, _views, _title, scale, *given):
        drawn["set"] = (scale, given[1].cards)

    monkeypatch.setattr("w2w.drawing.body.BodyPictures", Pictures)
    monkeypatch.setattr("w2w.drawing.heatmap.heatmap_figure", figure)
    monkeypatch.setattr("w2w.drawing.heatmap.subset_figure", subset)
    monkeypatch.setattr(draw, "shaded", draw.shaded.__wrapped__)
    draw.write_maps(study, drawn_results)
    draw.write_worn(drawn_results, drawn_results)
    utility, best = (
        study.utility,
        json.loads((drawn_results / "summary.json").read_text())["best_single_patch"],
    )
    _, scale, subtitle = drawn["mean"]
    low, high = scale.low, scale.high
    assert (low, high) == score_range(utility.expected_mean)
    assert scale.note == span_note(utility.expected_mean, low, high)
    assert scale.title == "Expected F1"
    assert drawn["set"][0] == scale
    assert subtitle.endswith(f"Best spot: {best['name']} ({best['expected_f1']:.2f} on other clips)")
    scores = utility.expected_f1[:, utility.activities.index("arm_raise")]
    _, scale, subtitle = drawn["arm_raise"]
    assert (scale.low, scale.high) == score_range(scores)
    assert study.patches.names[scores.argmax()] in subtitle
    np.testing.assert_array_equal(
        coloured[-1], Scale(low, high).colours(study.patches, utility.expected_mean)
    )
    cards = {card["patch"]: card for card in study.summary["cards"]}
    worn = [place["patch"] for place in study.summary["worn_together"]["places"]]
    for text, card in zip(drawn["set"][1], [cards[patch] for patch in worn], strict=True):
        assert card["words"][1:] in text
        assert card["arrow"] in text


def _dies(*_):
    os.write(2, b"out of memory\n")
    os._exit(1)


def _saves(_out, to):
    (to / BLEND).write_text("saved")


@pytest.mark.slow
def test_maps_that_kill_their_worker_cost_themselves_alone(drawn_results, tmp_path, monkeypatch):
    out = shutil.copytree(drawn_results, tmp_path / "out")
    study = StudyResults.load(out)
    monkeypatch.setattr(draw, "write_maps", _dies)
    monkeypatch.setattr(draw, "write_blend", _saves)
    monkeypatch.setattr(draw, "ready_to_save", print)  # these results have no motions
    with draw.drawing(out) as pictures:
        pictures.begin(study)
        outcome(pictures.begun[0][1])  # it has died
        pictures.save()
        failed = pictures.finish(study.utility.activities, RunMonitor(Terminal()))
    assert failed == {HEATMAPS: "Blender crashed; its last words: out of memory"}
    assert (out / BLEND).read_text() == "saved"
    assert not list(out.glob(".*.part"))


@pytest.mark.usefixtures("one_worker")
def test_what_cannot_be_drawn_says_why(tmp_path):
    said = draw_alone(partial(write_worn, tmp_path, tmp_path))
    assert "is not the results folder of a finished run" in said


def test_pictures_and_file_mark_the_set_worn_together(drawn_results, tmp_path):
    out = tmp_path / "out"
    shutil.copytree(drawn_results, out)
    summary = json.loads((out / "summary.json").read_text())
    worn = summary["worn_together"]
    shown = marked_set(StudyResults.load(out))
    assert shown.order == [place["patch"] for place in worn["places"]]
    assert shown.scores[-1] == worn["expected_f1"]
    assert shown.target == worn["target"]
    assert shown.sentence.lower() == worn["sentence"].lower()
    (out / "summary.json").write_text(json.dumps(summary | {"worn_together": None}))
    shown, best = marked_set(StudyResults.load(out)), summary["answer"]
    assert shown == ([best["patch"]], [best["expected_f1"]], None, best["sentence"])


def test_of_many_clips_three_an_activity_are_in_the_blender_file():
    clips = [LabelledClip(f"{activity}_{n}", activity, "", "") for activity in "abc" for n in range(40)]
    study = StudyResults(Path(), None, tuple(clips), {}, None)
    kept = [clip.name for clip in study.clips_in_blend]
    assert kept == [f"{activity}_{n}" for activity in "abc" for n in range(3)]
    assert replace(study, clips=tuple(clips[:100])).clips_in_blend == clips[:100]
