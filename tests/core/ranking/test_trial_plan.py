# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows are dealt so that no clip, or no subject, is tested on what it was trained with."""

from dataclasses import replace

import numpy as np
import pytest

from w2w.core.ranking.halves import CrossValidation

CLIP = np.repeat(np.arange(16), 3)
ACTIVITY = np.array(["jump", "run", "sit", "wave"])[CLIP % 4]
IS_TEST = np.arange(len(CLIP)) % 3 < 2


def test_no_clip_is_trained_on_and_tested():
    work = CrossValidation(ACTIVITY, CLIP, None, IS_TEST, ["jump", "run", "sit"], folds=4).plan()
    assert work.activities == ("jump", "run", "sit")
    assert set(ACTIVITY[work.used]) == set(work.activities)
    clips = CLIP[work.used]
    for number in (*work.plan.whole.splits, *work.plan.repeats[0].splits):
        split = work.plan.splits[number]
        trained = np.isin(work.plan.block, split.train)
        assert not np.isin(clips[split.tested], clips[trained]).any()
        assert work.is_test[split.tested].all()
    assert "4-fold" in work.protocol


def test_all_clips_are_tested_again_in_other_folds():
    protocol = CrossValidation(ACTIVITY, CLIP, None, IS_TEST, ["jump", "run", "sit", "wave"], folds=4)
    work = protocol.plan()
    (again,) = work.plan.repeats
    assert sorted(again.windows) == sorted(work.plan.whole.windows)
    assert again.testable.all()

    def tested(trial):
        return {frozenset(CLIP[work.used][work.plan.splits[number].tested]) for number in trial.splits}

    assert tested(again) != tested(work.plan.whole)
    assert not protocol.plan(halvings=0).plan.repeats
    subject = np.array(["ann", "ben", "cem", "dora"])[CLIP // 4]
    assert not replace(protocol, subject=subject).plan().plan.repeats


def test_no_subject_is_trained_on_and_tested():
    subject = np.array(["ann", "ben"])[CLIP // 8]
    work = CrossValidation(ACTIVITY, CLIP, subject, IS_TEST, ["jump", "run", "sit", "wave"]).plan()
    assert len(work.plan.whole.splits) == 2
    assert "2 subjects" in work.protocol


def test_an_activity_of_one_clip_is_left_out_with_its_reason():
    names = np.where(CLIP == 0, "cartwheel", ACTIVITY)
    work = CrossValidation(names, CLIP, None, IS_TEST, sorted(set(names))).plan()
    assert "cartwheel" not in work.activities
    assert list(work.left_out) == ["cartwheel"]


def test_two_activities_are_needed():
    with pytest.raises(ValueError, match="needs two activities"):
        CrossValidation(ACTIVITY, CLIP, None, IS_TEST, ["jump"]).plan()
