# SPDX-License-Identifier: GPL-3.0-or-later
"""Gestures move what their names say, and are a person's motion."""

import numpy as np
import pytest

from w2w_studies.rehab.clips import generate_clip
from w2w_studies.rehab.gestures import GESTURES
from w2w_studies.rehab.skeleton import BONE_INDEX

PEOPLE = range(4)


def at(clip, name):
    return clip.joints()[:, BONE_INDEX[name]]


@pytest.fixture(scope="module")
def clips():
    return {name: [generate_clip(name, number) for number in PEOPLE] for name in GESTURES}


def test_every_clip_is_a_possible_motion(clips):
    for found in clips.values():
        for clip in found:
            acceleration = np.linalg.norm(np.diff(clip.joints(), 2, axis=0), axis=-1) * clip.rate**2
            assert acceleration.max() < 40.0
            assert np.ptp(at(clip, "LeftFoot"), axis=0).max() < 0.05


def test_the_cup_reaches_the_mouth_and_the_left_hand_stays(clips):
    for clip in clips["drink"]:
        to_head = np.linalg.norm(at(clip, "RightHand") - at(clip, "Head"), axis=1)
        assert to_head.min() < 0.3 < to_head.max()
        assert np.ptp(at(clip, "LeftHand")[:, 2]) < 0.15


def test_the_head_nods_about_one_axis_and_shakes_about_another(clips):
    top = {name: [at(clip, "HeadTop_End") - at(clip, "Head") for clip in clips[name]] for name in clips}
    nods = np.mean([np.abs(np.diff(one[:, 1])).mean() for one in top["nod"]])
    shakes = np.mean([np.abs(np.diff(one[:, 1])).mean() for one in top["shake_head"]])
    assert nods > 2 * shakes
