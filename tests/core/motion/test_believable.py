# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions that a body can make: what is cut off at the ends, what is refused, what is kept."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.files import write_npz
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.motion.believable import believed, moving_part
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.reading.clips import to_body
from w2w.core.reading.formats import read_motion

from ...made_bvh import write_bvh

RATE = 60.0
LIMBS = [JOINT_INDEX[f"{side}_{joint}"] for side in ("left", "right") for joint in ("hip", "shoulder")]


@pytest.fixture(scope="module")
def walk(bundled_body):
    """Two seconds of a walk, arms hanging, on feet that do not slide, far from the origin."""
    time = np.arange(120) / RATE
    turns = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
    swing = 0.4 * np.sin(2 * np.pi * time)
    for side, sign in (("left", 1), ("right", -1)):
        hip = Rotation.from_rotvec(np.outer(sign * swing, [1, 0, 0]))
        turns[:, JOINT_INDEX[f"{side}_hip"]] = hip.as_matrix()
        lifted = np.maximum(0, sign * np.cos(2 * np.pi * time))
        turns[:, JOINT_INDEX[f"{side}_knee"]] = Rotation.from_rotvec(np.outer(lifted, [1, 0, 0])).as_matrix()
        arm = Rotation.from_rotvec(np.outer(-sign * swing, [1, 0, 0]))
        hangs = Rotation.from_rotvec([0, sign * np.radians(75), 0])
        turns[:, JOINT_INDEX[f"{side}_shoulder"]] = (arm * hangs).as_matrix()
    still = Motion(turns, np.zeros((len(time), 3)), RATE)
    _, heads = joint_transforms(bundled_body, still)
    feet = heads[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]]
    lower = feet[:-1, :, 2].argmin(axis=1)[:, None, None]
    steps = -np.take_along_axis(np.diff(feet, axis=0), lower, axis=1)[:, 0]
    path = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)]) + [3.0, 2.0, 0.95]
    return replace(still, pelvis=path)


def with_frames(motion, before=0, after=0, turns=None, pelvis=(0.0, 0.0, 0.9)):
    """The motion between frames of a pose, by default the T-pose at the origin."""
    turns = np.tile(np.eye(3), (N_JOINTS, 1, 1)) if turns is None else turns
    frames, place = [turns[None].repeat(count, axis=0) for count in (before, after)], np.array([pelvis])
    path = [place.repeat(before, axis=0), motion.pelvis, place.repeat(after, axis=0)]
    rotations = np.concatenate([frames[0], motion.rotations, frames[1]])
    return replace(motion, rotations=rotations, pelvis=np.concatenate(path))


def fast(walk):
    """The walk with an arm that swings by 2 m from frame to frame at its fastest: no rule of four helps."""
    turns = walk.rotations.copy()
    time = np.arange(walk.n_frames) / RATE
    swing = Rotation.from_rotvec(np.outer(1.5 * np.sin(2 * np.pi * 4 * time), [1, 0, 0])).as_matrix()
    turns[:, JOINT_INDEX["right_shoulder"]] = swing @ turns[:, JOINT_INDEX["right_shoulder"]]
    return replace(walk, rotations=turns)


def squatting(body, walk):
    """A squat whose feet slide to and fro as the pelvis sinks, so that only heights tell how far it goes."""
    bend = 1.2 * np.sin(np.pi * np.arange(120) / 119) ** 2
    turns = np.tile(np.eye(3), (120, N_JOINTS, 1, 1))
    for side in ("left", "right"):
        for joint, sign in (("hip", -1), ("knee", 1)):
            angle = sign * bend
            turns[:, JOINT_INDEX[f"{side}_{joint}"]] = Rotation.from_rotvec(
                np.outer(angle, [1, 0, 0])
            ).as_matrix()
    _, heads = joint_transforms(body, replace(walk, rotations=turns, pelvis=np.zeros((120, 3))))
    path = np.zeros((120, 3))
    path[:, 2] = -heads[:, :, 2].min(axis=1)
    path[:, 0] = 0.2 * np.sin(np.arange(120) / 3)
    return replace(walk, rotations=turns, pelvis=path)


@pytest.mark.parametrize(("before", "after"), [(0, 0), (1, 0), (0, 1), (5, 0), (0, 5), (3, 2), (200, 0)])
def test_rest_poses_at_the_ends_are_dropped(bundled_body, walk, before, after):
    for motion in (walk, fast(walk)):
        kept = believed(bundled_body, with_frames(motion, before, after))
        np.testing.assert_array_equal(kept.motion.rotations, motion.rotations)
        assert bool(kept.cut) == bool(before + after)
    last = 119 + before + after
    said = {
        (1, 0): "frame 0 cut off: a rest pose",
        (0, 5): f"frames 120 to {last} cut off: a rest pose",
        (3, 2): f"frames 0 to 2 and frames {last - 1} to {last} cut off: a rest pose",
    }
    assert kept.cut == said.get((before, after), kept.cut)


