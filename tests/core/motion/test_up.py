# SPDX-License-Identifier: GPL-3.0-or-later
"""The axis that is up: by the format, by the whole library, by plain signs in one file; never by posture."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.skeleton import JOINT_INDEX
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.motion.motion import Motion, demo_motions, read_amass
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.motion.up import TO_Z, UPS
from w2w.scene.motion.load import look_up, read_motion, to_body

from ...rings import each_by_day
from ...seen_joints import seen_as

HEADINGS = range(0, 360, 30)


def turn(motion, rotation, about=(0.0, 0.0, 0.0)):
    """A motion with its whole world turned by a matrix."""
    rotations = motion.rotations.copy()
    rotations[:, 0] = rotation @ rotations[:, 0]
    return Motion(rotations, (motion.pelvis - about) @ rotation.T + about, motion.rate)


def heading(degrees):
    return Rotation.from_euler("z", degrees, degrees=True).as_matrix()


def lying(motion, degrees, at=(0.4, -0.7, 0.1)):
    """Someone on the back who kicks and waves, with the head towards a heading."""
    back = Rotation.from_euler("x", -90, degrees=True).as_matrix()
    laid = turn(motion, heading(degrees) @ back)
    return Motion(laid.rotations, np.tile(at, (laid.n_frames, 1)), laid.rate)


def write_smpl(path, motion, names=("poses", "trans", "mocap_framerate"), up="z"):
    """A motion as an npz of SMPL poses whose axis `up` is up, without W2W's labels."""
    motion = turn(motion, TO_Z[up].T)
    motion.save(path.with_suffix(".own.npz"))
    with np.load(path.with_suffix(".own.npz")) as data:
        poses, trans = data["poses"], data["trans"]
    path.with_suffix(".own.npz").unlink()
    if names[0] == "bodyPose":
        poses = poses[:, :66].reshape(-1, 22, 3)
    parts = {names[0]: poses}
    if names[0] == "global_orient":
        parts = {"global_orient": poses[:, :3], "body_pose": poses[:, 3:66]}
    with path.open("wb") as stream:
        np.savez(stream, **parts, **{names[1]: trans, names[2]: np.array(motion.rate)})


@pytest.fixture(scope="module")
def clips():
    return list(demo_motions(3).values())


def trunk(motion, body):
    """Mean height that a trunk rises by over its length."""
    _, places = joint_transforms(body, motion)
    line = places[:, JOINT_INDEX["neck"]] - places[:, 0]
    return float((line[:, 2] / np.linalg.norm(line, axis=1)).mean())


@pytest.mark.parametrize("degrees", HEADINGS)
def test_a_lying_amass_file_lies_whatever_its_heading(tmp_path, clips, degrees):
    there = lying(clips[0], degrees)
    write_smpl(tmp_path / "a.npz", there)
    np.testing.assert_allclose(read_amass(tmp_path / "a.npz").pelvis, there.pelvis, atol=1e-6)


@pytest.mark.parametrize("degrees", HEADINGS)
def test_smpl_files_are_y_up_by_their_format(tmp_path, clips, degrees):
    there = lying(clips[0], degrees)
    write_smpl(tmp_path / "a.smpl", there, ("bodyPose", "bodyTranslation", "frameRate"), "y")
    np.testing.assert_allclose(read_amass(tmp_path / "a.smpl").pelvis, there.pelvis, atol=1e-6)


@pytest.mark.parametrize(
    ("up", "names"),
    [
        ("y", ("poses", "trans", "fps")),
        ("z", ("global_orient", "transl", "fps")),
        pytest.param("z", ("poses", "trans", "fps"), marks=pytest.mark.slow),
        pytest.param("y", ("global_orient", "transl", "fps"), marks=pytest.mark.slow),
    ],
)
def test_people_who_plainly_stand_along_the_other_axis_are_turned(tmp_path, clips, names, up):
    for number, motion in enumerate(clips):
        write_smpl(tmp_path / "a.npz", motion, names, up)
        found = read_amass(tmp_path / "a.npz")
        np.testing.assert_allclose(found.pelvis, motion.pelvis, atol=1e-5, err_msg=str(number))


