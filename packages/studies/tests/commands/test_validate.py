# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w validate` on small data sets made in the formats of the real ones."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from w2w.core.body.body import JOINT_INDEX, N_JOINTS, Body
from w2w.core.imu.sensor import SensorModel
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.motion.motion import Motion
from w2w.core.motion.skinning import joint_transforms
from w2w.headless.app import APP
from w2w_studies.comparisons.site_simulator import SiteSimulator
from w2w_studies.datasets.mmfit import DEVICES
from w2w_studies.datasets.vidimu import LOWER

BODY_34 = JOINT_SETS["body-34"]

FRAMES = 240
JOINTS = (
    "hips left_hip left_knee left_ankle right_hip right_knee right_ankle spine2 shoulders neck head "
    "right_shoulder right_elbow right_wrist left_shoulder left_elbow left_wrist"
).split()
"""MM-Fit's 17 by what stands for them here."""


def exercise(activity, number, rate=30.0):
    """Eight seconds of squatting or of curling the arms."""
    time = np.arange(0, FRAMES / 30 - 1e-9, 1 / rate)
    n = len(time)
    wave = 0.5 - 0.5 * np.cos(2 * np.pi * (0.4 + 0.03 * number) * time)
    rotations = np.tile(np.eye(3), (n, N_JOINTS, 1, 1))
    turn = lambda axis, angle: Rotation.from_euler(axis, angle[:, None]).as_matrix()  # noqa: E731
    pelvis = np.tile([0.0, 0.0, 0.95], (n, 1))
    for side, sign in (("left", 1), ("right", -1)):
        rotations[:, JOINT_INDEX[f"{side}_shoulder"]] = turn("y", sign * np.full(n, 1.2))
        bend = wave if activity == "bicep_curls" else 0.1 * wave
        rotations[:, JOINT_INDEX[f"{side}_elbow"]] = turn("z", -sign * (0.3 + 1.5 * bend))
        knees = wave if activity == "squats" else 0.02 * wave
        rotations[:, JOINT_INDEX[f"{side}_hip"]] = turn("x", -0.1 - 1.0 * knees)
        rotations[:, JOINT_INDEX[f"{side}_knee"]] = turn("x", 0.2 + 1.6 * knees)
        pelvis[:, 2] -= 0.15 * knees
    return Motion(rotations, pelvis, rate)


def position(positions, name):
    """Path of a joint, or of the middle of two."""
    if name in ("hips", "shoulders"):
        left, right = (positions[:, JOINT_INDEX[f"{side}_{name[:-1]}"]] for side in ("left", "right"))
        return (left + right) / 2
    return positions[:, JOINT_INDEX[name]]


@pytest.fixture(scope="module")
def mmfit(tmp_path_factory):
    """One workout of four sets of each of two exercises, and two rests; devices read the body, with noise."""
    body = Body.bundled()
    sites = {place: place for place in DEVICES.values()}
    simulator = SiteSimulator(sites, 100.0, SensorModel.ideal())
    rng = np.random.default_rng(0)
    sets = [(activity, number) for number in range(4) for activity in ("squats", "bicep_curls")]
    sets = [("rest", 0), *sets, ("rest", 1)]
    poses, readings, labels = [], [], []
    for index, (activity, number) in enumerate(sets):
        motion = exercise(activity, number)
        positions = joint_transforms(body, motion)[1]
        poses.append(np.stack([position(positions, name) for name in JOINTS], axis=1))
        readings.append(simulator.record(motion))
        if activity != "rest":
            labels.append(f"{index * 250},{index * 250 + FRAMES},5,{activity}")
    folder = tmp_path_factory.mktemp("data") / "mm-fit" / "w01"
    folder.mkdir(parents=True)
    frames = np.concatenate([index * 250 + np.arange(FRAMES) for index in range(len(sets))])
    table = np.zeros((3, len(frames), 18))
    table[:, :, 0] = frames
    table[:, :, 1:] = 1000 * np.concatenate(poses).transpose(2, 0, 1)[[0, 2, 1]] * [[[1]], [[1]], [[-1]]]
    np.save(folder / "w01_pose_3d.npy", table)
    (folder / "w01_labels.csv").write_text("\n".join(labels) + "\n")
    for column, device in enumerate(DEVICES):
        for kind in ("acc", "gyr"):
            rows = []
            for index, reading in enumerate(readings):
                seconds = index * 250 / 30 + reading.time
                values = getattr(reading, kind)[:, column] + 0.05 * (1 + column) * rng.normal(
                    size=(reading.n_samples, 3)
                )
                rows.append(np.column_stack([np.round(30 * seconds), 1000 * seconds, values]))
            np.save(folder / f"w01_{device}_{kind}.npy", np.concatenate(rows))
    return folder.parent


