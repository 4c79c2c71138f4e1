# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do between exercises: it is what its name says, and a person's motion."""

import numpy as np
import pytest

from w2w_studies.rehab.background import BACKGROUND
from w2w_studies.rehab.clips import generate_clip
from w2w_studies.rehab.skeleton import BONE_INDEX, SIDES
from w2w_studies.rehab.stairs import LEVEL

PEOPLE = range(3)


def at(clip, name):
    return clip.joints()[:, BONE_INDEX[name]]


@pytest.fixture(scope="module")
def clips():
    return {name: [generate_clip(name, number, 5) for number in PEOPLE] for name in BACKGROUND}


def test_every_clip_is_a_possible_motion(clips):
    for found in clips.values():
        for clip in found:
            acceleration = np.linalg.norm(np.diff(clip.joints(), 2, axis=0), axis=-1) * clip.rate**2
            assert acceleration.max() < 40.0
            for side in SIDES:
                ball = at(clip, f"{side}ToeBase")
                above = ball[:, 2] - clip.figure.ball_height
                assert above.min() > -0.008
                planted = np.abs(above) < 1e-5
                both = planted[1:] & planted[:-1]
                assert both.mean() > 0.15
                assert np.linalg.norm(np.diff(ball, axis=0), axis=1)[both].max() < 1e-3


def test_who_stands_or_sits_stays_there(clips):
    for name, low, high in (("standing", 0.9, 1.1), ("sitting", 0.5, 0.75)):
        for clip in clips[name]:
            hip = at(clip, "LeftUpLeg")
            assert low < hip[:, 2].mean() / clip.figure.hip_height < high
            assert np.ptp(hip[:, :2], axis=0).max() < 0.2
            assert np.ptp(hip[:, 2]) < 0.1


def test_who_reaches_moves_a_hand_far_from_the_shoulder_line(clips):
    for clip in clips["reaching"]:
        far = max(np.ptp(at(clip, f"{side}Hand"), axis=0).max() for side in SIDES)
        assert far > 0.2
        assert np.ptp(at(clip, "LeftFoot"), axis=0).max() < 0.05


def test_who_walks_gets_on_step_by_step_on_the_level(clips):
    for clip in clips["walking"]:
        left, right = (at(clip, f"{side}ToeBase") for side in SIDES)
        way = left[0, 1] - left[-1, 1]
        assert way / LEVEL.run == pytest.approx(round(way / LEVEL.run), abs=1e-6)
        assert way > 3 * LEVEL.run
        np.testing.assert_allclose(left[-1, 1:], right[-1, 1:], atol=1e-6)
        assert np.ptp(at(clip, "Hips")[:, 2]) < 0.12
        moving = [np.linalg.norm(np.diff(ball, axis=0), axis=1) > 1e-4 for ball in (left, right)]
        assert not (moving[0] & moving[1]).any()
        hands = at(clip, "LeftHand")[:, 1] - at(clip, "RightHand")[:, 1]
        feet = at(clip, "LeftFoot")[:, 1] - at(clip, "RightFoot")[:, 1]
        assert np.corrcoef(hands, feet)[0, 1] < -0.4
