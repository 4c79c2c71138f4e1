# SPDX-License-Identifier: GPL-3.0-or-later
"""BVH in: every real file, and files written here whose motion is known."""

import csv

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS, Y_UP_TO_Z_UP
from w2w.core.motion.motion import Motion
from w2w.core.motion.sight import TO_Z, UPS
from w2w.core.motion.skinning import joint_transforms, skin, skinning_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.retarget import BY_STRUCTURE, matched_joints, retarget

from ...made_bvh import NAMES, write_bvh
from ...rings import each_by_day

pytestmark = pytest.mark.filterwarnings("ignore:Gimbal lock")

GAIT = "imu/gait/xsens_S02-Trial-Walk-1.bvh"

SKIPPED = {
    "kick.bvh": "its skeleton opens 7 braces and closes 12",
    "oneFrame.bvh": "it holds a pose, not a motion",
}

LED_BY_T_POSE = {"06_01", "06_04", "06_05", "06_06", "06_08", "06_09", "06_15", "007_12"}

SEGMENTS = [
    (JOINT_INDEX[f"{side}_{start}"], JOINT_INDEX[f"{side}_{end}"])
    for side in ("left", "right")
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
]


@pytest.fixture(scope="module")
def carried(shared_data, bundled_body):
    """Every BVH file of motions.csv and the gait trial, retargeted to the body; and why some were skipped."""
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        rows = {row["file"]: row for row in csv.DictReader(stream) if row["format"] == "bvh"}
    assert len(rows) == 78
    clips, skipped = {}, {}
    for file in [*rows, GAIT]:
        try:
            source = read_bvh(shared_data / file)
            result = retarget(source, bundled_body)
            clips[file] = _measure(source, result, bundled_body) | {"row": rows.get(file)}
        except UnusableMotion as error:
            skipped[file.rsplit("/", 1)[1]] = str(error)
    return clips, skipped


def _measure(source, result, body):
    turns, heads = joint_transforms(body, result.motion)
    matched = matched_joints(source)[1]
    angles = []
    for start, end in SEGMENTS:
        theirs = source.matrices[:, matched[end], :3, 3] - source.matrices[:, matched[start], :3, 3]
        ours = heads[:, end] - heads[:, start]
        cosine = np.sum(ours * theirs, 1) / np.linalg.norm(ours, axis=1) / np.linalg.norm(theirs, axis=1)
        angles.append(np.degrees(np.arccos(np.clip(cosine, -1, 1))))
    lowest = skin(body, skinning_transforms(body, result.motion), slice(None, None, 10))[..., 2].min(axis=1)
    speeds = np.linalg.norm(np.diff(heads, axis=0), axis=-1).max(axis=1) * source.rate
    feet = [JOINT_INDEX["left_ankle"], JOINT_INDEX["right_ankle"]]
    hinges = []
    for side in ("left", "right"):
        bend = Rotation.from_matrix(result.motion.rotations[:, JOINT_INDEX[f"{side}_knee"]]).as_rotvec()
        bend = bend[np.linalg.norm(bend, axis=1) > np.radians(20)]
        hinges.append(bend[:, 0] / np.linalg.norm(bend, axis=1))
    return {
        "skeleton": result.bone_map,
        "angles": np.concatenate(angles),
        "speeds": speeds,
        "lowest": lowest,
        "foot_tilt": np.degrees(np.arccos(np.clip(turns[:, feet, 2, 2], -1, 1))).min(axis=0),
        "trunk_tilt": np.degrees(np.arccos(np.clip(turns[:, 9, 2, 2], -1, 1))),
        "pelvis_height": heads[:, 0, 2],
        "travel": np.linalg.norm(np.diff(heads[:, 0, :2], axis=0), axis=1).sum(),
        "seconds": (source.n_frames - 1) / source.rate,
        "knee_hinges": np.concatenate(hinges),
        "n_frames": source.n_frames,
    }


def by_name(clips):
    assert len({file.rsplit("/", 1)[1] for file in clips}) == len(clips)
    return {file.rsplit("/", 1)[1].removesuffix(".bvh"): clip for file, clip in clips.items()}


@pytest.mark.slow
def test_every_file_that_moves_is_used_and_others_refused_truly(carried):
    clips, skipped = carried
    assert len(clips) == 77
    assert skipped.keys() == SKIPPED.keys()
    for file, reason in SKIPPED.items():
        assert reason in skipped[file]


@pytest.mark.slow
def test_skeletons_are_known_by_name(carried):
    skeletons = {file.split("/")[1]: clip["skeleton"] for file, clip in carried[0].items()}
    assert skeletons == {
        "bandai_namco": "Bandai-Namco",
        "cmu_DragonForged": "Character Creator",
        "cmu_JonathanAlderson": "CMU",
        "pybvh": "Mixamo",
        "gait": "Xsens BVH",
    }