def test_a_frame_half_way_from_the_rest_pose_goes_with_it(bundled_body, walk):
    posed = with_frames(walk, 2)
    turns, path = posed.rotations.copy(), posed.pelvis.copy()
    between = Rotation.from_matrix(turns[2]).as_rotvec() / 2
    turns[1], path[1] = Rotation.from_rotvec(between).as_matrix(), (path[0] + path[2]) / 2
    kept = believed(bundled_body, replace(posed, rotations=turns, pelvis=path))
    assert kept.motion.n_frames == walk.n_frames


def test_another_pose_at_an_end_is_dropped_where_no_other_step_comes_near(bundled_body, walk):
    sitting = np.eye(3)[None].repeat(N_JOINTS, axis=0)
    sitting[[1, 2]] = Rotation.from_euler("x", -90, degrees=True).as_matrix()
    assert believed(bundled_body, with_frames(walk, 1, 0, sitting)).motion.n_frames == walk.n_frames
    near = with_frames(walk, 1, 0, walk.rotations[0], walk.pelvis[0] + [0.0, 0.05, 0.0])
    assert believed(bundled_body, near).motion.n_frames == walk.n_frames + 1


def test_a_motion_that_starts_in_the_rest_pose_keeps_it():
    """Arms that go down from the T-pose, slowly or at once at full speed, are a motion."""
    angles = np.concatenate([np.zeros(20), np.linspace(0, 1.4, 20), np.full(20, 1.4)])
    heads = np.zeros((60, 3, 3))
    heads[:, 1, 2] = 1.0
    heads[:, 2, 0], heads[:, 2, 2] = 0.6 * np.cos(angles), 1.5 - 0.6 * np.sin(angles)
    assert moving_part(heads, lambda frames: angles[frames] < 0.3, 30.0) == slice(0, 60)


def test_damage_at_the_start_is_cut_off_and_nothing_else_changes(bundled_body, walk):
    path = walk.pelvis.copy()
    path[2:7] += 14.0
    kept = believed(bundled_body, replace(walk, pelvis=path))
    assert kept.cut.startswith("frames 0 to 6 cut off: damaged (up to 1,4")
    np.testing.assert_array_equal(kept.motion.rotations, walk.rotations[7:])
    expected = walk.pelvis[7:]
    moved = kept.motion.pelvis - kept.motion.pelvis[0]
    np.testing.assert_allclose(moved, expected - expected[0], atol=1e-9)


def test_a_jump_of_the_pelvis_is_refused_with_frame_and_speed(bundled_body, walk):
    path = walk.pelvis.copy()
    path[60:, 1] += 3.67
    said = (
        r"its pelvis moves at 2\d\d m/s between frames 59 and 60, faster than a sprinter \(12.4 m/s\): "
        "it jumps there: cut it there"
    )
    with pytest.raises(UnusableMotion, match=said):
        believed(bundled_body, replace(walk, pelvis=path))


def test_a_jump_of_a_hand_is_refused_with_frame_and_speed(bundled_body, walk):
    turns = walk.rotations.copy()
    up = Rotation.from_euler("y", -170, degrees=True).as_matrix()
    turns[60:, JOINT_INDEX["left_shoulder"]] = up @ turns[60:, JOINT_INDEX["left_shoulder"]]
    said = r"its left (wrist|hand) moves at \d+ m/s between frames 59 and 60, faster than a pitcher's hand"
    with pytest.raises(UnusableMotion, match=said):
        believed(bundled_body, replace(walk, rotations=turns))


@pytest.mark.parametrize(("factor", "unit"), [
    (3.28, "centimetres, not inches, or feet, not metres"),
    (10, "millimetres, not centimetres, or inches, not feet"),
    (30.48, "centimetres, not feet, or inches, not metres"),
    (100, "centimetres, not metres"), (1000, "millimetres, not metres"),
])  # fmt: skip
def test_a_travel_in_another_unit_is_refused_with_the_unit(bundled_body, walk, factor, unit):
    far = replace(walk, pelvis=factor * walk.pelvis)
    with pytest.raises(
        UnusableMotion, match=rf"its pelvis moves at .* m/s.*: its translation looks like {unit}: "
    ):
        believed(bundled_body, far)
    with pytest.raises(UnusableMotion, match=rf"divide it by (\S+ or )?{factor:g}( or \S+)?$"):
        believed(bundled_body, far)