@pytest.mark.slow
def test_mmfit_is_simulated_ranked_and_reported(mmfit, tmp_path):
    result = CliRunner().invoke(
        APP, ["validate", "mmfit", str(mmfit), "--out", str(tmp_path), "--folds", "2"]
    )
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "validation.json").read_text())
    assert list(content["sites"]) == list(DEVICES.values())
    assert set(content["by_activity"]) == {"bicep_curls", "non_activity", "squats"}
    assert "Paired: 10 clips" in content["notes"][0]
    assert "errors of the bmi270" in content["notes"][2]
    assert "non_activity, one of the classes" in content["notes"][3]
    assert "y axis was taken to point up; in 0 clips left and right were exchanged" in content["notes"][1]
    report = (tmp_path / "report.md").read_text()
    assert "one swap of neighbours costs an activity's rho 0.10" in report
    rows = (tmp_path / "f1.csv").read_text().splitlines()
    assert rows[0] == "side,site,activity,f1,low,high"
    assert len(rows) == 1 + 2 * 5 * 4
    wrist = [float(row.split(",")[3]) for row in rows if row.startswith("simulated,left wrist,bicep")]
    assert wrist[0] > 0.9
    for name in ("f1_maps.png", "f1_sites.png"):
        assert (tmp_path / name).read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_mmfit_by_another_classifier_without_noise_and_with_rests_as_background(mmfit, tmp_path):
    options = ["--folds", "2", "--classifier", "trees", "--sensor", "ideal", "--non-activity", "background"]
    result = CliRunner().invoke(APP, ["validate", "mmfit", str(mmfit), "--out", str(tmp_path), *options])
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "validation.json").read_text())
    assert set(content["by_activity"]) == {"bicep_curls", "squats"}
    assert "free of noise" in content["notes"][2]
    assert "trained against" in content["notes"][3]
    report = (tmp_path / "report.md").read_text()
    assert report.count(", trees, ") == 2
    assert "10 clips" in report


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [
        ("--classifier", "oracle", "--classifier must be ridge, multi3net, trees, not oracle"),
        ("--sensor", "sundial", "there is no sensor preset 'sundial'"),
        ("--non-activity", "maybe", "--non-activity must be activity, background, out, not maybe"),
    ],
)
def test_a_wrong_choice_is_said_before_anything_is_read(option, value, words, tmp_path):
    asked = ["validate", "mmfit", str(tmp_path), "--out", str(tmp_path / "out"), option, value]
    result = CliRunner().invoke(APP, asked)
    assert result.exit_code == 2
    assert words in result.output.replace("\n", " ")


BODY_34_STANDS_FOR = {"torso": "spine2", "nose": "head", "pelvis": "pelvis", "neck": "neck"}
PARTS = {"toe": "foot", "heel": "ankle", "eye": "head", "ear": "head", "knuckle": "hand", "tip": "hand"}
LEG_SENSORS = dict(zip(LOWER, ("pelvis", "right_hip", "right_knee", "left_hip", "left_knee"), strict=True))


