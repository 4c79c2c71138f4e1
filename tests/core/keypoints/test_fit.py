# SPDX-License-Identifier: GPL-3.0-or-later
"""A body whose rotations are known is seen as joint positions, and its rotations are found again."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.keypoints.fit import fit_keypoints, seen_joints
from w2w.core.keypoints.joint_sets import JOINT_SETS, mirrored
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.sight import UPS
from w2w.core.motion.skinning import joint_transforms, on_the_ground

from ...seen_joints import seen_as

BODY_34 = JOINT_SETS["body-34"]
HUMAN36M_17 = JOINT_SETS["human36m-17"]
KINECT_20 = JOINT_SETS["kinect-20"]
MM_FIT_17 = JOINT_SETS["mm-fit-17"]

RATE = 30.0
NOISE = 0.01
"""Metres along each axis: about what good video pose reaches."""

LIMBS = [
    (f"{side}_{start}", f"{side}_{end}")
    for side in ("left", "right")
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
]


def directions(body, motion):
    positions = joint_transforms(body, motion)[1]
    bones = np.stack([positions[:, JOINT_INDEX[b]] - positions[:, JOINT_INDEX[a]] for a, b in LIMBS], axis=1)
    return bones / np.linalg.norm(bones, axis=2, keepdims=True)


def angle_between(a, b):
    """Degrees between unit vectors."""
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)))


def error_of_rotations(body, first, second):
    """Degrees between the world rotations of two motions, shape (T, 24)."""
    a, b = (joint_transforms(body, motion)[0] for motion in (first, second))
    relative = (a.swapaxes(-1, -2) @ b).reshape(-1, 3, 3)
    return np.degrees(Rotation.from_matrix(relative).magnitude()).reshape(-1, N_JOINTS)


def anatomical(seconds=8.0, seed=0):
    """A motion within human ranges whose elbows and knees are hinges, four seconds a swing or more."""
    rng = np.random.default_rng(seed)
    time = np.arange(int(seconds * RATE)) / RATE

    def wave(low, high):
        rate, phase = rng.uniform(0.1, 0.25), rng.uniform(0, 2 * np.pi)
        return np.radians(low + (high - low) * (0.5 + 0.5 * np.sin(2 * np.pi * rate * time + phase)))

    euler = lambda x, y, z: Rotation.from_euler("xyz", np.stack([x, y, z], axis=1)).as_matrix()  # noqa: E731
    still = 0 * time
    rotations = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
    rotations[:, 0] = euler(wave(-10, 10), wave(-8, 8), wave(-60, 60))
    for third in (1, 2, 3):
        rotations[:, third * 3] = euler(wave(0, 5), still, wave(-3, 3))
    for side, sign in (("left", 1), ("right", -1)):
        turn = lambda x, y, z, sign=sign: euler(x, sign * y, sign * z)  # noqa: E731
        index = lambda part, side=side: JOINT_INDEX[f"{side}_{part}"]  # noqa: E731
        rotations[:, index("hip")] = turn(wave(-70, 10), wave(-20, 10), wave(-15, 15))
        rotations[:, index("knee")] = turn(wave(15, 100), still, still)
        rotations[:, index("shoulder")] = turn(wave(-30, 30), wave(10, 70), wave(-60, 10))
        rotations[:, index("elbow")] = turn(still, still, wave(-110, -25)) @ turn(wave(-40, 40), still, still)
    pelvis = np.stack([0.4 * time, 0.1 * np.sin(time), 0.95 + 0 * time], axis=1)
    return Motion(rotations, pelvis, RATE)


def noisy(points, deviation=NOISE, seed=1):
    return points + deviation * np.random.default_rng(seed).standard_normal(points.shape)


@pytest.fixture(scope="module")
def walk(shared_data, bundled_body):
    """Real motion capture of an SMPL body."""
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    step = round(motion.rate / RATE)
    return Motion(motion.rotations[::step], motion.pelvis[::step], motion.rate / step)


@pytest.mark.parametrize("joint_set", JOINT_SETS.values(), ids=lambda joint_set: joint_set.name)
def test_limb_directions_of_motion_capture_come_back_from_noisy_joints(joint_set, bundled_body, walk):
    fit = fit_keypoints(noisy(seen_as(joint_set, bundled_body, walk)), walk.rate, joint_set, bundled_body)
    error = angle_between(directions(bundled_body, walk), directions(bundled_body, fit.motion))
    assert np.median(error) < 2.0
    assert np.percentile(error, 95) < 6.0
    assert fit.scale == pytest.approx(1, abs=0.02)
    assert not fit.exchanged


def test_without_noise_directions_are_exact_and_twists_follow_the_hinges(bundled_body):
    truth = anatomical()
    fit = fit_keypoints(seen_as(KINECT_20, bundled_body, truth), RATE, KINECT_20, bundled_body)
    assert (
        np.median(angle_between(directions(bundled_body, truth), directions(bundled_body, fit.motion))) < 0.2
    )
    error = np.median(error_of_rotations(bundled_body, truth, fit.motion), axis=0)
    for part in ("hip", "knee", "shoulder"):
        assert error[JOINT_INDEX[f"left_{part}"]] < 6, part
        assert error[JOINT_INDEX[f"right_{part}"]] < 6, part


@pytest.mark.parametrize("seed", range(3))
def test_twists_stay_sensible_with_noise(bundled_body, seed):
    truth = anatomical(seed=seed)
    points = noisy(seen_as(HUMAN36M_17, bundled_body, truth), seed=seed)
    error = error_of_rotations(
        bundled_body, truth, fit_keypoints(points, RATE, HUMAN36M_17, bundled_body).motion
    )
    for part in ("hip", "knee", "shoulder"):
        assert np.median(error[:, JOINT_INDEX[f"left_{part}"]]) < 12, part


def test_hands_show_how_the_forearm_turns(bundled_body):
    truth = anatomical()
    wrists = [JOINT_INDEX["left_wrist"], JOINT_INDEX["right_wrist"]]
    errors = {}
    for joint_set in (BODY_34, KINECT_20):
        points = noisy(seen_as(joint_set, bundled_body, truth), 0.003)
        fit = fit_keypoints(points, RATE, joint_set, bundled_body)
        errors[joint_set.name] = np.median(error_of_rotations(bundled_body, truth, fit.motion)[:, wrists])
    assert errors[BODY_34.name] < 8 < errors[KINECT_20.name]


@pytest.mark.parametrize(
    ("up", "turn"), [("z", [0, 0, 0]), ("y", [-90, 0, 0]), ("-y", [90, 0, 0]), ("x", [0, 90, 0])]
)
@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_axes_and_units_do_not_matter(bundled_body, up, turn, unit):
    truth = anatomical(3)
    points = seen_as(KINECT_20, bundled_body, truth)
    there = Rotation.from_euler("xyz", turn, degrees=True).as_matrix()
    expected = fit_keypoints(points, RATE, KINECT_20, bundled_body)
    assert seen_joints(unit * points @ there.T, KINECT_20).upright.argmax() == UPS.index(up)
    fit = fit_keypoints(unit * points @ there.T, RATE, KINECT_20, bundled_body, up=up)
    assert fit.scale == pytest.approx(expected.scale / unit)
    # the heading about the vertical is free
    np.testing.assert_allclose(fit.motion.rotations[:, 1:], expected.motion.rotations[:, 1:], atol=1e-6)
    np.testing.assert_allclose(fit.motion.pelvis[:, 2], expected.motion.pelvis[:, 2], atol=1e-6)


def test_left_and_right_swapped_in_some_frames_are_put_back(bundled_body, walk):
    points = noisy(seen_as(KINECT_20, bundled_body, walk), 0.005)
    broken = points.copy()
    swapped = np.zeros((len(points), 2), dtype=bool)
    swapped[20:27, 1] = swapped[40:41, 1] = swapped[33:50, 0] = True
    for column, parts in ((0, ("shoulder", "elbow", "wrist")), (1, ("hip", "knee", "ankle", "foot"))):
        frames = np.flatnonzero(swapped[:, column])
        for part in parts:
            left, right = (KINECT_20.joints.index(f"{side}_{part}") for side in ("left", "right"))
            broken[np.ix_(frames, [left, right])] = points[np.ix_(frames, [right, left])]
    fit = fit_keypoints(broken, walk.rate, KINECT_20, bundled_body)
    expected = fit_keypoints(points, walk.rate, KINECT_20, bundled_body).motion
    np.testing.assert_allclose(fit.motion.rotations, expected.rotations, atol=1e-6)


def test_sides_exchanged_throughout_are_found_by_the_way_knees_bend(bundled_body):
    truth = anatomical()
    points = seen_as(MM_FIT_17, bundled_body, truth)
    other = [
        MM_FIT_17.joints.index(mirrored(joint.replace("_", " ")).replace(" ", "_"))
        for joint in MM_FIT_17.joints
    ]
    fit = fit_keypoints(points[:, other], RATE, MM_FIT_17, bundled_body)
    assert fit.exchanged
    expected = fit_keypoints(points, RATE, MM_FIT_17, bundled_body)
    assert not expected.exchanged
    np.testing.assert_allclose(fit.motion.rotations, expected.motion.rotations, atol=1e-9)


def test_lost_joints_and_jumps_hardly_show(bundled_body, walk):
    points = noisy(seen_as(KINECT_20, bundled_body, walk), 0.005)
    rng = np.random.default_rng(0)
    broken = points.copy()
    broken[rng.random(points.shape[:2]) < 0.1] = np.nan
    jumps = np.argwhere(rng.random(points.shape[:2]) < 0.01)
    broken[tuple(jumps.T)] += 0.5
    fit = fit_keypoints(broken, walk.rate, KINECT_20, bundled_body)
    error = angle_between(directions(bundled_body, walk), directions(bundled_body, fit.motion))
    assert np.median(error) < 2
    assert np.percentile(error, 95) < 8


def test_a_joint_never_seen_leaves_its_limb_hanging_from_the_one_before(bundled_body):
    truth = anatomical(3)
    points = seen_as(KINECT_20, bundled_body, truth)
    points[
        :, [KINECT_20.joints.index(name) for name in ("left_wrist", "left_hand", "right_foot", "head")]
    ] = np.nan
    fit = fit_keypoints(points, RATE, KINECT_20, bundled_body)
    np.testing.assert_allclose(
        fit.motion.rotations[:, JOINT_INDEX["left_elbow"]], np.tile(np.eye(3), (len(points), 1, 1)), atol=1e-9
    )
    error = angle_between(directions(bundled_body, truth), directions(bundled_body, fit.motion))
    seen = [number for number, limb in enumerate(LIMBS) if limb[1] != "left_wrist"]
    assert np.median(error[:, seen], axis=0).max() < 1


def test_joints_do_not_bend_the_wrong_way(bundled_body):
    """A shank seen in front of the thigh is noise: knees do not."""
    truth = anatomical(3)
    for joint in ("left_knee", "right_knee"):
        truth.rotations[:, JOINT_INDEX[joint]] = Rotation.from_euler("x", -40, degrees=True).as_matrix()
    truth.rotations[:, [JOINT_INDEX["left_hip"], JOINT_INDEX["right_hip"]]] = np.eye(3)
    points = seen_as(KINECT_20, bundled_body, truth)
    knee = fit_keypoints(points, RATE, KINECT_20, bundled_body).motion.rotations[:, JOINT_INDEX["left_knee"]]
    bend = np.degrees(Rotation.from_matrix(knee).as_rotvec()[:, 0])
    assert bend.min() > -10.5


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda points: points[:, :5], "must have shape"),
        (lambda points: points[:1], "two frames"),
        (lambda points: points * np.nan, "can hardly ever be seen"),
        (lambda points: points * 0, "same place"),
    ],
)
def test_what_is_no_body_is_refused(bundled_body, spoil, message):
    points = seen_as(KINECT_20, bundled_body, anatomical(1))
    with pytest.raises(ValueError, match=message):
        fit_keypoints(spoil(points), RATE, KINECT_20, bundled_body)