@pytest.mark.parametrize(
    ("file", "up", "spine"),
    [
        (GAIT, None, ("Chest", "Chest3", "Chest4")),
        ("bvh/pybvh/bvh_test3.bvh", "z", ("Spine", "Spine2", "Spine3")),
    ],
)
def test_the_spine_reaches_the_bone_that_carries_neck_and_arms(shared_data, file, up, spine):
    source = read_bvh(shared_data / file, up=up)
    matched = matched_joints(source)[1]
    assert tuple(source.bones[matched[JOINT_INDEX[f"spine{number}"]]] for number in (1, 2, 3)) == spine


@pytest.mark.slow
def test_limbs_point_where_the_source_s_do(carried):
    angles = np.concatenate([clip["angles"] for clip in carried[0].values()])
    assert np.median(angles) <= 0.1
    assert np.percentile(angles, 99) <= 1


@pytest.mark.slow
def test_no_clip_jumps_from_a_t_pose(carried):
    for file, clip in carried[0].items():
        speeds = clip["speeds"]
        assert speeds[0] <= 1.3 * speeds[1:].max(), file
        assert speeds.max() < 15, file  # metres a second of any joint


@pytest.mark.slow
def test_leading_t_poses_are_dropped_and_nothing_else(carried):
    for name, clip in by_name(carried[0]).items():
        rows = int(clip["row"]["frames"]) if clip["row"] else 2503
        led = name in LED_BY_T_POSE or name.startswith("xsens")
        assert clip["n_frames"] == rows - led, name


@pytest.mark.slow
def test_bodies_stand_on_the_ground_at_their_size(carried, bundled_body):
    """Whatever the file's unit, its scale follows from the legs, so hips are as high as the body's."""
    hips = bundled_body.joints[0, 2]
    for file, clip in carried[0].items():
        assert 0.75 * hips < np.median(clip["pelvis_height"]) < 1.12 * hips, file
        assert np.percentile(clip["lowest"], 5) > -0.02, file
        assert clip["lowest"].min() < 0.03, file
        assert np.median(clip["trunk_tilt"]) < 45, file


@pytest.mark.slow
def test_walking_and_running_are_as_fast_as_people_are(carried):
    walks = {f: c["travel"] / c["seconds"] for f, c in carried[0].items() if "walk_" in f}
    runs = {f: c["travel"] / c["seconds"] for f, c in carried[0].items() if "_run_" in f}
    assert len(walks) == len(runs) == 6
    assert all(0.8 < speed < 2.6 for speed in walks.values()), walks
    assert all(1.5 < speed < 5 for speed in runs.values()), runs


@pytest.mark.slow
def test_feet_that_stand_are_flat(carried):
    """Though the offsets of most of these files are no rest pose, and CMU's splay the legs."""
    tilts = {file: clip["foot_tilt"].max() for file, clip in carried[0].items()}
    assert np.mean(np.array(list(tilts.values())) < 10) > 0.95, tilts


@pytest.mark.slow
def test_knees_bend_about_their_hinge(carried):
    """Twist is right where bending a knee turns it about the body's left-right axis."""
    bending = [file for file, clip in carried[0].items() if len(clip["knee_hinges"]) and "pybvh" not in file]
    assert len(bending) > 30
    for file, clip in carried[0].items():
        if "bandai" in file or "cmu" in file:
            assert len(clip["knee_hinges"]) == 0 or np.median(clip["knee_hinges"]) > 0.75, file


# --- files of known motion


@pytest.fixture
def striding(bundled_body):
    """A walk-like motion far from the T-pose: arms hanging, legs swinging, feet flat at times."""
    time = np.arange(90) / 30
    rotations = np.tile(np.eye(3), (90, N_JOINTS, 1, 1))
    swing = 0.4 * np.sin(2 * np.pi * time)
    for side, sign in (("left", 1), ("right", -1)):
        lowered = Rotation.from_rotvec([0, sign * np.radians(70), 0])
        forward = Rotation.from_rotvec(np.outer(-sign * swing, [1, 0, 0]))
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = (forward * lowered).as_matrix()
        elbow = np.outer(0.5 + 0.2 * np.cos(2 * np.pi * time), [0, 0, -sign])
        rotations[:, JOINT_INDEX[f"{side}_elbow"]] = Rotation.from_rotvec(elbow).as_matrix()
        rotations[:, JOINT_INDEX[f"{side}_hip"]] = Rotation.from_rotvec(
            np.outer(sign * swing, [1, 0, 0])
        ).as_matrix()
        knee = np.outer(0.3 - 0.3 * np.cos(4 * np.pi * time), [1, 0, 0])
        rotations[:, JOINT_INDEX[f"{side}_knee"]] = Rotation.from_rotvec(knee).as_matrix()
    rotations[:, JOINT_INDEX["spine2"]] = Rotation.from_rotvec(np.outer(swing, [0, 0, 0.5])).as_matrix()
    pelvis = bundled_body.joints[0] + np.stack(
        [0 * time, -1.2 * time, 0.01 * np.cos(4 * np.pi * time)], axis=1
    )
    return Motion(rotations, pelvis, 30.0)


