# SPDX-License-Identifier: GPL-3.0-or-later
"""Exercises done badly: each fault is seen where it should be, and the clip is still a person's."""

import numpy as np
import pytest
from scipy.signal import welch

from w2w_studies.rehab.clips import EXERCISES, generate_clip
from w2w_studies.rehab.executions import FAULTS, TREMOR_BAND, WELL, aged, tremor
from w2w_studies.rehab.session import draw_style
from w2w_studies.rehab.skeleton import BONE_INDEX, SIDES, forward_kinematics

PEOPLE = range(3)


def clips(activity, execution, ages=None):
    return [generate_clip(activity, number, 5, execution=execution, ages=ages) for number in PEOPLE]


def at(clip, name):
    return clip.joints()[:, BONE_INDEX[name]]


def lean(clip):
    """Largest angle of the chest from the upright, degrees."""
    turns, _ = forward_kinematics(clip.figure.rest(), clip.rotations, clip.hips)
    return np.degrees(np.arccos(turns[:, BONE_INDEX["Spine2"], 2, 2])).max()


def of_people(activity, execution, measure):
    return np.mean([measure(clip) for clip in clips(activity, execution)])


def test_well_is_what_it_always_was():
    for activity in EXERCISES:
        plain, well = generate_clip(activity, 1, 5), generate_clip(activity, 1, 5, execution=WELL)
        np.testing.assert_array_equal(plain.rotations, well.rotations)
        assert plain.execution == WELL


@pytest.mark.parametrize(
    ("activity", "fault"), [(a, fault) for a, faults in FAULTS.items() for fault in faults]
)
def test_every_fault_is_a_possible_motion(activity, fault):
    for clip in clips(activity, fault, (25.0, 85.0))[:2]:
        assert clip.execution == fault
        assert np.isfinite(clip.rotations).all()
        joints = clip.joints()
        acceleration = np.linalg.norm(np.diff(joints, 2, axis=0), axis=-1) * clip.rate**2
        assert acceleration.max() < 40.0
        balls = [at(clip, f"{side}ToeBase")[:, 2].min() - clip.figure.ball_height for side in SIDES]
        assert min(balls) > -0.008
        assert (clip.n_frames - 1) / clip.rate <= 13.0


def test_a_compensating_trunk_leans_further():
    for activity in ("sit_to_stand", "arm_raise_band", "one_leg_stand"):
        assert of_people(activity, "trunk", lean) > of_people(activity, WELL, lean) + 3.0


@pytest.mark.slow
def test_half_the_range_is_about_half():
    def risen(clip):
        return np.ptp(at(clip, "Hips")[:, 2])

    def raised(clip):
        hand = max(np.ptp(at(clip, f"{side}Hand")[:, 2]) for side in SIDES)
        return hand / (clip.figure.upper_arm + clip.figure.forearm)

    assert (
        0.35 < of_people("sit_to_stand", "half_range", risen) / of_people("sit_to_stand", WELL, risen) < 0.7
    )
    assert of_people("arm_raise_band", "half_range", raised) < 0.75 * of_people(
        "arm_raise_band", WELL, raised
    )


def test_slow_is_slower():
    def speed(clip):
        return np.linalg.norm(np.diff(at(clip, "Hips"), axis=0), axis=1).max() * clip.rate

    assert of_people("sit_to_stand", "slow", speed) < 0.7 * of_people("sit_to_stand", WELL, speed)


def test_shaky_hands_tremble_in_the_band():
    def share(clip):
        hand = np.diff(at(clip, "LeftHand"), 2, axis=0)
        frequency, power = welch(hand, clip.rate, nperseg=64, axis=0)
        inside = (frequency >= TREMOR_BAND[0] - 0.5) & (frequency <= TREMOR_BAND[1] + 0.5)
        return power[inside].sum() / power.sum()

    assert of_people("one_leg_stand", "shaky", share) > 0.7
    assert of_people("one_leg_stand", WELL, share) < 0.4
    waves = tremor(np.arange(6000) / 60, np.random.default_rng(0), 4)
    np.testing.assert_allclose(waves.std(axis=0), 1.0, atol=0.1)


def test_one_sided_raises_one_arm_more():
    def difference(clip):
        heights = [np.ptp(at(clip, f"{side}Hand")[:, 2]) for side in SIDES]
        return abs(heights[0] - heights[1]) / max(heights)

    assert of_people("arm_raise_band", "one_sided", difference) > 0.3


def test_older_people_are_slower_and_stoop():
    style = draw_style(np.random.default_rng(1))
    young, old = aged(style, 25.0), aged(style, 80.0)
    assert old.tempo < young.tempo
    assert old.sway > young.sway
    assert old.trunk[0] > young.trunk[0] + np.radians(5)
    ages = [generate_clip("sit_to_stand", number, 5, ages=(25.0, 85.0)).style.tempo for number in PEOPLE]
    assert ages != [generate_clip("sit_to_stand", number, 5).style.tempo for number in PEOPLE]


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="stair_climbing cannot be done 'half_range'; there are well, trunk"):
        generate_clip("stair_climbing", 0, execution="half_range")
    with pytest.raises(ValueError, match="standing cannot be done 'slow'"):
        generate_clip("standing", 0, execution="slow")
