# SPDX-License-Identifier: GPL-3.0-or-later
"""The garment's protocol names its clips and takes the sites that a user gives."""

import numpy as np
import pytest

from w2w_studies.datasets.mighar import MIGHAR_ACTIVITIES, WornAt
from w2w_studies.validation.mighar import ACTIVITIES, mighar
from w2w_studies.validation.protocol import BY_POSTURE

SITES = {"left wrist": "left wrist", "vertex 7": 7, "chest": "chest"}
PROTOCOL = mighar(WornAt((0, 1, 2), SITES, np.arange(3)))


@pytest.mark.parametrize(
    ("clip", "activity"),
    [
        ("A/Typing.fbx", "typing"),
        ("A/Eating.fbx", "eating"),
        ("A/Sitting.fbx", BY_POSTURE),
        ("walk/dataset-2_walk_elderly_009.bvh", "walking"),
        ("A/Ascending Stairs.fbx", "ascending stairs"),
    ],
)
def test_a_clip_is_known_by_its_name(clip, activity):
    assert PROTOCOL.match(clip).activity == activity


@pytest.mark.parametrize("clip", ["hop/mm_hopBothLegs3hops_001.bvh", "06_04.bvh", "a27_s1_t1"])
def test_what_shows_something_else_takes_no_part(clip):
    assert PROTOCOL.match(clip) is None


def test_activities_are_the_data_sets():
    theirs = [name for names in PROTOCOL.real.values() for name in names]
    assert set(theirs) <= set(MIGHAR_ACTIVITIES)
    assert len(theirs) == len(set(theirs))
    assert set(PROTOCOL.real) == set(ACTIVITIES)
    assert tuple(PROTOCOL.sites) == ("left wrist", "vertex 7", "chest")
    assert PROTOCOL.activity_of("eatingpasta") == "eating"
