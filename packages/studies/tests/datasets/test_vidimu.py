# SPDX-License-Identifier: GPL-3.0-or-later
"""VIDIMU's files, made as its tools describe them."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w_studies.datasets.vidimu import LOWER, SITES, UPPER, angular_velocity, read_trial, read_vidimu

BODY_34 = JOINT_SETS["body-34"]

N = 100
SPIN = {name: np.array([0.5 * k, -1.0, 0.3]) for k, name in enumerate(SITES)}


def write_raw(path, sensors):
    """Interleaved orientations of sensors that spin steadily; the first row of each is another pose."""
    lines = ["NUM,QUAT,w,x,y,z"]
    for row in range(N + 1):
        for name in sensors:
            turn = (
                Rotation.from_rotvec(SPIN[name] * row / 50) if row else Rotation.from_rotvec([1.0, 2.0, 0.0])
            )
            x, y, z, w = turn.as_quat()
            lines.append(f"{row},{name},{w:.9f},{x:.9f},{y:.9f},{z:.9f}")
    path.write_text("\n".join(lines) + "\n")


def write_pose(path, n_frames=60):
    header = ",".join(f"{joint}_{axis}" for joint in BODY_34.joints for axis in "xyz")
    header = header.replace("right_thumb_tip_x", " right_thumb_tip_x")
    rows = [",".join(f"{1000 * j + k}" for j in range(34) for k in range(3)) for _ in range(n_frames)]
    path.write_text("\n".join([header, *rows]) + "\n")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "S40").mkdir()
    for stem, sensors in (("S40_A04_T01", LOWER), ("S40_A07_T02", UPPER)):
        write_raw(tmp_path / "S40" / f"{stem}.raw", sensors)
        write_pose(tmp_path / "S40" / f"{stem}.csv")
    return tmp_path


def test_trials_have_rates_by_sensor_and_joints(folder):
    lower, upper = read_vidimu(folder)
    assert (lower.recording.activity, upper.recording.activity) == ("sit_to_stand", "drink_right_arm")
    assert lower.recording.sites == LOWER
    assert upper.recording.sites == UPPER
    assert lower.recording.subject == "S40"
    for trial in (lower, upper):
        assert trial.recording.n_samples == N
        expected = np.stack([SPIN[name] for name in trial.recording.sites])
        np.testing.assert_allclose(trial.recording.gyr, np.tile(expected, (N, 1, 1)), atol=1e-4)
        assert not trial.recording.acc.any()
        assert trial.pose.shape == (60, 34, 3)
        np.testing.assert_array_equal(trial.pose[3, 33], [33000, 33001, 33002])


def test_every_sensor_has_a_place():
    assert len(LOWER) == len(UPPER) == 5


def test_angular_velocity_of_a_steady_spin_is_exact():
    turns = Rotation.from_rotvec(np.outer(np.arange(20) / 50, [0.3, 2.0, -1.0]))
    quaternions = turns.as_quat()[:, [3, 0, 1, 2]] * np.where(np.arange(20) % 2, 1, -1)[:, None]
    np.testing.assert_allclose(
        angular_velocity(quaternions, 50), np.tile([0.3, 2.0, -1.0], (20, 1)), atol=1e-9
    )


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("S40_A04_T01.raw", "NUM,QUAT,w,x,y\n1,qsHIPS,1,0,0\n1,qsHIPS,1,0,0\n", "lacks the columns QUAT"),
        ("S40_A04_T01.raw", "NUM,QUAT,w,x,y,z\n" + "1,qsHIPS,1,0,0,0\n" * 9, "lacks the sensors qsRUL"),
        ("S40_A04_T01.raw", "NUM,QUAT,w,x,y,z\n" + "1,qsHIPS,1,?,0,0\n" * 9, "damaged row"),
        ("S40_A04_T01.raw", "", "has no rows"),
        ("S40_A04_T01.csv", "pelvis_x,pelvis_y\n1,2\n1,2\n", "lacks the column pelvis_z"),
    ],
)
def test_what_is_not_vidimu_is_refused_with_a_sentence(folder, name, content, message):
    (folder / "S40" / name).write_text(content)
    with pytest.raises(ValueError, match=message):
        read_vidimu(folder)


def test_orientations_that_are_no_rotations_are_refused(folder):
    path = folder / "S40" / "S40_A04_T01.raw"
    lines = path.read_text().splitlines()
    path.write_text("\n".join([lines[0], *[line.rsplit(",", 4)[0] + ",2,0,0,0" for line in lines[1:]]]))
    with pytest.raises(ValueError, match="no unit quaternions"):
        read_trial(path)


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(ValueError, match="holds no trials"):
        read_vidimu(tmp_path)


def test_a_file_of_another_name_is_refused(folder):
    path = (folder / "S40" / "S40_A04_T01.raw").rename(folder / "S40" / "S40_A99_T01.raw")
    with pytest.raises(ValueError, match="is no trial of VIDIMU"):
        read_trial(path)
