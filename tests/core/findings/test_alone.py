# SPDX-License-Identifier: GPL-3.0-or-later
"""What durations and sources tell alone: nearly all where activities differ by nothing else, else little."""

from dataclasses import replace

import numpy as np
import pytest

from tests.core.selection.made_map import ranked
from w2w.core.findings.cautions import KNOW, STOPS, WEAKENS, cautions
from w2w.core.findings.sources import Origin, f1_alone
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip

ACTIVITIES, PEOPLE = ("sit", "stand", "walk"), 8
UTILITY = replace(ranked([0.9, 0.8]), activities=ACTIVITIES, weights=np.ones(3), left_out={})
CLIPS = [
    LabelledClip(f"{name} {who}", name, f"person {who}", f"{name} {who}")
    for name in ACTIVITIES
    for who in range(PEOPLE)
]


def facts(seconds=(4.0, 4.0, 4.0), systems=("studio",)):
    """Facts of the clips, which last this long by their activity, and take turns in the systems."""
    rng = np.random.default_rng(0)
    return [
        {
            "duration_s": seconds[ACTIVITIES.index(clip.activity)] * rng.uniform(0.9, 1.1),
            "source": systems[number % len(systems)],
        }
        for number, clip in enumerate(CLIPS)
    ]


def said(utility, clips, about):
    found = cautions(utility, clips, about, StudyConfig(), patch=0)
    return {
        weight: [each.text for each in found if each.weight == weight] for weight in (STOPS, WEAKENS, KNOW)
    }


def test_activities_that_differ_by_duration_alone_are_cautioned_against():
    texts = said(UTILITY, CLIPS, facts(seconds=(3.0, 5.0, 9.0)))
    assert any(
        text.startswith("a clip's duration alone gives F1 1.00, the whole signal .90: ")
        for text in texts[WEAKENS]
    )
    assert texts[KNOW] == ["guessing a clip without its movement gives F1 1.00 by its duration"]
    texts = said(UTILITY, CLIPS, facts())
    assert not any("duration" in text for text in texts[WEAKENS])
    assert any(text.endswith(" by its duration") for text in texts[KNOW])


def test_activities_that_differ_by_source_alone_stop_the_answer_or_are_cautioned_against():
    about = facts()
    for clip, each in zip(CLIPS, about, strict=True):
        each["source"] = f"lab of {clip.activity}"
    texts = said(UTILITY, CLIPS, about)
    assert len(texts[STOPS]) == 1
    assert not any("source" in text for text in texts[WEAKENS])  # said once, by what stops the answer
    for each in about[::4]:
        each["source"] = "studio"  # three of four are told by their lab: too few to stop the answer
    texts = said(replace(UTILITY, expected_mean=np.full(2, 0.7)), CLIPS, about)
    assert not texts[STOPS]
    assert any(text.startswith("a clip's source alone gives F1 ") for text in texts[WEAKENS]), texts
    texts = said(UTILITY, CLIPS, facts(systems=("studio", "film")))
    assert not texts[STOPS]
    assert not any("source" in text for text in texts[WEAKENS])
    assert any("by its duration and " in text and text.endswith(" by its source") for text in texts[KNOW])


def test_the_figures_are_told_to_programs_by_one_caution():
    found = cautions(
        UTILITY, CLIPS, facts(seconds=(3.0, 5.0, 9.0), systems=("studio", "film")), StudyConfig()
    )
    told = [each for each in found if each.f1]
    assert [each.weight for each in told] == [KNOW]
    assert set(told[0].f1) == {"duration", "source"}
    assert told[0].f1["duration"] == pytest.approx(1)
    assert all(f"{f1:.2f}".lstrip("0") in told[0].text for f1 in told[0].f1.values())


def test_labels_dealt_by_chance_tell_nothing():
    """A sensor does no better than guesses there, so nearly all of its F1 is no finding."""
    low = replace(UTILITY, expected_mean=np.full(2, 0.35))
    alarms = 0
    for seed in range(40):
        dealt = np.random.default_rng(seed).permutation([clip.activity for clip in CLIPS])
        clips = [replace(clip, activity=str(name)) for clip, name in zip(CLIPS, dealt, strict=True)]
        texts = said(low, clips, facts(seconds=(3.0, 5.0, 9.0), systems=("studio", "film", "game")))
        alarms += any("alone gives" in text for text in texts[WEAKENS])
    assert alarms <= 4


@pytest.mark.parametrize("by_subject", [False, True])
def test_it_is_told_of_clips_and_people_that_were_not_learnt_from(by_subject):
    clips = [replace(clip, activity=ACTIVITIES[int(clip.subject[-1]) % 3]) for clip in CLIPS]
    people = [Origin(clip.activity, clip.subject, "rig", "", clip.subject) for clip in clips]
    config = replace(StudyConfig(), by_subject=by_subject)
    found = f1_alone(UTILITY, clips, people, [4.0] * len(clips), config)
    assert set(found) == {"source"}  # all last as long
    assert (found["source"] > 0.95) is not by_subject  # a person left out is a source that nobody knows


def test_clips_of_activities_that_are_not_ranked_take_no_part():
    others = [LabelledClip("jump", "jump", "person 0", "jump")]
    clips, seconds = [*CLIPS, *others], [4.0] * len(CLIPS) + [20.0]
    origins = [Origin(clip.activity, "studio", "", "", "") for clip in clips]
    assert f1_alone(UTILITY, clips, origins, seconds, StudyConfig()) == {}
