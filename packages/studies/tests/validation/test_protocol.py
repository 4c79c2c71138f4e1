# SPDX-License-Identifier: GPL-3.0-or-later
"""A protocol's rules name what a clip shows, where it is from and who moves."""

import numpy as np
import pytest

from w2w_studies.datasets.berkeley_mhad import MHAD_ACTIONS
from w2w_studies.validation.mhad import MHAD


@pytest.mark.parametrize(
    ("clip", "expected"),
    [
        ("hop/bd_hopBothLegs1hops_007.bvh", ("jump", "HDM05", "HDM05 bd")),
        ("pick_up/mm_depositFloorR_019.bvh", ("bend", "HDM05", "HDM05 mm")),
        ("bow/dataset-1_bow_not-confident_001.bvh", ("bend", "Bandai-Namco", "Bandai-Namco not-confident")),
        ("dataset-2_wave-both-hands_old_001.bvh", ("wave two hands", "Bandai-Namco", "Bandai-Namco old")),
        ("A/Jumping Jacks.fbx", ("jumping jacks", "Mixamo", "Mixamo A/Jumping Jacks.fbx")),
        ("a25_s3_t2", ("sit down", "UTD-MHAD", "UTD-MHAD s3")),
    ],
)  # fmt: skip
def test_a_clip_is_known_by_its_name(clip, expected):
    assert tuple(MHAD.match(clip)) == expected


@pytest.mark.parametrize(
    "clip",
    ["hop/bd_hopLLeg1hops_007.bvh", "dataset-2_wave-left-hand_active_001.bvh", "Waving.fbx", "a1_s1_t1",
     "X Bot@Flying Knee Punch Combo.fbx", "x/a4_s1_t1", "byebye/dataset-1_byebye_active_001.bvh"],
)  # fmt: skip
def test_what_shows_something_else_takes_no_part(clip):
    assert MHAD.match(clip) is None


def test_each_of_the_data_sets_actions_has_one_name_or_none():
    used = [name for theirs in MHAD.real.values() for name in theirs]
    assert len(set(used)) == len(used)
    assert set(used) == set(MHAD_ACTIONS) - {"sit down then stand up"}
    assert {rule.activity for rule in MHAD.rules} == set(MHAD.real)
    for analysis in MHAD.analyses:
        assert set(analysis.activities) <= set(MHAD.real)
        shown = {(rule.activity, rule.source) for rule in MHAD.rules}
        assert all(
            any((name, source) in shown for source in analysis.sources) for name in analysis.activities
        )
    assert MHAD.activity_of("jump in place") == "jump"
    assert MHAD.activity_of("sit down then stand up") == ""
    assert np.isclose(MHAD.sensor.accelerometer.full_scale, 2 * 9.80665)