@pytest.mark.parametrize(("factor", "said"), [
    (0.01, "metres, not centimetres: multiply it by 100"),
    (0.001, "metres, not millimetres: multiply it by 1000"),
    (1 / 2.54, "inches, not centimetres, or metres, not feet: multiply it by 2.54 or 3.28"),
])  # fmt: skip
def test_a_travel_too_small_for_the_body_is_refused_with_the_unit(bundled_body, walk, factor, said):
    near = replace(walk, pelvis=factor * walk.pelvis)
    with pytest.raises(UnusableMotion, match=rf"its pelvis moves by \S+ m, where .*looks like {said}$"):
        believed(bundled_body, near)
    believed(bundled_body, replace(walk, pelvis=0 * walk.pelvis + 1.0))  # in place


def test_legs_that_kick_in_a_handstand_are_a_motion(bundled_body, walk):
    """They move the pelvis against the feet by far less than feet on a ground do."""
    turns = walk.rotations.copy()
    turns[:, 0] = np.diag([1.0, -1.0, -1.0]) @ turns[:, 0]
    _, heads = joint_transforms(bundled_body, replace(walk, rotations=turns, pelvis=np.zeros((120, 3))))
    feet = heads[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]]
    lower = feet[:-1, :, 2].argmin(axis=1)[:, None, None]
    steps = -0.1 * np.take_along_axis(np.diff(feet, axis=0), lower, axis=1)[:, 0]
    path = np.concatenate([np.ones((1, 3)), 1 + np.cumsum(steps, axis=0)])
    believed(bundled_body, replace(walk, rotations=turns, pelvis=path))


def test_a_height_in_another_unit_is_refused_where_nobody_steps(bundled_body, walk):
    squat = squatting(bundled_body, walk)
    believed(bundled_body, squat)
    for factor, said in ((10, "divide it by 10 or 12"), (0.01, "multiply it by 100")):
        with pytest.raises(UnusableMotion, match=f"{said}$"):
            believed(bundled_body, replace(squat, pelvis=factor * squat.pelvis))


def test_a_wrong_frame_rate_is_not_taken_for_a_wrong_unit(bundled_body, walk):
    """Legs that carry the pelvis as they should, but tens of times too fast."""
    said = r"its frame rate, 1800, looks too high: give --pose-rate, or Frame Rate in Blender's import dialog"
    with pytest.raises(UnusableMotion, match=said):
        believed(bundled_body, replace(walk, rate=30 * RATE))
    in_place = replace(fast(walk), pelvis=np.ones((120, 3)), rate=30 * RATE)
    with pytest.raises(UnusableMotion, match=f"m/s.*: {said}"):
        believed(bundled_body, in_place)


def carry_joints(tmp_path, body, heads):
    """Joint positions (T, 24, 3) as a file, carried to the body."""
    facts = {"fps": np.array(RATE), "unit": np.array("m"), "up": np.array("z")}
    write_npz(tmp_path / "a.npz", {"positions": heads, "joint_set": np.array("smpl-24")} | facts)
    return to_body(read_motion(tmp_path / "a.npz"), body)


@pytest.mark.parametrize("far", [0.4, 4.0])
def test_a_jump_of_joint_positions_is_refused_and_is_no_other_unit(tmp_path, bundled_body, walk, far):
    """Path and body have one unit there; smoothing hides a jump of less than a metre."""
    _, heads = joint_transforms(bundled_body, walk)
    heads[60:, :, 1] += far
    said = r"m/s between frames 59 and 60, .*: it jumps there: .* correct its frame rate"
    with pytest.raises(UnusableMotion, match=said):
        carry_joints(tmp_path, bundled_body, heads)
    heads[62:, :, 1] -= far  # two frames that smoothing mends
    assert carry_joints(tmp_path, bundled_body, heads).cut == ""


def test_rest_poses_and_damage_at_the_ends_of_joint_positions_are_dropped(tmp_path, bundled_body, walk):
    """A single frame, too, which smoothing would mix with those beside it."""
    _, heads = joint_transforms(bundled_body, with_frames(walk, 1))
    heads[-6:] += 0.4
    kept = carry_joints(tmp_path, bundled_body, heads)
    assert kept.motion.n_frames == walk.n_frames - 6
    assert re.fullmatch(
        r"frame 0 cut off: a rest pose; frames 115 to 120 cut off: damaged \(up to \d\d m/s\)", kept.cut
    )


def test_poses_in_degrees_are_refused(tmp_path, walk):
    walk.save(tmp_path / "walk.npz")
    with np.load(tmp_path / "walk.npz") as stored:
        arrays = dict(stored)
    write_npz(tmp_path / "walk.npz", arrays | {"poses": np.degrees(arrays["poses"])})
    with pytest.raises(UnusableMotion, match="they look like degrees: multiply them by pi / 180"):
        read_amass(tmp_path / "walk.npz")


