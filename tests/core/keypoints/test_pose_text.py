# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions as other programs write them: trc, FreeMoCap's csv and json, MediaPipe's json."""

import json

import numpy as np
import pytest

from w2w.core.body.body import JOINT_INDEX, Y_UP_TO_Z_UP
from w2w.core.exports.biomechanics import write_trc
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.keypoints.pose_files import read_joints
from w2w.core.library.library import is_motion, read_library
from w2w.core.motion.examples import demo_motions
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion

from ...rings import each_by_day
from ...seen_joints import seen_as

HALPE = {
    "Hip": "mid_hip", "RHip": "right_hip", "RKnee": "right_knee", "RAnkle": "right_ankle",
    "RBigToe": "right_big_toe", "RSmallToe": "right_small_toe", "RHeel": "right_heel", "LHip": "left_hip",
    "LKnee": "left_knee", "LAnkle": "left_ankle", "LBigToe": "left_big_toe", "LSmallToe": "left_small_toe",
    "LHeel": "left_heel", "Neck": "neck", "Nose": "nose", "RShoulder": "right_shoulder",
    "RElbow": "right_elbow", "RWrist": "right_wrist", "LShoulder": "left_shoulder", "LElbow": "left_elbow",
    "LWrist": "left_wrist",
}  # fmt: skip
"""Points of Pose2Sim's trc files, in its order, and those of BODY_25 that they are."""

BLAZEPOSE = JOINT_SETS["blazepose-33"]
LIMBS = [
    (f"{side}_{start}", f"{side}_{end}")
    for side in ("left", "right")
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
]


@pytest.fixture(scope="module")
def walk():
    return next(iter(demo_motions(1).values()))


def assert_moves_as(bundled_body, found, motion):
    """Limbs point as in a motion to 2 degrees in nearly every frame, in the body's own axes."""
    fitted = found.fit(bundled_body).motion
    truth, ours = (joint_transforms(bundled_body, each)[1] for each in (motion, fitted))
    for ends in LIMBS:
        start, end = (JOINT_INDEX[name] for name in ends)
        a, b = (joints[:, end] - joints[:, start] for joints in (truth, ours))
        cosine = (a * b).sum(axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean() < 2, ends


def test_trc_as_w2w_writes_it_is_the_motion_again(tmp_path, bundled_body, walk):
    positions = joint_transforms(bundled_body, walk)[1] @ Y_UP_TO_Z_UP
    write_trc(tmp_path / "a.trc", positions, walk.rate)
    assert [clip.file for clip in read_library(tmp_path).clips] == ["a.trc"]
    found = read_joints(tmp_path / "a.trc")
    assert (found.joint_set, found.rate, found.unit, found.up) == (JOINT_SETS["smpl-24"], walk.rate, "m", "y")
    np.testing.assert_allclose(found.positions, positions, atol=1e-6)
    assert_moves_as(bundled_body, found, walk)
    assert read_joints(tmp_path / "a.trc", PoseFacts(rate=25.0)).rate == 25


def as_trc(names, positions, unit="mm", rate="30.000000"):
    """Text of a trc file with a tab at the end of each row, as Pose2Sim and Cortex write it."""
    numbers = "\t".join(f"{axis}{k}" for k in range(1, len(names) + 1) for axis in "XYZ")
    head = [
        "PathFileType\t4\t(X/Y/Z)\tdemo.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{rate}\t{rate}\t{len(positions)}\t{len(names)}\t{unit}\t{rate}\t0\t{len(positions)}",
        "Frame#\tTime\t" + "\t\t\t".join(names) + "\t\t\t",
        f"\t\t{numbers}\t",
    ]
    rows = [
        "\t".join([str(k), f"{k / 30:.6f}", *("" if np.isnan(x) else f"{x:.6f}" for x in row), ""])
        for k, row in enumerate(positions.reshape(len(positions), -1))
    ]
    return "\n".join([*head, *rows]) + "\n"


def test_trc_of_pose2sim(tmp_path, bundled_body, walk):
    body_25 = JOINT_SETS["openpose-25"]
    seen = 1000 * seen_as(body_25, bundled_body, walk) @ Y_UP_TO_Z_UP
    positions = seen[:, [body_25.joints.index(name) for name in HALPE.values()]]
    positions[5, 7] = np.nan
    (tmp_path / "a.trc").write_text(as_trc(list(HALPE), positions))
    found = read_joints(tmp_path / "a.trc")
    assert (found.joint_set, found.rate, found.unit) == (body_25, 30, "mm")
    for number, name in enumerate(HALPE.values()):
        if name != "mid_hip":
            place = found.positions[:, body_25.joints.index(name)]
            np.testing.assert_allclose(place, positions[:, number], atol=1e-5)


def test_trc_of_joint_centres(tmp_path):
    names = [f"{side}{joint}JC" for side in "LR" for joint in "HKASEW"]
    positions = np.random.default_rng(0).normal(size=(9, 12, 3))
    (tmp_path / "a.trc").write_text(as_trc(names, positions))
    assert read_joints(tmp_path / "a.trc", PoseFacts(up="y")).joint_set == JOINT_SETS["joint-centres"]


MARKERS = as_trc(["LASI", "RASI"], np.ones((9, 2, 3)))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (MARKERS, "it names no joint centre of the left hip, left shoulder"),
        (MARKERS[:200], "damaged or no trc file"),
        ("Frame\tTime\n" * 9, "does not begin with PathFileType"),
        (f"{MARKERS}9\t0.3\t1", "its row 10 is cut short"),
        (MARKERS.replace("LASI\t\t\tRASI", "\t\t\t"), "it names no markers"),
        (MARKERS.replace("\tmm\t", "\tfurlong\t"), "the pose's unit must be one of"),
        (MARKERS.replace("30.000000", "fast"), "could not convert string to float"),
    ],
)
def test_trc_without_joints_or_damaged_is_refused(tmp_path, text, reason):
    (tmp_path / "a.trc").write_text(text)
    with pytest.raises(UnusableMotion, match=reason):
        read_joints(tmp_path / "a.trc")


