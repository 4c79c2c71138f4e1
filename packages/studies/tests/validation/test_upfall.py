# SPDX-License-Identifier: GPL-3.0-or-later
"""UP-Fall's protocol names its clips, and its sites are regions of the body."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.body_parts import patches_named
from w2w.core.patches.patches import sample_patches
from w2w_studies.comparisons.unpaired import real_side
from w2w_studies.datasets.upfall import UPFALL_ACTIVITIES, UPFALL_RATE, UPFALL_SITES
from w2w_studies.validation.protocol import BY_POSTURE
from w2w_studies.validation.upfall import ACTIVITIES, MERGED, NEITHER, UPFALL


@pytest.mark.parametrize(
    ("clip", "activity"),
    [
        ("pick_up/bd_depositFloorR_001.bvh", "picking up an object"),
        ("walk/dataset-2_walk_elderly_009.bvh", "walking"),
        ("hop/mm_hopBothLegs3hops_001.bvh", "jumping"),
        ("A/Breathing Idle.fbx", BY_POSTURE),
    ],
)
def test_a_clip_is_known_by_its_name(clip, activity):
    assert UPFALL.match(clip).activity == activity


@pytest.mark.parametrize("clip", ["jog/bd_jog_001.bvh", "lie_down/tr_lieDownFloor_001.bvh", "06_04.bvh"])
def test_what_shows_something_else_takes_no_part(clip):
    assert UPFALL.match(clip) is None


def test_activities_and_sites_are_the_data_sets(bundled_body):
    assert {name for theirs in UPFALL.real.values() for name in theirs} <= set(UPFALL_ACTIVITIES.values())
    assert set(UPFALL.real) == set(ACTIVITIES)
    assert tuple(UPFALL.sites) == UPFALL_SITES
    regions = sample_patches(bundled_body).regions
    assert all(len(patches_named(regions, words)) for words in UPFALL.sites.values())
    assert all(analysis.cutoff_hz < UPFALL.rate_hz / 2 for analysis in UPFALL.analyses)


@pytest.mark.parametrize(
    ("analysis", "left"),
    [
        (MERGED, {"walking", "standing or sitting", "picking up an object", "jumping"}),
        (NEITHER, {"walking", "picking up an object", "jumping"}),
    ],
)
def test_sitting_and_standing_count_as_one_activity_or_take_no_part(analysis, left):
    still = np.zeros((60, len(UPFALL_SITES), 3))
    worn = [
        ImuRecording(still, still, UPFALL_RATE, UPFALL_SITES, clip=name, activity=name, subject="one")
        for name in UPFALL_ACTIVITIES.values()
    ]
    side = real_side(UPFALL, worn, analysis)
    assert {recording.activity for recording in side.recordings} == left
    assert set(side.windows.activity.tolist()) == left
