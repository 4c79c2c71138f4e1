# SPDX-License-Identifier: GPL-3.0-or-later
"""SMPL parameters as data sets publish them: DIP, MoSh, 3DPW, InterHuman, EMDB, Fit3D and CHI3D."""

import json
import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.keypoints.facts import is_joint_file
from w2w.core.motion.motion import read_amass
from w2w.core.motion.source import UnusableMotion
from w2w.core.reading.formats import is_motion, read_motion

N_FRAMES = 40
TURNS = np.random.default_rng(0).normal(scale=0.2, size=(2 * N_FRAMES, 72))
TURNS[:, 66:] = 0
PATH = np.cumsum(np.random.default_rng(1).normal(scale=0.02, size=(2 * N_FRAMES, 3)), axis=0)
POSES, TRANS = TURNS[:N_FRAMES], PATH[:N_FRAMES]


def saved(path, content, protocol=2):
    path.write_bytes(pickle.dumps(content, protocol))
    assert is_motion(path)
    return path


def written(path, content):
    lists = {name: np.asarray(array).tolist() for name, array in content.items()}
    path.write_text(json.dumps(lists))
    assert is_motion(path)
    assert not is_joint_file(path)
    return path


def same(path, rate, n_frames=N_FRAMES, people=1, person=None, given=None):
    """Whether a file holds the motion above, at the rate."""
    found = read_amass(path, given, "y", person=person)
    np.savez(path.parent / "truth.npz", poses=TURNS, trans=PATH, mocap_framerate=rate)
    truth = read_amass(path.parent / "truth.npz", up="y")
    assert (found.rate, found.people) == (rate, people)
    np.testing.assert_allclose(found.rotations, truth.rotations[:n_frames], atol=1e-6)
    np.testing.assert_allclose(found.pelvis, truth.pelvis[:n_frames], atol=1e-6)


@pytest.mark.parametrize("rate", [60.0, 60, np.float32(60), np.array(60.0)])
def test_dip(tmp_path, rate):
    content = {"poses": POSES, "trans": TRANS, "gender": "male", "frame_rate": rate, "all_obs": []}
    same(saved(tmp_path / "a.pkl", content), 60)


def test_dip_imu_s_recordings_have_no_path_and_no_rate(tmp_path):
    path = saved(tmp_path / "a.pkl", {"gt": POSES, "imu": np.full((N_FRAMES, 17, 12), np.nan)})
    with pytest.raises(UnusableMotion, match="does not say its frame rate"):
        read_amass(path)
    assert not np.ptp(read_amass(path, 60.0, "y").pelvis, axis=0).any()


def test_mosh_says_its_rate_among_its_details(tmp_path):
    poses = np.concatenate([POSES[:, :66], np.ones((N_FRAMES, 99))], axis=1)
    details = {"mocap_frame_rate": 120.0, "mocap_time_length": 0.3, "cfg": {"mocap": {"unit": "mm"}}}
    content = {"fullpose": poses, "trans": TRANS, "betas": np.zeros(16), "stageii_debug_details": details}
    same(saved(tmp_path / "a_stageii.pkl", content), 120)
    same(saved(tmp_path / "b_stageii.pkl", content | {"mocap_frame_rate": 60}), 60)
    old = {"pose_est_fullposes": poses, "pose_est_trans": TRANS, "mocap_framerate": 100.0}
    same(saved(tmp_path / "old.pkl", old), 100)


