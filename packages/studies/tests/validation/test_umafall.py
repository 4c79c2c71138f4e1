# SPDX-License-Identifier: GPL-3.0-or-later
"""UMAFall's protocol names its clips, and finds where in a long trial people move."""

import numpy as np
import pytest

from w2w.core.imu.recording import ImuRecording
from w2w_studies.datasets.umafall import UMAFALL_ACTIVITIES, UMAFALL_SITES
from w2w_studies.validation.umafall import ACTIVITIES, UMAFALL, most_moving


@pytest.mark.parametrize(
    ("clip", "expected"),
    [
        ("jog/bd_jogLeftCircle4StepsRstart_001.bvh", ("jog", "HDM05", "HDM05 bd")),
        ("lie_down/tr_lieDownFloor_001.bvh", ("lie down", "HDM05", "HDM05 tr")),
        ("walk/dataset-2_walk_elderly_009.bvh", ("walk", "Bandai-Namco", "Bandai-Namco elderly")),
        ("A/Walking (1).fbx", ("walk", "Mixamo", "Mixamo A/Walking (1).fbx")),
        ("a24_s1_t1", ("sit down or get up", "UTD-MHAD", "UTD-MHAD s1")),
    ],
)
def test_a_clip_is_known_by_its_name(clip, expected):
    assert tuple(UMAFALL.match(clip)) == expected


@pytest.mark.parametrize(
    "clip",
    ["walk_turn_left/dataset-2_walk-turn-left_old_1.bvh", "truncated_50pct_Walking.fbx", "Sneak Walk.fbx",
     "sneak/bd_sneak_001.bvh", "X/Walking Turn 180.fbx", "06_04.bvh"],
)  # fmt: skip
def test_what_shows_something_else_takes_no_part(clip):
    assert UMAFALL.match(clip) is None


def test_activities_have_one_name_or_none():
    assert set(UMAFALL.real) == set(ACTIVITIES)
    assert {name for theirs in UMAFALL.real.values() for name in theirs} <= set(UMAFALL_ACTIVITIES)
    assert tuple(UMAFALL.sites) == UMAFALL_SITES


def test_the_stretch_in_which_all_sites_move_most_is_found():
    acc = np.zeros((300, 4, 3))
    acc[..., 2] = 9.8
    acc[150:240, :, 2] += 3 * np.sin(np.arange(90))[:, None]
    acc[10, 0] = np.nan
    found = most_moving(ImuRecording(acc, np.zeros_like(acc), 20.0, UMAFALL_SITES, "Bending", "s1", "c"))
    assert found.n_samples == 120
    assert found.acc[:, 0, 2].std() > 1.5
    assert (found.activity, found.subject, found.clip) == ("Bending", "s1", "c")
    short = most_moving(ImuRecording(acc[:50], np.zeros((50, 4, 3)), 20.0))
    assert short.n_samples == 50