def test_a_camera_s_axes_are_asked_for(tmp_path, clips):
    far = Motion(clips[0].rotations, clips[0].pelvis + (0, 4.0, 0.3), clips[0].rate)
    write_smpl(tmp_path / "a.npz", far, ("global_orient", "transl", "fps"), "-y")
    with pytest.raises(UnusableMotion, match="stands along -y of its axes: give --pose-up"):
        read_amass(tmp_path / "a.npz")
    np.testing.assert_allclose(read_amass(tmp_path / "a.npz", up="-y").pelvis, far.pelvis, atol=1e-5)


@pytest.mark.parametrize("up", UPS)
def test_all_six_axes_can_be_given_for_poses_and_joints(tmp_path, clips, bundled_body, up):
    motion, joints = clips[0], JOINT_SETS["humanml3d-22"]
    write_smpl(tmp_path / "a.npz", motion, up=up)
    pose = PoseFacts(rate=motion.rate, up=up)
    np.testing.assert_allclose(read_motion(tmp_path / "a.npz", pose).pelvis, motion.pelvis, atol=1e-5)
    np.save(tmp_path / "a.npy", seen_as(joints, bundled_body, motion) @ TO_Z[up])
    source = read_motion(tmp_path / "a.npy", pose)
    expected = seen_as(joints, bundled_body, motion)
    np.testing.assert_allclose(source.positions @ TO_Z[source.up].T, expected, atol=1e-9)


SOME_UPS, SOME_SETS = ["y", "z", "-y", "x"], ["humanml3d-22", "human36m-17", "blazepose-33"]


@pytest.mark.parametrize(("up", "joint_set"), each_by_day(SOME_UPS, SOME_SETS))
def test_joints_of_people_who_stand_are_read_whatever_is_up(tmp_path, clips, bundled_body, joint_set, up):
    for motion in clips:
        np.save(tmp_path / "a.npy", seen_as(JOINT_SETS[joint_set], bundled_body, motion) @ TO_Z[up])
        found = read_motion(tmp_path / "a.npy", PoseFacts(rate=motion.rate, joint_set=joint_set))
        assert (found.up, found.up_is_guessed) == (up, True)


@pytest.mark.slow
@pytest.mark.parametrize("up", "yz")
def test_one_axis_is_up_in_a_library_s_files_of_a_kind(tmp_path, clips, bundled_body, up):
    """Most people stand: those who lie, with any heading, are not stood up."""
    joints, facts = JOINT_SETS["humanml3d-22"], PoseFacts(rate=clips[0].rate)
    motions = [*clips, *(lying(clips[0], degrees, (3.0, 2.0, 0.1)) for degrees in range(0, 360, 45))]
    for number, motion in enumerate(motions):
        np.save(tmp_path / f"{number}.npy", seen_as(joints, bundled_body, motion) @ TO_Z[up])
        write_smpl(tmp_path / f"{number}.npz", motion, up=up)
    files = [(path.name, path) for path in sorted(tmp_path.iterdir())]
    seen = look_up(files, facts)
    assert seen.ups.chosen == (("AMASS", up), (f"joints ({joints.name})", up))
    how = {"y": (", by their feet", ""), "z": ("", ", by their feet")}[up]
    count = len(motions)
    assert seen.sentence() == (
        f"{up}, {count} files of AMASS{how[0]}; {up}, {count} files of joints ({joints.name}){how[1]}"
    )
    assert look_up(reversed(files), facts).ups == seen.ups
    assert not look_up(files, PoseFacts(up="y")).ups.chosen
    for number, motion in enumerate(motions):
        assert read_motion(tmp_path / f"{number}.npy", facts, seen.ups).up == up
        found = read_motion(tmp_path / f"{number}.npz", facts, seen.ups)
        np.testing.assert_allclose(found.pelvis, motion.pelvis, atol=1e-5)


@pytest.mark.slow
def test_a_folder_loaded_from_python_has_one_axis(tmp_path, clips, bundled_body):
    joints = JOINT_SETS["humanml3d-22"]
    for name, motion in {"walk": clips[0], "wave": clips[4], "sleep": lying(clips[0], 0)}.items():
        (tmp_path / name).mkdir()
        content = {"rate": motion.rate, "joint_set": "humanml3d-22"}
        np.save(tmp_path / name / "a.npy", seen_as(joints, bundled_body, motion))
        (tmp_path / name / "a.json").write_text(json.dumps(content))
    found = {motion.activity: trunk(motion, bundled_body) for motion in w2w.load(tmp_path)}
    assert abs(found["sleep"]) < 0.3
    assert min(found["walk"], found["wave"]) > 0.9