def rewrite_bvh(path, change):
    """Change the numbers (T, C) of a BVH file."""
    head, _, frames = path.read_text().partition("Frame Time: ")
    time, *rows = frames.splitlines()
    values = change(np.array([row.split() for row in rows], dtype=float))
    text = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in values)
    path.write_text(f"{head}Frame Time: {time}\n{text}\n")


@pytest.mark.parametrize(("factor", "said"), [
    (0.01, "metres, not centimetres: multiply it by 100"),
    (1 / 12, "centimetres, not millimetres, or feet, not inches: multiply it by 10 or 12"),
    (1 / 3.28, "inches, not centimetres, or metres, not feet: multiply it by 2.54 or 3.28"),
])  # fmt: skip
def test_a_bvh_s_root_in_another_unit_than_its_offsets_is_refused(tmp_path, bundled_body, walk, factor, said):
    """Its path is compared with the legs as the file has it: little of it is left on the body."""
    file = tmp_path / "a.bvh"
    write_bvh(file, bundled_body, walk, scale=100, t_pose=False)
    assert to_body(read_motion(file), bundled_body).motion.n_frames == walk.n_frames
    rewrite_bvh(file, lambda values: values * np.r_[[factor] * 3, np.ones(values.shape[1] - 3)])
    with pytest.raises(UnusableMotion, match=f"its pelvis moves .*legs .*looks like {said}$"):
        to_body(read_motion(file), bundled_body)
    rewrite_bvh(file, lambda values: values * np.r_[np.zeros(3), np.ones(values.shape[1] - 3)])
    to_body(read_motion(file), bundled_body)  # in place


def test_a_bvh_in_radians_is_refused(tmp_path, bundled_body, walk):
    write_bvh(tmp_path / "a.bvh", bundled_body, walk)
    rewrite_bvh(
        tmp_path / "a.bvh", lambda values: np.concatenate([values[:, :3], np.radians(values[:, 3:])], 1)
    )
    with pytest.raises(UnusableMotion, match=r"turn by up to \S+ degrees: its angles look like radians"):
        read_motion(tmp_path / "a.bvh")


def test_one_constant_pose_is_a_pose(tmp_path, bundled_body, walk):
    held = replace(walk, rotations=walk.rotations[:1].repeat(50, axis=0), pelvis=np.zeros((50, 3)))
    held.save(tmp_path / "held.npz")
    for motion, frames in ((held, 50), (with_frames(held, 1), 50)):
        motion.save(tmp_path / "held.npz")
        with pytest.raises(
            UnusableMotion, match=f"a pose, not a motion: nothing moves over its {frames} frames"
        ):
            to_body(read_motion(tmp_path / "held.npz"), bundled_body)


def test_the_demos_motions_are_kept_whole(bundled_body):
    for motion in demo_motions(2).values():
        assert believed(bundled_body, motion) == (motion, "")


@pytest.mark.parametrize(("before", "after"), [(1, 0), (3, 2)])
def test_files_of_one_motion_lose_the_same_frames_and_say_so(tmp_path, bundled_body, walk, before, after):
    posed = with_frames(walk, before, after, pelvis=bundled_body.joints[0])
    posed.save(tmp_path / "a.npz")
    write_bvh(tmp_path / "a.bvh", bundled_body, posed, t_pose=False)
    for name in ("a.npz", "a.bvh"):
        kept = to_body(read_motion(tmp_path / name), bundled_body)
        assert kept.cut == believed(bundled_body, posed).cut != ""
        turn = (np.swapaxes(kept.motion.rotations, -1, -2) @ walk.rotations)[:, LIMBS]
        assert np.degrees(Rotation.from_matrix(turn.reshape(-1, 3, 3)).magnitude()).max() < 0.1


@pytest.mark.parametrize(("file", "frames"), [("tpose_at_end.bvh", 180), ("root_glitch.bvh", 113)])
def test_files_with_damaged_ends(shared_cases, bundled_body, file, frames):
    assert to_body(read_motion(shared_cases / file), bundled_body).motion.n_frames == frames


@pytest.mark.parametrize(("file", "up"), [("trans_in_cm.npz", "z"), ("aist_cm.npz", "y")])
def test_files_in_centimetres(shared_cases, bundled_body, file, up):
    with pytest.raises(
        UnusableMotion, match="its translation looks like centimetres, not metres: divide it by 100"
    ):
        to_body(read_motion(shared_cases / file, PoseFacts(up=up)), bundled_body)
