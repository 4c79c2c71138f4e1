# SPDX-License-Identifier: GPL-3.0-or-later
"""Weights, background and what is left out: the panel ranks, chooses and saves as the command line does."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.findings.in_words import sure_sentences
from w2w.core.ranking.weights import mean_over
from w2w.core.selection.headline import mean_sentence
from w2w.core.study.results import StudyResults
from w2w.scene.base.patches import empties_by_patch
from w2w.ui.jobs import jobs
from w2w.ui.panels.steps import W2W_PT_utility
from w2w.ui.study import scores
from w2w.ui.study.counting import is_reweighed
from w2w.ui.study.lists import advice_of, answer_of
from w2w.ui.study.state import config_of, utility_of

from .made_study import make_study
from .test_choosing import options, place, set_wishes
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

DRAWS = 4
"""Ways in which activities count; each is ranked anew at both doors."""

RUN_WISHES = ["--forbid", "foot", "--max", "3", "--target", "0.85"]


def weigh(study: bpy.types.PropertyGroup, parts: dict[str, str], weights: dict[str, float]) -> None:
    """Set the parts and weights of activities as a person does; the others count like any."""
    for activity in study.activities:
        activity.part = parts.get(activity.name, "COUNTED")
        activity.weight = weights.get(activity.name, 1.0)


def counting_options(parts: dict[str, str], weights: dict[str, float], folder: Path) -> list[str]:
    """The same for the command line."""
    background = ",".join(name for name, part in parts.items() if part == "BACKGROUND")
    rows = [f"{name},{weight}\n" for name, weight in weights.items()]
    (folder / "weights.csv").write_text("activity,weight\n" + "".join(rows))
    return ["--background", background, "--weights", str(folder / "weights.csv")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parts", "weights"),
    [
        ({"bow": "BACKGROUND"}, {"run": 0.3}),
        ({}, {"bow": 2.5, "run": 0.0}),
    ],
)
def test_a_choice_by_weights_is_that_of_the_command_line(
    finished_run: Path, tmp_path: Path, parts: dict[str, str], weights: dict[str, float]
) -> None:
    study = open_file(finished_run / "study.blend").w2w
    weigh(study, parts, weights)
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    asked = [*RUN_WISHES, *counting_options(parts, weights, tmp_path)]
    choice, said = place(finished_run, tmp_path, *asked)
    assert advice_of(study) == choice, said
    assert not is_reweighed(study, utility_of(study))
    assert f"{mean_sentence(utility_of(study))}." in sure_sentences(answer_of(study), utility_of(study))


@pytest.mark.slow
def test_drawn_wishes_with_weights_get_the_same_answer_at_both_doors(
    finished_run: Path, tmp_path: Path
) -> None:
    study = open_file(finished_run / "study.blend").w2w
    rng = np.random.default_rng(5)
    for number in range(DRAWS):
        names = rng.permutation([activity.name for activity in study.activities]).tolist()
        parts = {names[0]: "BACKGROUND"} if number % 2 else {}
        weights = {name: round(float(rng.uniform(0.1, 4)), 3) for name in names[1:]}
        wishes = [("FORBID", str(rng.choice(["left arm", "head", "right"])), 1.0), ("COST", "leg", 1.7)]
        target = round(float(rng.uniform(0.5, 1)), 3)
        set_wishes(study, wishes)
        weigh(study, parts, weights)
        study.target, study.max_places = target, 3
        assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
        asked = ["--target", str(target), "--max", "3", *options(wishes, tmp_path)]
        choice, said = place(finished_run, tmp_path, *asked, *counting_options(parts, weights, tmp_path))
        assert advice_of(study) == choice, said
        assert choice["worn_together"] is not None


def test_what_is_shown_follows_at_once_and_rank_again_makes_it_exact(library: Path) -> None:
    body = make_study(library)
    study, before = body.w2w, utility_of(body.w2w)
    assert W2W_PT_utility.is_done(None, body)
    study.view = "A2"
    study.activities[0].part = "BACKGROUND"
    study.activities[1].weight = 3.0
    shown = mean_over(before.expected_f1, np.array([0.0, 3.0, 1.0]))
    assert study.regions[0].f1 == pytest.approx(shown.max(), abs=1e-6)
    assert [row.patch for row in study.chosen] == [shown.argmax()]
    assert set(empties_by_patch(study.chosen_collection)) == {shown.argmax()}
    assert "over the activities that count" in answer_of(study)["sentence"]
    assert is_reweighed(study, before)
    assert not W2W_PT_utility.is_done(None, body)
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    utility = utility_of(study)
    assert utility.weights.tolist() == [0.0, 3.0, 1.0]
    np.testing.assert_array_equal(utility.f1, before.f1)
    np.testing.assert_array_equal(scores.expected_mean(study, utility), utility.expected_mean)
    assert W2W_PT_utility.is_done(None, body)
    assert study.view == "A2"
    study.activities[0].part = "COUNTED"
    assert is_reweighed(study, utility)
    study.activities[0].part = "LEFT_OUT"
    assert not is_reweighed(study, utility)


@pytest.mark.slow
def test_run_all_ranks_again_by_new_weights(library: Path) -> None:
    body = make_study(library)
    body.w2w.activities[0].part = "BACKGROUND"
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert utility_of(body.w2w).weights.tolist() == [0.0, 1.0, 1.0]
    assert jobs.message.text.startswith("Done: ")


def test_where_nothing_counts_the_ranking_says_so(library: Path) -> None:
    body = make_study(library)
    for activity in body.w2w.activities:
        activity.part = "BACKGROUND"
    with pytest.raises(RuntimeError, match="none of the activities that can be tested counts"):
        bpy.ops.w2w.rank_patches()


@pytest.mark.slow
def test_weights_are_saved_with_the_study_and_come_back(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    names = [activity.name for activity in body.w2w.activities]
    weigh(body.w2w, {names[0]: "BACKGROUND"}, {names[2]: 0.3})
    assert config_of(body.w2w).background == (names[0],)
    assert config_of(body.w2w).weights == ((names[2], 0.3),)
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    assert jobs.message.text.endswith("ranked anew by the new weights")
    saved = StudyResults.load(tmp_path / "saved")
    assert (saved.config().background, saved.config().weights) == ((names[0],), ((names[2], 0.3),))
    assert saved.utility.weights.tolist() == [0.0, 1.0, 0.3]
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "study.blend"))
    for study in (open_file(tmp_path / "study.blend").w2w, open_results(tmp_path / "saved")):
        assert [activity.part for activity in study.activities] == ["BACKGROUND", "COUNTED", "COUNTED"]
        assert config_of(study).weights == ((names[2], 0.3),)
        assert config_of(study).background == (names[0],)
    assert not is_reweighed(study, utility_of(study))


def open_results(folder: Path) -> bpy.types.PropertyGroup:
    """The study of a results folder."""
    assert bpy.ops.w2w.open_results(filepath=str(folder)) == {"FINISHED"}
    return bpy.context.scene.w2w.body.w2w


@pytest.mark.slow
def test_what_is_left_out_takes_its_weight_along(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    names = [activity.name for activity in body.w2w.activities]
    weigh(body.w2w, {names[0]: "BACKGROUND"}, {names[0]: 2.0})
    body.w2w.activities[0].part = "LEFT_OUT"
    assert not config_of(body.w2w).background
    assert not config_of(body.w2w).weights
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    choice, said = place(tmp_path / "saved", tmp_path)
    assert choice is not None, said