@pytest.fixture
def seen(bundled_body, walk):
    """BlazePose's points of a walk, z up, in metres."""
    return seen_as(BLAZEPOSE, bundled_body, walk)


@pytest.mark.parametrize("kind", ["csv", "json", "npy"])
def test_freemocap(tmp_path, walk, seen, kind):
    path, millimetres = tmp_path / f"mediapipe_body_3d_xyz.{kind}", 1000 * seen
    hands = ["right_hand_wrist", "left_hand_wrist"]
    names = [*(f"body_{joint}" for joint in BLAZEPOSE.joints), *hands]
    points = np.concatenate([millimetres, millimetres[:, :2]], axis=1)
    if kind == "npy":
        face = np.zeros((len(seen), 553 - 33, 3))
        np.save(path, np.concatenate([millimetres, face], axis=1))
    elif kind == "csv":
        columns = [
            "timestamp",
            "timestamp_by_camera",
            *(f"{name}_{axis}" for name in names for axis in "xyz"),
        ]
        rows = [f",,{','.join(map(str, row.ravel()))}" for row in points]
        path.write_text("\n".join([",".join(columns), *rows]))
    else:
        frames = {
            str(k): {"timestamps": {}, "tracked_points": dict(zip(names, map(as_dict, row), strict=True))}
            for k, row in enumerate(points)
        }
        info = {"segment_lengths": {}, "schemas": ["x" * 40_000]}
        path.write_text(json.dumps({"info": info, "data_by_frame": frames}, indent=4))
    assert is_motion(path)
    found = read_joints(path, PoseFacts(rate=walk.rate, up="z"))
    assert found.joint_set == BLAZEPOSE
    np.testing.assert_allclose(found.positions, millimetres, atol=1e-6)


def as_dict(point):
    return dict(zip("xyz", map(float, point), strict=True)) | {"visibility": 0.9}


KEYS = ["pose_world_landmarks", "poseWorldLandmarks", "worldLandmarks"]
NESTED = ["frames", "list", "pose", "several", "numbers"]


@pytest.mark.parametrize(("key", "nested"), each_by_day(KEYS, NESTED))
def test_mediapipe(tmp_path, seen, key, nested):
    points = np.stack([seen[..., 0], -seen[..., 2], seen[..., 1]], axis=2)  # x right, y down
    of_frame = [row[:, :3].tolist() if nested == "numbers" else [as_dict(p) for p in row] for row in points]
    frames = [{"timestamp_ms": 33 * k, key: person} for k, person in enumerate(of_frame)]
    if nested in ("several", "numbers"):
        frames = [frame | {key: [frame[key]]} for frame in frames]
    frames[4] |= {key: []}
    content = [{"pose": frame} for frame in frames] if nested == "pose" else frames
    content = content if nested in ("list", "pose") else {"fps": 30, "frames": content}
    path = tmp_path / "pose.json"
    path.write_text(json.dumps(content))
    assert is_motion(path)
    found = read_joints(path, PoseFacts(rate=30.0))
    assert (found.joint_set, found.unit, found.up) == (BLAZEPOSE, "m", "-y")
    assert np.isnan(found.positions[4]).all()
    np.testing.assert_allclose(np.delete(found.positions, 4, 0), np.delete(points, 4, 0), atol=1e-9)


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        ([{"worldLandmarks": []}] * 9, "it shows nobody"),
        ([{"worldLandmarks": [{"x": 1}] * 33}] * 9, "not as MediaPipe writes them"),
        ([{"worldLandmarks": [[1, 2, 3]] * 21}] * 9, "it holds 21 joints, and blazepose-33 has 33"),
        ({"info": {"segment_lengths": {}}, "data_by_frame": {"0": {}}}, "not as FreeMoCap writes it"),
        ({"info": {"segment_lengths": {}}, "data_by_frame": []}, "not as FreeMoCap writes it"),
        ({"segment_lengths": {}}, 'no JSON object with "positions"'),
    ],
)
def test_damaged_results_are_refused(tmp_path, content, reason):
    (tmp_path / "a.json").write_text(json.dumps(content))
    with pytest.raises(UnusableMotion, match=reason):
        read_joints(tmp_path / "a.json", PoseFacts(rate=30.0))


@pytest.mark.parametrize("column", ["{axis}{number}", "landmark_{number}_{axis}", "{number}_{axis}"])
def test_landmarks_by_their_numbers(tmp_path, seen, walk, column):
    columns = [column.format(axis=axis, number=number) for number in range(33) for axis in "xyz"]
    if column.startswith("{axis}"):
        columns = [f"{axis}{number}" for number in range(1, 34) for axis in "xyz"]
    order = np.random.default_rng(0).permutation(len(columns))
    rows = [",".join(f"{value:.9f}" for value in row.ravel()[order]) for row in seen]
    path = tmp_path / "a.csv"
    path.write_text("\n".join([",".join(np.array(columns)[order]), *rows]))
    assert is_motion(path)
    found = read_joints(path, PoseFacts(rate=walk.rate, up="z"))
    assert found.joint_set == BLAZEPOSE
    np.testing.assert_allclose(found.positions, seen, atol=1e-8)