@pytest.mark.parametrize("scale", [1.0, 100.0, 39.37])
@pytest.mark.parametrize("z_up", [False, True])
@pytest.mark.parametrize("folded_by", [None, 0, 3])
def test_a_known_motion_comes_back(tmp_path, bundled_body, striding, folded_by, z_up, scale):
    """Through other units, axes and offsets that are no pose, its leading T-pose left out."""
    write_bvh(tmp_path / "a.bvh", bundled_body, striding, folded_by, z_up=z_up, scale=scale)
    source = read_bvh(tmp_path / "a.bvh")
    result = retarget(source, bundled_body)
    assert result.motion.n_frames == striding.n_frames
    assert result.motion.rate == pytest.approx(30, rel=1e-4)
    assert result.scale == pytest.approx(1 / scale, rel=1e-4)
    turn = np.swapaxes(result.motion.rotations, -1, -2) @ striding.rotations
    away = np.degrees(Rotation.from_matrix(turn.reshape(-1, 3, 3)).magnitude())
    assert away.max() < 0.1
    path = result.motion.pelvis - striding.pelvis
    np.testing.assert_allclose(path - path.mean(axis=0), 0, atol=0.002)


def test_a_motion_without_t_pose_keeps_its_first_frame(tmp_path, bundled_body, striding):
    write_bvh(tmp_path / "a.bvh", bundled_body, striding, t_pose=False)
    assert read_bvh(tmp_path / "a.bvh").n_frames == striding.n_frames


def test_offsets_that_are_no_pose_and_no_t_pose_at_all(tmp_path, bundled_body, striding):
    """The straightest frame stands in for the rest pose: limbs are exact, twists within a few degrees."""
    write_bvh(tmp_path / "a.bvh", bundled_body, striding, folded_by=8, t_pose=False)
    result = retarget(read_bvh(tmp_path / "a.bvh"), bundled_body)
    _, ours = joint_transforms(bundled_body, result.motion)
    _, truth = joint_transforms(bundled_body, striding)
    for start, end in SEGMENTS:
        a, b = ours[:, end] - ours[:, start], truth[:, end] - truth[:, start]
        a, b = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (a, b))
        assert np.degrees(np.arccos(np.clip(np.sum(a * b, axis=1), -1, 1))).max() < 3
    turn = np.swapaxes(result.motion.rotations, -1, -2) @ striding.rotations
    away = np.degrees(Rotation.from_matrix(turn.reshape(-1, 3, 3)).magnitude())
    assert np.percentile(away, 95) < 15


PLACES = [(0.3, 0.2), (0.1, -0.95), (-1.0, 0.9)]


@pytest.mark.parametrize(("z_up", "degrees", "place"), each_by_day([False, True], range(0, 360, 45), PLACES))
def test_a_body_that_lies_is_not_stood_up(tmp_path, bundled_body, striding, z_up, degrees, place):
    """Lying on its back near the ground, in a y-up file or, as from Blender, one whose rest pose is z up."""
    lying = Rotation.from_euler("xz", [-90, degrees], degrees=True).as_matrix()
    rotations = striding.rotations.copy()
    rotations[:, 0] = lying @ rotations[:, 0]
    pelvis = np.tile([*place, 0.42], (striding.n_frames, 1))
    write_bvh(tmp_path / "a.bvh", bundled_body, Motion(rotations, pelvis, 30.0), t_pose=False, z_up=z_up)
    result = retarget(read_bvh(tmp_path / "a.bvh"), bundled_body)
    np.testing.assert_allclose(result.motion.rotations[:, 0], rotations[:, 0], atol=0.01)


@pytest.mark.parametrize("up", UPS)
def test_all_six_axes_can_be_given(tmp_path, bundled_body, striding, up):
    turn = Y_UP_TO_Z_UP @ TO_Z[up].T
    rotations = striding.rotations.copy()
    rotations[:, 0] = turn @ rotations[:, 0]
    turned = Motion(rotations, striding.pelvis @ turn.T, 30.0)
    write_bvh(tmp_path / "a.bvh", bundled_body, turned, t_pose=False)
    result = retarget(read_bvh(tmp_path / "a.bvh", up=up), bundled_body)
    np.testing.assert_allclose(result.motion.rotations[:, 0], striding.rotations[:, 0], atol=0.01)


def test_unknown_names_are_matched_by_structure(tmp_path, bundled_body, striding):
    write_bvh(tmp_path / "a.bvh", bundled_body, striding)
    text = (tmp_path / "a.bvh").read_text()
    for number, name in enumerate(NAMES):
        text = text.replace(f"ROOT {name}\n", f"ROOT n{number}\n").replace(
            f"JOINT {name}\n", f"JOINT n{number}\n"
        )
    (tmp_path / "b.bvh").write_text(text)
    result = retarget(read_bvh(tmp_path / "b.bvh"), bundled_body)
    assert result.bone_map == BY_STRUCTURE
    expected = retarget(read_bvh(tmp_path / "a.bvh"), bundled_body)
    np.testing.assert_allclose(result.motion.rotations, expected.motion.rotations, atol=1e-5)
