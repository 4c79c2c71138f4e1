# SPDX-License-Identifier: GPL-3.0-or-later
"""What activities shall count can be said before there is a ranking, and enters the first one."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.ui.panels.results import W2W_PT_activities
from w2w.ui.results import results
from w2w.ui.steps.motion_import import remove_clips
from w2w.ui.study import scores
from w2w.ui.study.counting import is_reweighed
from w2w.ui.study.pages import turn_to
from w2w.ui.study.state import config_of, rank_settings, utility_of

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

LABELS = ["kicking", "stepping", "waving"]


def listed(study: bpy.types.PropertyGroup) -> list[tuple[str, str, float]]:
    """Name, part and weight of each activity."""
    return [(activity.name, activity.part, activity.weight) for activity in study.activities]


def test_the_activities_of_the_clips_are_listed_before_the_ranking(library: Path) -> None:
    study = make_study(library, "").w2w
    turn_to(W2W_PT_activities.page)
    assert not W2W_PT_activities.poll(bpy.context)
    bpy.ops.w2w.import_folder(directory=str(library))
    assert listed(study) == [(name, "COUNTED", 1.0) for name in LABELS]
    assert W2W_PT_activities.poll(bpy.context)


def test_the_list_follows_labels_and_what_they_count_stays(library: Path) -> None:
    study = make_study(library, "motions").w2w
    study.activities["waving"].weight = 2.5
    study.activities["stepping"].part = "BACKGROUND"
    kicks = [clip for clip in study.clips if clip.activity == "kicking"]
    kicks[0].activity = "greeting"
    kept = [("stepping", "BACKGROUND", 1.0), ("waving", "COUNTED", 2.5)]
    assert listed(study) == [("greeting", "COUNTED", 1.0), ("kicking", "COUNTED", 1.0), *kept]
    for clip in study.clips:
        clip.selected = clip.activity in ("kicking", "greeting")
    bpy.ops.w2w.relabel_clips(activity="a kick")
    assert listed(study) == [("a kick", "COUNTED", 1.0), *kept]
    bpy.ops.w2w.remove_clips()
    assert listed(study) == kept
    remove_clips(study.id_data, range(len(study.clips)))
    assert listed(study) == []


@pytest.mark.slow
def test_an_empty_label_is_no_activity(library: Path) -> None:
    study = make_study(library, "motions").w2w
    for clip in study.clips:
        if clip.activity == "kicking":
            clip.activity = " "
    assert [activity.name for activity in study.activities] == ["stepping", "waving"]


@pytest.mark.slow
def test_weights_set_before_enter_the_first_ranking(library: Path) -> None:
    body = make_study(library, "motions patches signals")
    study = body.w2w
    study.activities["kicking"].part = "BACKGROUND"
    study.activities["stepping"].weight = 3.0
    study.activity_index = 1  # a click on a row, which shows no map yet
    assert config_of(study).background == ("kicking",)
    assert config_of(study).weights == (("stepping", 3.0),)
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    utility = utility_of(study)
    assert utility.weights.tolist() == [0.0, 3.0, 1.0]
    assert not is_reweighed(study, utility)
    assert study.view == "MEAN"
    assert not W2W_PT_activities.poll(bpy.context)
    np.testing.assert_array_equal(scores.expected_mean(study, utility), utility.expected_mean)


def test_new_patches_forget_the_ranking_and_not_the_weights(library: Path) -> None:
    body = make_study(library)
    body.w2w.activities["waving"].weight = 0.25
    assert bpy.ops.w2w.place_patches() == {"FINISHED"}
    assert utility_of(body.w2w) is None
    assert ("waving", "COUNTED", 0.25) in listed(body.w2w)
    results.clear(body)
    assert ("waving", "COUNTED", 0.25) in listed(body.w2w)


def test_clips_that_come_after_the_ranking_wait_for_the_next(library: Path) -> None:
    body = make_study(library)
    body.w2w.clips[0].activity = "greeting"
    assert [activity.name for activity in body.w2w.activities] == LABELS
    assert body.w2w.ranked_as != rank_settings(body.w2w)
