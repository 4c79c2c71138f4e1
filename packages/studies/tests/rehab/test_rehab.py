# SPDX-License-Identifier: GPL-3.0-or-later
"""The generated exercises: smooth, physically possible, and what their names say."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.signal import find_peaks
from scipy.spatial.transform import Rotation

from w2w_studies.rehab.clips import EXERCISES, RehabClip, generate_clip
from w2w_studies.rehab.curves import SWAY_BAND, glide, min_jerk, pulse, soft_excess, soft_limit, sway, through
from w2w_studies.rehab.pose import turn
from w2w_studies.rehab.skeleton import (
    BONE_INDEX,
    BONE_PARENTS,
    BONES,
    SIDES,
    Figure,
    centre_of_mass,
    forward_kinematics,
)
from w2w_studies.rehab.stairs import RISE, RUN

CLIPS = 5
HEEL_BEHIND, TOES_AHEAD = 0.035, 0.117
"""How far a foot reaches behind the ankle and ahead of it, in statures."""

GAP = 0.04
"""Metres between the toes of whoever stands before the stairs and the first riser."""


@pytest.fixture(scope="module")
def clips() -> list[RehabClip]:
    return [generate_clip(activity, number, 3) for activity in EXERCISES for number in range(CLIPS)]


def of(clips: list[RehabClip], activity: str) -> list[RehabClip]:
    return [clip for clip in clips if clip.activity == activity]


def at(joints: np.ndarray, name: str) -> np.ndarray:
    return joints[:, BONE_INDEX[name]]


def world(clip: RehabClip) -> tuple[np.ndarray, np.ndarray]:
    return forward_kinematics(clip.figure.rest(), clip.rotations, clip.hips)


def bend(joints: np.ndarray, first: str, middle: str, last: str) -> np.ndarray:
    """Angle between two bones in degrees, 0 straight."""
    upper, lower = at(joints, middle) - at(joints, first), at(joints, last) - at(joints, middle)
    cosine = np.sum(upper * lower, axis=1) / np.linalg.norm(upper, axis=1) / np.linalg.norm(lower, axis=1)
    return np.degrees(np.arccos(cosine))


def sole_points(clip: RehabClip, side: str) -> np.ndarray:
    """Heel, ball and tip of the toes on the sole, shape (3, T, 3)."""
    turns, joints = world(clip)
    heel = np.array([0.0, HEEL_BEHIND * clip.figure.stature, -clip.figure.ankle_height])
    below = np.array([0.0, 0.0, -clip.figure.ball_height])
    foot, toes = turns[:, BONE_INDEX[side + "Foot"]], turns[:, BONE_INDEX[side + "ToeBase"]]
    return np.stack(
        [
            at(joints, side + "Foot") + foot @ heel,
            at(joints, side + "ToeBase") + toes @ below,
            at(joints, side + "Toe_End") + toes @ below,
        ]
    )


def ground(clip: RehabClip, y: np.ndarray) -> np.ndarray:
    if clip.activity != "stair_climbing":
        return np.zeros_like(y)
    first = TOES_AHEAD * clip.figure.stature + GAP
    return RISE * np.maximum(np.floor((-y - first) / RUN) + 1, 0)


class TestCurves:
    def test_min_jerk_starts_and_ends_at_rest(self):
        step = 1e-4
        s = np.array([0.0, step, 2 * step, 1 - 2 * step, 1 - step, 1.0])
        value = min_jerk(s)
        assert value[0] == 0.0
        assert value[-1] == 1.0
        assert abs(value[2] - 2 * value[1]) / step**2 < 0.1
        assert min_jerk(0.5) == pytest.approx(0.5)

    @given(st.floats(-3.0, 3.0), st.floats(0.01, 2.0))
    def test_soft_excess_is_never_below_the_sharp_one_and_exact_outside_its_band(self, value, band):
        soft = float(soft_excess(np.array(value), band))
        assert soft >= max(value, 0.0) - 1e-12
        assert soft - max(value, 0.0) <= 0.16 * band
        if abs(value) >= band:
            assert soft == pytest.approx(max(value, 0.0), abs=1e-12)

    @given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
    def test_soft_limit_keeps_the_limit(self, value, limit):
        held = float(soft_limit(np.array(value), limit, 0.2))
        assert held <= min(value, limit) + 1e-12

    def test_pulse_and_through_pass_their_knots(self):
        time = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
        np.testing.assert_allclose(pulse(time, 0.0, 1.0, 3.0, 4.0), [0, 1, 1, 1, 0], atol=1e-12)
        np.testing.assert_allclose(through(time, [0, 1, 3], [5.0, -1.0, 2.0]), [5, -1, 0.5, 2, 2], atol=1e-12)

    def test_glide_is_the_convolution_with_a_gaussian(self):
        knots, values, blur = [1.0, 2.0, 4.0], [0.0, 3.0, 2.0], 0.25
        offsets = np.linspace(-8.0, 8.0, 32001) * blur
        kernel = np.exp(-0.5 * (offsets / blur) ** 2)
        kernel /= kernel.sum()
        time = np.array([0.5, 1.0, 1.7, 2.0, 3.3, 4.1])
        expected = np.interp(time[:, None] - offsets, knots, values) @ kernel
        np.testing.assert_allclose(glide(time, knots, values, blur), expected, atol=1e-6)

    def test_sway_has_unit_variance_and_stays_in_its_band(self):
        rate, seconds = 30.0, 400.0
        time = np.arange(int(seconds * rate)) / rate
        curves = sway(time, np.random.default_rng(0), 6)
        np.testing.assert_allclose(curves.std(axis=0), 1.0, atol=0.08)
        power = np.abs(np.fft.rfft(curves * np.hanning(len(time))[:, None], axis=0)) ** 2
        frequency = np.fft.rfftfreq(len(time), 1 / rate)
        outside = (frequency < SWAY_BAND[0] - 0.01) | (frequency > SWAY_BAND[1] + 0.01)
        assert power[outside].sum() / power.sum() < 1e-4


def test_turns_mean_what_they_say():
    pitch, left, yaw = turn(np.eye(3) * 0.3)
    assert (pitch @ [0, 0, 1])[1] < 0
    assert (left @ [0, 0, 1])[0] > 0
    assert (yaw @ [0, -1, 0])[0] > 0


class TestFigure:
    @given(st.floats(1.4, 2.1), st.floats(0.9, 1.1), st.floats(0.9, 1.1), st.floats(0.85, 1.15))
    def test_rest_pose_has_the_stature_and_stands_on_the_floor(self, stature, legs, arms, breadth):
        figure = Figure(stature, legs, arms, breadth)
        rest = figure.rest()
        assert rest[BONE_INDEX["HeadTop_End"], 2] == pytest.approx(stature)
        assert rest[:, 2].min() == pytest.approx(figure.ball_height)
        for name in (name for name in BONES if name.startswith("Left")):
            other = rest[BONE_INDEX[name.replace("Left", "Right")]]
            np.testing.assert_allclose(rest[BONE_INDEX[name]] * [-1, 1, 1], other, atol=1e-12)
        arm = rest[BONE_INDEX["LeftHand"]] - rest[BONE_INDEX["LeftArm"]]
        np.testing.assert_allclose(arm, [figure.upper_arm + figure.forearm, 0, 0], atol=1e-12)

    def test_centre_of_mass_is_where_people_have_it(self):
        # 54 to 57 % of stature in the anatomical position, a little more with the arms raised to a T
        centre = centre_of_mass(Figure().rest())
        assert centre[0] == pytest.approx(0.0)
        assert 0.54 < centre[2] / 1.70 < 0.60

    def test_impossible_sizes_are_refused(self):
        with pytest.raises(ValueError, match="stature"):
            Figure(stature=17.0)
        with pytest.raises(ValueError, match="legs"):
            Figure(legs=2.0)

    def test_bones_are_named_and_ordered_as_a_tree(self):
        assert len(set(BONES)) == len(BONES) == 27
        assert BONE_PARENTS[0] == -1
        assert all(parent < bone for bone, parent in enumerate(BONE_PARENTS))


class TestEveryExercise:
    def test_rotations_are_rotations(self, clips):
        for clip in clips:
            product = clip.rotations @ clip.rotations.transpose(0, 1, 3, 2)
            assert np.abs(product - np.eye(3)).max() < 1e-9
            assert np.linalg.det(clip.rotations).min() > 0.999

    def test_bones_keep_their_lengths(self, clips):
        for clip in clips:
            rest, joints = clip.figure.rest(), clip.joints()
            for bone, parent in enumerate(BONE_PARENTS[1:], start=1):
                length = np.linalg.norm(joints[:, bone] - joints[:, parent], axis=1)
                np.testing.assert_allclose(length, np.linalg.norm(rest[bone] - rest[parent]), rtol=1e-9)

    def test_clips_last_four_to_ten_seconds_and_begin_and_end_still(self, clips):
        for clip in clips:
            assert 4.0 <= (clip.n_frames - 1) / clip.rate <= 10.0
            joints = clip.joints()
            quiet = int(0.2 * clip.rate)
            for name, fastest in (("Hips", 0.2), ("LeftFoot", 0.02), ("RightFoot", 0.02), ("LeftHand", 0.7)):
                speed = np.linalg.norm(np.diff(at(joints, name), axis=0), axis=-1) * clip.rate
                assert speed[:quiet].max() < fastest
                assert speed[-quiet:].max() < fastest

    def test_planted_feet_do_not_slide(self, clips):
        for clip in clips:
            joints = clip.joints()
            for side in SIDES:
                ball = at(joints, side + "ToeBase")
                above = ball[:, 2] - clip.figure.ball_height - ground(clip, ball[:, 1])
                planted = np.abs(above) < 1e-5
                both = planted[1:] & planted[:-1]
                assert both.mean() > 0.15
                assert np.linalg.norm(np.diff(ball, axis=0), axis=1)[both].max() < 5e-4

    def test_feet_stay_above_the_ground(self, clips):
        for clip in clips:
            for side in SIDES:
                points = sole_points(clip, side)
                assert (points[..., 2] - ground(clip, points[..., 1])).min() > -0.005

    def test_knees_and_elbows_bend_the_right_way_and_no_further_than_people_do(self, clips):
        for clip in clips:
            turns, joints = world(clip)
            for side in SIDES:
                knee = bend(joints, side + "UpLeg", side + "Leg", side + "Foot")
                elbow = bend(joints, side + "Arm", side + "ForeArm", side + "Hand")
                assert knee.min() > 2.0
                assert knee.max() < 135.0
                assert elbow.min() > 3.0
                assert elbow.max() < 145.0
                middle = (at(joints, side + "UpLeg") + at(joints, side + "Foot")) / 2
                forward = turns[:, BONE_INDEX["Hips"]] @ np.array([0.0, -1.0, 0.0])
                assert np.sum((at(joints, side + "Leg") - middle) * forward, axis=1).min() > 0
                flexion = (
                    turns[:, BONE_INDEX[side + "Arm"]].transpose(0, 2, 1)
                    @ (turns[:, BONE_INDEX[side + "ForeArm"]])
                )
                inward = Rotation.from_matrix(flexion).as_rotvec()[:, 2]
                assert (inward * (-1 if side == "Left" else 1)).min() > 0

    def test_speeds_and_accelerations_are_human(self, clips):
        for clip in clips:
            turns, joints = world(clip)
            acceleration = np.diff(joints, 2, axis=0) * clip.rate**2
            assert np.linalg.norm(acceleration, axis=-1).max() < 40.0
            steps = turns[:-1].transpose(0, 1, 3, 2) @ turns[1:]
            rates = Rotation.from_matrix(steps.reshape(-1, 3, 3)).as_rotvec() * clip.rate
            assert np.linalg.norm(rates, axis=-1).max() < 8.0

    @pytest.mark.parametrize("activity", EXERCISES)
    def test_accelerations_are_continuous(self, activity):
        # where acceleration is continuous, its steps from frame to frame shrink with the frames
        largest = []
        for rate in (120.0, 480.0):
            joints = generate_clip(activity, 1, seed=3, rate=rate).joints()
            acceleration = np.diff(joints, 2, axis=0) * rate**2
            largest.append(np.abs(np.diff(acceleration, axis=0)).max())
        assert largest[1] < 0.4 * largest[0]

    def test_head_stays_level(self, clips):
        for clip in clips:
            turns, _ = world(clip)
            up = turns[:, BONE_INDEX["Head"]] @ np.array([0.0, 0.0, 1.0])
            assert np.degrees(np.arccos(up[:, 2])).max() < 35.0

    def test_the_frame_rate_changes_the_sampling_only(self):
        for activity in EXERCISES:
            slow, fast = (generate_clip(activity, 2, rate=rate) for rate in (30.0, 60.0))
            shared = min(slow.n_frames, (fast.n_frames + 1) // 2)
            np.testing.assert_allclose(fast.hips[::2][:shared], slow.hips[:shared], atol=1e-9)

    def test_seed_and_number_decide_everything(self, clips):
        for clip in clips[:: CLIPS - 1]:
            again = generate_clip(clip.activity, clip.number, seed=3)
            np.testing.assert_array_equal(again.rotations, clip.rotations)
            other = generate_clip(clip.activity, clip.number, seed=4)
            assert other.figure != clip.figure
            assert other.style != clip.style

    def test_the_same_number_is_the_same_person_in_another_mood(self, clips):
        for number in range(CLIPS):
            people = [clip for clip in clips if clip.number == number]
            assert len({clip.figure for clip in people}) == 1
            assert len({clip.style for clip in people}) == len(EXERCISES)
            assert len({clip.subject for clip in people}) == 1
        assert len({clip.figure for clip in clips}) == CLIPS

    def test_wrong_requests_are_refused(self):
        with pytest.raises(ValueError, match="stair_climbing"):
            generate_clip("juggling", 0)
        with pytest.raises(ValueError, match="negative"):
            generate_clip("sit_to_stand", -1)
        with pytest.raises(ValueError, match="rate"):
            generate_clip("sit_to_stand", 0, rate=0.0)


class TestSitToStand:
    def test_pelvis_goes_between_the_seat_and_standing(self, clips):
        for clip in of(clips, "sit_to_stand"):
            height = at(clip.joints(), "LeftUpLeg")[:, 2]
            assert 0.48 < height.min() < 0.58
            assert height.max() > 0.97 * clip.figure.hip_height

    def test_trunk_leans_before_the_seat_is_left(self, clips):
        for clip in of(clips, "sit_to_stand"):
            turns, joints = world(clip)
            up = turns[:, BONE_INDEX["Spine2"]] @ np.array([0.0, 0.0, 1.0])
            lean = np.degrees(np.arctan2(-up[:, 1], up[:, 2]))
            height = at(joints, "LeftUpLeg")[:, 2]
            off = np.flatnonzero((height[1:] > height.min() + 0.03) & (height[:-1] <= height.min() + 0.03))
            assert len(off) >= 1
            assert lean[off].min() > 15.0
            assert np.abs(lean[height > 0.995 * height.max()]).max() < 25.0


class TestStairClimbing:
    def test_feet_end_side_by_side_a_whole_number_of_steps_up(self, clips):
        for clip in of(clips, "stair_climbing"):
            joints = clip.joints()
            left, right = (at(joints, side + "ToeBase") for side in SIDES)
            climbed = (left[-1] - left[0])[2] / RISE
            assert climbed == pytest.approx(round(climbed), abs=1e-6)
            assert round(climbed) >= 2
            np.testing.assert_allclose((left[-1] - left[0])[1], -round(climbed) * RUN, atol=1e-6)
            np.testing.assert_allclose(left[-1, 1:], right[-1, 1:], atol=1e-6)
            assert (clip.hips[-1] - clip.hips[0])[2] == pytest.approx(climbed * RISE, abs=0.02)

    def test_one_foot_always_stands(self, clips):
        for clip in of(clips, "stair_climbing"):
            joints = clip.joints()
            moving = [
                np.linalg.norm(np.diff(at(joints, side + "ToeBase"), axis=0), axis=1) > 1e-4 for side in SIDES
            ]
            assert not (moving[0] & moving[1]).any()
            assert (moving[0] | moving[1]).mean() > 0.4

    def test_arms_swing_against_the_legs(self, clips):
        for clip in of(clips, "stair_climbing"):
            joints = clip.joints()
            hands = at(joints, "LeftHand")[:, 1] - at(joints, "RightHand")[:, 1]
            feet = at(joints, "LeftFoot")[:, 1] - at(joints, "RightFoot")[:, 1]
            assert np.corrcoef(hands, feet)[0, 1] < -0.5


class TestArmRaise:
    def test_hands_go_up_and_down_while_the_feet_stay(self, clips):
        repetitions, sides = [], []
        for clip in of(clips, "arm_raise_band"):
            joints = clip.joints()
            peaks = []
            for side in SIDES:
                raised = at(joints, side + "Hand")[:, 2] - at(joints, side + "Arm")[:, 2]
                peaks.append(len(find_peaks(raised, prominence=0.2)[0]))
                assert np.ptp(at(joints, side + "ToeBase"), axis=0).max() < 1e-6
            assert max(peaks) >= 1
            repetitions.append(max(peaks))
            sides.append(np.count_nonzero(peaks))
            assert np.ptp(clip.hips, axis=0).max() < 0.12
        assert np.mean(repetitions) > 1.5
        assert set(sides) == {1, 2}

    def test_some_sit_and_some_stand(self):
        heights = [generate_clip("arm_raise_band", number).hips[:, 2].mean() for number in range(8)]
        assert min(heights) < 0.7
        assert max(heights) > 0.8


class TestOneLegStand:
    def test_a_foot_is_held_up_with_the_centre_of_mass_over_the_other(self, clips):
        for clip in of(clips, "one_leg_stand"):
            joints = clip.joints()
            centre = centre_of_mass(joints)
            held = 0
            for side, other in (SIDES, SIDES[::-1]):
                ankle = at(joints, other + "Foot")
                up = ankle[:, 2] > ankle[:, 2].min() + 0.8 * np.ptp(ankle[:, 2])
                if ankle[:, 2].max() < clip.figure.ankle_height + 0.02:
                    continue
                held += up.sum() / clip.rate
                support = sole_points(clip, side)[:, up]
                inside = centre[up] - at(joints, side + "Foot")[up]
                assert np.abs(inside[:, 0]).max() < 0.055
                assert (centre[up, 1] < support[0, :, 1]).all()
                assert (centre[up, 1] > support[2, :, 1]).all()
            assert held > 0.8