def upside_down(motion):
    return turn(motion, Rotation.from_euler("x", 180, degrees=True).as_matrix())


def test_a_file_head_down_is_refused_alone_and_a_motion_among_others(tmp_path, clips):
    (tmp_path / "handstand").mkdir()
    (tmp_path / "walk").mkdir()
    write_smpl(tmp_path / "handstand" / "a.npz", upside_down(clips[0]))
    for number in range(2):
        write_smpl(tmp_path / "walk" / f"{number}.npz", clips[number])
    with pytest.raises(ValueError, match="trunks point down in most of the frames: give pose=PoseFacts"):
        w2w.load(tmp_path / "handstand" / "a.npz")
    assert w2w.load(tmp_path / "handstand" / "a.npz", pose=PoseFacts(up="z"))[0].head_down
    turned = w2w.load(tmp_path / "handstand" / "a.npz", pose=PoseFacts(up="-z"))[0]
    assert turned.rotations[:, 0, 2, 2].mean() > 0.9
    assert [motion.head_down for motion in w2w.load(tmp_path)] == [True, False, False]
    (tmp_path / "walk" / "0.npz").unlink()
    (tmp_path / "walk" / "1.npz").unlink()
    with pytest.raises(ValueError, match="trunks point down"):
        w2w.load(tmp_path)


@pytest.mark.parametrize("degrees", range(0, 360, 45))
def test_who_lies_down_shows_the_ground(tmp_path, bundled_body, clips, degrees):
    """Joints of someone who stands, then lies for most of the time, in z-up and y-up axes."""
    stands, lies = clips[0], lying(clips[0], degrees)
    path = lies.pelvis - lies.pelvis[0] + stands.pelvis[-1] * (1, 1, 0) + (0, 0, 0.1)
    steps = np.linspace(0, 1, 30)
    last = Rotation.from_matrix(stands.rotations[-1, 0])
    back = (Rotation.from_matrix(lies.rotations[0, 0]) * last.inv()).as_rotvec()
    falling = np.repeat(stands.rotations[-1:], 30, axis=0)
    falling[:, 0] = (Rotation.from_rotvec(steps[:, None] * back) * last).as_matrix()
    between = stands.pelvis[-1] + steps[:, None] * (path[0] - stands.pelvis[-1])
    motion = Motion(
        np.concatenate([stands.rotations, falling, lies.rotations, lies.rotations]),
        np.concatenate([stands.pelvis, between, path, path]),
        stands.rate,
    )
    for up in ("y", "z"):
        np.save(tmp_path / "a.npy", seen_as(JOINT_SETS["humanml3d-22"], bundled_body, motion) @ TO_Z[up])
        assert read_motion(tmp_path / "a.npy", PoseFacts(rate=30.0)).up == up


@pytest.mark.parametrize(
    ("file", "trunk_z", "pelvis"),
    [
        ("lying_zup.npz", (0.2, 0.6), (0.0, 0.35)),
        ("lying_yup.smpl", (0.2, 0.6), (0.0, 0.35)),
        ("crawl_facing0.npz", (0.04, 0.25), (0.0, 0.8)),
        ("crawl_facing90.npz", (0.04, 0.25), (0.0, 0.8)),
        ("supine_facing270.npz", (0.03, 0.25), (0.0, 0.2)),
        ("blender_export_jog.bvh", (0.9, 1.0), (0.8, 1.1)),
        ("blender_export_lie_down.bvh", (0.3, 0.9), (0.1, 0.5)),
    ],
)
def test_files_that_were_stood_up_once(shared_cases, bundled_body, file, trunk_z, pelvis):
    found = to_body(read_motion(shared_cases / file), bundled_body).motion
    assert trunk_z[0] <= trunk(found, bundled_body) <= trunk_z[1]
    assert pelvis[0] <= np.median(found.pelvis[:, 2]) <= pelvis[1]


def test_files_whose_axis_must_be_given(shared_cases, bundled_body):
    with pytest.raises(UnusableMotion, match="along -y of its axes: give --pose-up"):
        read_motion(shared_cases / "gvhmr_incam.npz")
    for file in ("gvhmr_incam.npz", "upside_down.bvh"):
        with pytest.raises(ValueError, match="give pose=PoseFacts"):
            w2w.load(shared_cases / file)
        found = w2w.load(shared_cases / file, pose=PoseFacts(up="-y"))[0]
        assert trunk(found, bundled_body) > 0.5, file
