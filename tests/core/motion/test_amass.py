# SPDX-License-Identifier: GPL-3.0-or-later
"""SMPL motions under the names and axes that files in the wild use; what is none is refused truly."""

import csv
import zipfile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import N_JOINTS, Y_UP_TO_Z_UP
from w2w.core.keypoints.facts import is_joint_file
from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import UnusableMotion

BODY = 22
"""Joints before the hands."""


@pytest.fixture
def arrays(waving, tmp_path):
    """`waving` as its own npz has it: poses (T, 72), trans, rate."""
    waving.save(tmp_path / "waving.npz")
    with np.load(tmp_path / "waving.npz") as data:
        return dict(data)


def read(tmp_path, name="clip.npz", **arrays):
    with (tmp_path / name).open("wb") as stream:
        np.savez(stream, **arrays)
    return read_amass(tmp_path / name)


def check(motion, waving):
    np.testing.assert_allclose(motion.rotations[:, :BODY], waving.rotations[:, :BODY], atol=1e-6)
    np.testing.assert_allclose(motion.pelvis, waving.pelvis, atol=1e-6)
    assert motion.rate == waving.rate


@pytest.mark.parametrize("extra", [84, 93, -6])
def test_smpl_h_smpl_x_and_bodies_without_hands(tmp_path, arrays, waving, extra):
    poses = arrays["poses"]
    poses = poses[:, :66] if extra < 0 else np.concatenate([poses, np.full((len(poses), extra), 0.3)], axis=1)
    check(read(tmp_path, poses=poses, trans=arrays["trans"], mocap_frame_rate=np.array(30.0)), waving)


@pytest.mark.parametrize(
    "names",
    [("root_orient", "pose_body", "trans", "fps"), ("global_orient", "body_pose", "transl", "framerate")],
)
def test_root_and_body_kept_apart(tmp_path, arrays, waving, names):
    root, body, trans, rate = names
    parts = {root: arrays["poses"][:, :3], body: arrays["poses"][:, 3:66].reshape(-1, 21, 3)}
    check(read(tmp_path, **parts, **{trans: arrays["trans"], rate: np.array(30)}), waving)


def to_y_up(arrays):
    """The same file in y-up axes: the whole world turned back."""
    poses, trans = arrays["poses"].copy(), arrays["trans"]
    turn = Rotation.from_matrix(Y_UP_TO_Z_UP.T)
    poses[:, :3] = (turn * Rotation.from_rotvec(poses[:, :3])).as_rotvec()
    from w2w.core.motion.motion import SMPL_PELVIS

    return poses, (trans + SMPL_PELVIS) @ Y_UP_TO_Z_UP - SMPL_PELVIS


def test_y_up_files_are_turned(tmp_path, arrays, waving):
    poses, trans = to_y_up(arrays)
    check(read(tmp_path, poses=poses, trans=trans, fps=np.array(30.0)), waving)


@pytest.mark.parametrize("joints", [BODY, N_JOINTS])
def test_smpl_containers(tmp_path, arrays, waving, joints):
    """What Meshcapade's smplcodec writes: y up, single precision, camel case."""
    poses, trans = to_y_up(arrays)
    container = {
        "codecVersion": np.int32(2),
        "smplVersion": np.int32(2 if joints == BODY else 0),
        "gender": np.int32(0),
        "frameCount": np.int32(len(poses)),
        "frameRate": np.float32(30),
        "shapeParameters": np.zeros(10, np.float32),
        "bodyPose": poses[:, : 3 * joints].reshape(len(poses), joints, 3).astype(np.float32),
        "bodyTranslation": trans.astype(np.float32),
    }
    check(read(tmp_path, "clip.smpl", **container), waving)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"trans": None}, "'trans' is missing"),
        ({"mocap_framerate": None}, "does not say its frame rate.*save it again with 'mocap_framerate'"),
        ({"poses": np.zeros((60, 24, 4))}, r"\(60, 24, 4\), which look like quaternions"),
        ({"poses": np.zeros((60, 70))}, r"shape \(60, 70\); expected axis-angle"),
        ({"poses": np.zeros((1, 72)), "trans": np.zeros((1, 3))}, "a pose, not a motion: 1 frame$"),
        ({"trans": np.zeros((59, 3))}, "60 frames but its 'trans' has 59"),
        (
            {"trans": np.full((60, 3), -1e300)},
            r"^its 'trans' reach 1e\+300 m, which no body does: it is damaged, or not in metres$",
        ),
        (
            {"poses": np.full((60, 72), 1e300)},
            r"^its 'poses' reach 1e\+300 rad, which no body does: it is damaged, or not in radians$",
        ),
        # single precision, in which many files are, has steps of 0.5 rad there
        ({"poses": np.full((60, 72), 5e6)}, r"^its 'poses' reach 5e\+06 rad, which no body does"),
        ({"trans": np.full((60, 3), np.nan)}, r"^its 'trans' hold values that are not finite \(NaN or"),
        ({"poses": np.full((60, 72), np.inf)}, r"^its 'poses' hold values that are not finite \(NaN or"),
        ({"mocap_framerate": np.array(1e9)}, r"^it says 1e\+09 frames a second; motions have 1 to 2,000"),
        ({"mocap_framerate": np.array(1e-3)}, r"^it says 0.001 frames a second"),
    ],
)
def test_what_is_missing_is_said(tmp_path, arrays, change, reason):
    changed = {key: value for key, value in (arrays | change).items() if value is not None}
    with pytest.raises(UnusableMotion, match=reason):
        read(tmp_path, **changed)