def test_3dpw_at_the_rate_of_its_sensors(tmp_path):
    """Two people at the video's 30 Hz and at 60 Hz; the second is in view for less."""
    short = N_FRAMES // 2
    content = {
        "poses": [POSES[::2], POSES[:short:2]], "trans": [TRANS[::2], TRANS[:short:2]],
        "poses_60Hz": [POSES, POSES[:short]], "trans_60Hz": [TRANS, TRANS[:short]],
        "betas": [np.zeros(10)] * 2, "genders": ["m", "f"], "sequence": "walk",
        "jointPositions": [POSES, POSES],
        "cam_poses": np.zeros((N_FRAMES // 2, 4, 4)), "img_frame_ids": np.arange(0, N_FRAMES, 2),
    }  # fmt: skip
    path = saved(tmp_path / "a.pkl", content)
    same(path, 60, people=2)
    same(path, 60, people=2, n_frames=short, person=2)
    alone = {name: [value[0]] if isinstance(value, list) else value for name, value in content.items()}
    same(saved(tmp_path / "alone.pkl", alone), 60)


def test_interhuman(tmp_path):
    person = {"trans": TRANS, "root_orient": POSES[:, :3], "pose_body": POSES[:, 3:66], "gender": "male"}
    longer = {"trans": PATH, "root_orient": TURNS[:, :3], "pose_body": TURNS[:, 3:66]}
    path = saved(tmp_path / "1.pkl", {"mocap_framerate": 59.94, "person1": person, "person2": longer})
    same(path, 59.94, people=2, n_frames=2 * N_FRAMES)
    same(path, 59.94, people=2, person=2)


def test_emdb(tmp_path):
    smpl = {"poses_root": POSES[:, :3], "poses_body": POSES[:, 3:], "trans": TRANS, "betas": np.zeros(10)}
    same(saved(tmp_path / "a.pkl", {"name": "P0", "smpl": smpl, "fps": 30}), 30)


def in_matrices(poses):
    turns = Rotation.from_rotvec(poses[:, :66].reshape(-1, 3)).as_matrix().reshape(len(poses), 22, 3, 3)
    return {"global_orient": turns[:, :1], "body_pose": turns[:, 1:]}


@pytest.mark.parametrize("first", ["transl", "global_orient", "body_pose", "betas"])
def test_fit3d_whichever_key_comes_first(tmp_path, first):
    arrays = {"transl": TRANS, **in_matrices(POSES), "betas": np.zeros((N_FRAMES, 10))}
    arrays = {first: arrays[first]} | arrays
    path = written(tmp_path / "squat.json", arrays)
    with pytest.raises(UnusableMotion, match=r"it does not say its frame rate.* give --pose-rate"):
        read_motion(path)
    same(path, 50, given=50.0)


def test_chi3d_has_two_people_in_its_arrays(tmp_path):
    one, two = in_matrices(POSES), in_matrices(TURNS[N_FRAMES:])
    arrays = {name: np.stack([one[name], two[name]]) for name in one}
    path = written(tmp_path / "hug.json", arrays | {"transl": np.stack([TRANS, PATH[N_FRAMES:]])})
    same(path, 50, people=2, given=50.0)
    assert read_amass(path, 50.0, "y", person=2).n_frames == N_FRAMES


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ('{"transl": [[0, 0', "it cannot be read as JSON"),
        (
            '{"transl": [[0, 0, 0]], "global_orient": 3}',
            "it holds no poses of SMPL, but transl, g",
        ),
        ('{"transl": [[0, 0, 0]], "body_pose": [[1, 2], [3]]}', "it holds no poses of SMPL"),
        ('["transl"]', "it holds no poses of SMPL, but list"),
        ('{"transl": ' + "[" * 500 + "]" * 500 + ', "body_pose": [[0]]}', "it holds no poses of SMPL"),
        ('{"transl": ' + "[" * 10**5, "it cannot be read as JSON"),
    ],
)
def test_damaged_json_is_said(tmp_path, text, reason):
    (tmp_path / "a.json").write_text(text)
    with pytest.raises(UnusableMotion, match=reason):
        read_motion(tmp_path / "a.json")


@pytest.mark.parametrize(
    ("file", "rate", "people"),
    [
        ("dip_amass_like.pkl", 60, 1),
        ("mosh_stageii_like.pkl", 60, 1),
        ("3dpw_like.pkl", 60, 2),
        ("interhuman_like.pkl", 59.99, 2),
        ("fit3d_smplx_like.json", 50, 1),
    ],
)
def test_files_as_data_sets_leave_them(shared_cases, file, rate, people):
    path = shared_cases / "second/containers" / file
    found = read_amass(path, 50.0 if path.suffix == ".json" else None)
    assert (found.n_frames, found.rate, found.people) == (60, rate, people)
    assert np.median(found.rotations[:, 0, 2, 2]) > 0.9  # upright
