# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w calibrate`, from files of a worn sensor and of a motion to a sensor that other commands take."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.imu.formats import write_csv, write_recording
from w2w.core.imu.presets import read_sensor
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.motion.motion import Motion
from w2w.headless.app import APP
from w2w_studies.comparisons.site_simulator import SiteSimulator

TURN = Rotation.from_euler("xyz", [70, 20, -40], degrees=True)
WORN = SensorModel(
    name="worn",
    accelerometer=Triad(noise_density=0.003),
    gyroscope=Triad(noise_density=0.0003),
    worn_turn_deg=tuple(TURN.inv().as_rotvec(degrees=True)),
)


def arm_swing(number):
    time = np.arange(360) / 60
    rotations = np.tile(np.eye(3), (360, N_JOINTS, 1, 1))
    for joint, axis, pace in (("right_shoulder", "yz", 0.7), ("right_elbow", "zx", 1.1)):
        angles = np.stack([np.sin(2 * np.pi * (pace + 0.1 * number) * time + k) for k in (0, 1)], axis=1)
        rotations[:, JOINT_INDEX[joint]] = Rotation.from_euler(axis, angles).as_matrix()
    pelvis = np.tile([0.0, 0.0, 0.95], (360, 1))
    return Motion(rotations, pelvis, 60.0, clip=f"swing {number}")


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Two recordings, the motions shown, a motion that no sensor was worn with, and a damaged recording."""
    folder = tmp_path_factory.mktemp("own")
    (folder / "worn").mkdir()
    (folder / "motions").mkdir()
    simulator = SiteSimulator({"right wrist": "right wrist"}, 50.0, WORN)
    for number in range(2):
        motion = arm_swing(number)
        motion.save(folder / "motions" / f"swing_{number}.npz")
        write_csv(folder / "worn" / f"swing_{number}.csv", simulator.record(motion))
    arm_swing(7).save(folder / "motions" / "alone.npz")
    arm_swing(8).save(folder / "motions" / "damaged.npz")
    (folder / "worn" / "damaged.csv").write_text("time_s,acc_x\n0,1\n")
    return folder


def calibrate(*arguments):
    return CliRunner().invoke(APP, ["calibrate", *map(str, arguments)])


@pytest.mark.slow
def test_a_sensor_is_written_that_synth_takes(folders, tmp_path):
    out = tmp_path / "mine.json"
    done = calibrate(folders / "worn", folders / "motions", "--patch", "right wrist", "--out", out)
    assert done.exit_code == 0, done.output
    told = " ".join(done.output.split())
    assert "2 recordings against the right wrist" in told
    assert "damaged.csv is left out: " in told
    assert "each recording left out of the fit" in told
    found = read_sensor(out)
    turn = Rotation.from_rotvec(found.worn_turn_deg, degrees=True).inv()
    assert np.degrees((turn * TURN.inv()).magnitude()) < 3
    signal = tmp_path / "one.csv"
    arguments = [
        "synth",
        str(folders / "motions" / "swing_0.npz"),
        "--patch",
        "right wrist",
        "--out",
        str(signal),
    ]
    assert CliRunner().invoke(APP, [*arguments, "--sensor", str(out), "--rate", "50"]).exit_code == 0
    made, worn = (
        np.loadtxt(path, delimiter=",", skiprows=8)[:, 1:4]
        for path in (signal, folders / "worn" / "swing_0.csv")
    )
    assert np.corrcoef(made.ravel(), worn.ravel())[0, 1] > 0.97


@pytest.mark.slow
def test_one_recording_and_one_motion_do(folders, tmp_path):
    out = tmp_path / "one.json"
    done = calibrate(
        folders / "worn" / "swing_1.csv",
        folders / "motions" / "swing_1.npz",
        "--patch",
        "right wrist",
        "-o",
        out,
    )
    assert done.exit_code == 0, done.output
    assert "each half left out of the fit" in " ".join(done.output.split())
    assert json.loads(out.read_text())["name"] == "one"


@pytest.mark.slow
def test_two_sensors_in_one_file_are_refused(folders, tmp_path):
    write_recording(tmp_path / "two.npz", ImuRecording(np.ones((90, 2, 3)), np.ones((90, 2, 3)), 50.0))
    motion = folders / "motions" / "swing_0.npz"
    done = calibrate(tmp_path / "two.npz", motion, "--patch", "right wrist", "--out", tmp_path / "mine.json")
    assert done.exit_code == 1
    assert "it holds 2 sensors: give each its own file" in " ".join(done.output.split())
    assert not (tmp_path / "mine.json").exists()


@pytest.mark.parametrize(
    ("change", "code", "why"),
    [
        pytest.param(
            {"patch": "no such place"},
            2,
            'no placement, sensor site or region is called "no such place"',
            marks=pytest.mark.slow,
        ),
        ({"out": "mine.txt"}, 2, "--out must end in .json"),
        ({"sensor": "nothing"}, 2, "there is no sensor preset 'nothing'"),
        ({"real": "gone.csv"}, 2, "gone.csv is not there"),
        ({"motion": "empty"}, 2, "no file in empty has the name of one in"),
        ({"real": "worn/swing_0.csv"}, 2, "give two files, or two folders"),
    ],
)
def test_what_is_wrong_is_said(tmp_path, monkeypatch, change, code, why):
    monkeypatch.chdir(tmp_path)
    for folder in ("worn", "motions", "empty"):
        (tmp_path / folder).mkdir()
    (tmp_path / "worn" / "swing_0.csv").write_text("")
    (tmp_path / "motions" / "swing_0.npz").write_bytes(b"")
    given = {"real": "worn", "motion": "motions"} | change
    options = {"patch": "right wrist", "out": tmp_path / "mine.json", "sensor": "ideal"} | change
    words = [word for name in ("patch", "out", "sensor") for word in (f"--{name}", options[name])]
    done = calibrate(given["real"], given["motion"], *words)
    assert done.exit_code == code
    assert why in " ".join(done.output.split())
    assert not (tmp_path / "mine.json").exists()