@pytest.mark.parametrize(
    ("damage", "reason"),
    [
        (lambda _: b"no zip", "it is no zip archive, which an npz file is"),
        (lambda data: data[: len(data) // 2], "it is no zip archive, which an npz file is"),
        (lambda data: data.replace(b"poses.npy", b"pos\x00s.npy", 1), "it is damaged"),
        (lambda data: data.replace(b"\x93NUMPY", b"\x93NUMPX"), "its 'poses' is damaged"),
        (lambda _: b"", "the file is empty (0 bytes)"),
        (lambda _: b"version https://git-lfs.github.com/spec/v1\n", "it is a Git LFS pointer"),
    ],
    ids=["text", "cut", "name", "magic", "empty", "pointer"],
)
def test_damage_is_told_without_raw_bytes(tmp_path, waving, damage, reason):
    waving.save(tmp_path / "clip.npz")
    (tmp_path / "clip.npz").write_bytes(damage((tmp_path / "clip.npz").read_bytes()))
    with pytest.raises(UnusableMotion) as said:
        read_amass(tmp_path / "clip.npz")
    assert reason in str(said.value)
    assert "b'" not in str(said.value)


def test_an_array_of_another_kind_is_told_without_raw_bytes(tmp_path):
    stored = tmp_path / "clip.npz"
    with zipfile.ZipFile(stored, "w") as archive:
        archive.writestr("poses.npy", b"\x93NUMPX\x01\x00 nonsense")
    with pytest.raises(UnusableMotion, match=r"^its 'poses' is damaged or holds neither numbers nor text$"):
        read_amass(stored)


def test_the_pelvis_of_a_real_clip_lies_among_the_markers_around_it(shared_data):
    """Below those of the waist, above those on the hips, and inside them: what was measured in the world."""
    path = shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz"
    pelvis = read_amass(path).pelvis
    with np.load(path) as data:
        names = [name.decode() for name in data["marker_labels"].tolist()]
        markers = dict(zip(names, data["marker_data"].swapaxes(0, 1), strict=True))
    waist = np.stack([markers[name] for name in ("LFWT", "RFWT", "LBWT", "RBWT")])
    hips = np.stack([markers[name] for name in ("LHIP", "RHIP")])
    assert (pelvis[:, 2] < waist[..., 2].mean(axis=0)).all()
    assert (pelvis[:, 2] > hips[..., 2].mean(axis=0)).all()
    assert (pelvis[:, :2] > waist[..., :2].min(axis=0)).all()
    assert (pelvis[:, :2] < waist[..., :2].max(axis=0)).all()


REASONS = {
    "apose_to_handsFront_smplx.npz": "does not say its frame rate",
    "pose_avatar.smpl": "a pose, not a motion: 1 frame",
    "0000.npz": "look like quaternions",
    "body_pose_rnd.npz": "it holds data and no 'poses'",
}


def test_every_real_file_is_used_or_refused_truly(shared_data):
    with (shared_data / "motions.csv").open(newline="", encoding="utf-8") as stream:
        rows = [row["file"] for row in csv.DictReader(stream) if row["format"] in ("npz", "smpl")]
    outcomes = {file.rsplit("/", 1)[1]: outcome(shared_data / file) for file in rows}
    assert outcomes.keys() == {"amass_sample.npz", *REASONS}
    for file, words in outcomes.items():
        assert REASONS.get(file, "used") in words


def outcome(path):
    try:
        read_amass(path)
    except UnusableMotion as error:
        return str(error)
    return "used"


def test_a_small_file_that_unpacks_to_gigabytes_is_refused_by_its_header(shared_cases):
    with pytest.raises(UnusableMotion, match="too long to be read at once"):
        read_amass(shared_cases / "bomb.npz")


def test_a_file_that_says_it_holds_days_is_refused_by_its_header(tmp_path):
    with zipfile.ZipFile(tmp_path / "short.npz", "w") as archive:  # its header says more than it holds
        header = b"{'descr': '<f8', 'fortran_order': False, 'shape': (3541856, 72)}"
        archive.writestr("poses.npy", b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header)
    with pytest.raises(UnusableMotion, match="too long to be read at once"):
        read_amass(tmp_path / "short.npz")


def test_motion_x_s_322_numbers(tmp_path, arrays, waving):
    numbers = np.random.default_rng(0).normal(size=(len(arrays["poses"]), 322))
    numbers[:, :66], numbers[:, 309:312] = arrays["poses"][:, :66], arrays["trans"]
    np.save(tmp_path / "a.npy", numbers)
    assert not is_joint_file(tmp_path / "a.npy")
    check(read_amass(tmp_path / "a.npy", waving.rate, "z"), waving)
    with pytest.raises(UnusableMotion, match="it does not say its frame rate"):
        read_amass(tmp_path / "a.npy")
    np.save(tmp_path / "a.npy", numbers[:, :321])
    assert is_joint_file(tmp_path / "a.npy")
