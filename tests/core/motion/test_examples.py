# SPDX-License-Identifier: GPL-3.0-or-later
"""The motions of `w2w demo`: five gestures of eight people, on the ground, whole."""

from collections import Counter

import numpy as np

from w2w.core.motion.examples import DEMO_CLIPS, demo_motions

ACTIVITIES = {"drink", "nod", "shake_head", "stir", "type"}


def test_everybody_makes_every_gesture():
    motions = demo_motions()
    assert Counter(motion.activity for motion in motions.values()) == dict.fromkeys(ACTIVITIES, DEMO_CLIPS)
    for activity in ACTIVITIES:
        subjects = [motion.subject for motion in motions.values() if motion.activity == activity]
        assert subjects == [f"S{number:02d}" for number in range(1, DEMO_CLIPS + 1)]
    assert motions["shake_head_3.npz"].subject == "S03"


def test_they_move_as_people_do():
    for motion in demo_motions().values():
        assert motion.rate == 30
        assert 4 < motion.duration < 20
        assert 0.3 < motion.pelvis[:, 2].min() < motion.pelvis[:, 2].max() < 2.5
        velocity = np.diff(motion.pelvis, axis=0) * motion.rate
        assert np.linalg.norm(velocity, axis=1).max() < 1
        turns = np.einsum("tjba,tjbc->tjac", motion.rotations[:-1], motion.rotations[1:])
        degrees = np.degrees(np.arccos(np.clip((np.trace(turns, axis1=2, axis2=3) - 1) / 2, -1, 1)))
        assert 0.5 < degrees.max() < 15  # of a joint, from one frame to the next


def test_of_each_activity_the_first_are_given():
    few = demo_motions(2)
    assert [motion.subject for motion in few.values()] == ["S01", "S02"] * len(ACTIVITIES)
    whole = demo_motions()
    assert all(np.array_equal(motion.pelvis, whole[file].pelvis) for file, motion in few.items())