@pytest.fixture(scope="module")
def vidimu(tmp_path_factory):
    """Four trials of each of two activities of the legs, as VIDIMU's files hold them."""
    body, folder = Body.bundled(), tmp_path_factory.mktemp("videoandimus")
    for activity, shown in (("A01", "bicep_curls"), ("A04", "squats")):
        for number in range(4):
            stem = folder / f"S4{number}_{activity}_T01"
            positions = joint_transforms(body, exercise(shown, number))[1]
            header, columns = [], []
            for joint in BODY_34.joints:
                side, _, part = joint.partition("_")
                known = next((f"{side}_{PARTS[end]}" for end in PARTS if part.endswith(end)), joint)
                name = BODY_34_STANDS_FOR.get(
                    joint, known.replace("left_head", "head").replace("right_head", "head")
                )
                header += [f"{joint}_{axis}" for axis in "xyz"]
                columns.append(1000 * positions[:, JOINT_INDEX[name]][:, [0, 2, 1]] * [1, -1, 1])
            table = np.concatenate(columns, axis=1)
            np.savetxt(stem.with_suffix(".csv"), table, "%.4f", ",", header=",".join(header), comments="")
            turns = joint_transforms(body, exercise(shown, number, rate=50.0))[0]
            rows = ["QUAT,w,x,y,z"]
            for frame in [turns[0], *turns]:
                for sensor, joint in LEG_SENSORS.items():
                    x, y, z, w = Rotation.from_matrix(frame[JOINT_INDEX[joint]]).as_quat()
                    rows.append(f"{sensor},{w:.8f},{x:.8f},{y:.8f},{z:.8f}")
            stem.with_suffix(".raw").write_text("\n".join(rows) + "\n")
    return folder


@pytest.mark.slow
def test_vidimu_is_compared_by_angular_velocity_alone(vidimu, tmp_path):
    result = CliRunner().invoke(
        APP, ["validate", "vidimu", str(vidimu), "--out", str(tmp_path), "--folds", "2"]
    )
    assert result.exit_code == 0, result.output
    content = json.loads((tmp_path / "validation_lower_body.json").read_text())
    assert list(content["sites"]) == list(LOWER)
    assert "Angular velocity only" in content["notes"][0]
    assert "-y axis was taken to point up; in 0 clips" in content["notes"][2]
    assert not (tmp_path / "report_upper_body.md").exists()
    rows = (tmp_path / "f1_lower_body.csv").read_text().splitlines()
    for side in ("real", "simulated"):
        thigh = [float(row.split(",")[3]) for row in rows if row.startswith(f"{side},qsRUL,sit_to_stand")]
        assert thigh[0] > 0.9


@pytest.mark.parametrize("name", ["mmfit", "vidimu", "utd-mhad"])
def test_a_folder_without_the_data_gets_a_sentence(name, tmp_path):
    result = CliRunner().invoke(APP, ["validate", name, str(tmp_path), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "holds no" in result.output.replace("\n", " ")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(("name", "held"), [("mhad", ""), ("umafall", ""), ("upfall", "CompleteDataSet.csv")])
def test_a_folder_in_place_of_a_file_gets_a_sentence(name, held, tmp_path):
    given = [str(tmp_path), str(tmp_path), "--out", str(tmp_path / "out")]
    result = CliRunner().invoke(APP, ["validate", name, *given], env={"COLUMNS": "400"})
    assert result.exit_code == 2
    assert f"{tmp_path / held} cannot be opened: " in result.output
    assert "Errno" not in result.output
    truth = CliRunner().invoke(
        APP, ["study", "truth", str(tmp_path), f"--{name}", *given[1:]], env={"COLUMNS": "400"}
    )
    assert truth.exit_code == 2
    assert f" is left out: {tmp_path / held} cannot be opened: " in truth.output


def test_dsads_is_looked_for_before_the_library_is_simulated(tmp_path):
    asked = ["validate", "dsads", str(tmp_path), str(tmp_path / "library")]
    result = CliRunner().invoke(APP, [*asked, "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert "holds no segments a01/p1/s01.txt of DSADS" in result.output.replace("\n", " ")
