# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w export`: what is written is what the run recorded, in the layout that the other tool documents."""

import importlib.util
import json
import shutil

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, JOINT_NAMES
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.vendor_formats import read_xsens_txt
from w2w.core.motion.motion import SMPL_PELVIS, Motion, at_rate, read_amass
from w2w.core.motion.skinning import joint_transforms
from w2w.core.patches.patches import PatchSet
from w2w.core.windows.windows import WindowSpec, cut_windows

from ...command_line import cli
from ...orientation_sto import read_orientation_sto

pytestmark = pytest.mark.usefixtures("made_once_here")

Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""What TransPose's preprocessing turns AMASS by (`amass_rot`)."""


@pytest.fixture(scope="module")
def results(made_once):
    """A finished run of eight made clips at 96 places."""
    return made_once("export", _run) / "out"


def _run(folder):
    library, time = folder / "motions", np.arange(150) / 30
    for activity, pace in (("slow", 0.5), ("fast", 2.0)):
        (library / activity).mkdir(parents=True)
        for number in range(4):
            axes = np.random.default_rng(number).normal(size=(24, 3)) / 5
            angles = np.sin(2 * np.pi * pace * (1 + number / 20) * time)
            turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
            pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
            Motion(turns.reshape(-1, 24, 3, 3), pelvis, 30.0).save(library / activity / f"{number}.npz")
    code, output = cli(
        "run", library, "--out", folder / "out", "--patches", 96, "--folds", 2, "--no-pictures",
        "--no-report", "--workers", 1, "--sensor", "ideal",
    )  # fmt: skip
    assert code == 0, output


def recording_of(results, clip="slow_0"):
    return ImuRecording.load(results / "signals" / f"{clip}.npz")


def exported(results, tmp_path, tool, *options):
    code, output = cli("export", results, "--for", tool, "--out", tmp_path / tool, *options)
    assert code == 0, output
    assert not list(tmp_path.glob(".*"))
    return tmp_path / tool


@pytest.mark.slow
def test_arrays_for_aeon_and_sktime(results, tmp_path):
    folder = exported(results, tmp_path, "aeon", "--places", "left wrist, sternum")
    x, y, clip = (np.load(folder / f"{name}.npy", allow_pickle=False) for name in ("X", "y", "clip"))
    facts = json.loads((folder / "facts.json").read_text())
    assert x.dtype == np.float32
    assert x.shape == (len(y), 12, 100)  # cases, channels, time points
    assert set(y) == {"slow", "fast"}
    assert len(set(clip)) == 8
    whole = recording_of(results)
    patch = [whole.sites.index(name.rsplit(" ", 2)[0]) for name in facts["channels"][::6]]
    windows = cut_windows(whole, WindowSpec())
    mine = x[clip == "slow_0"].reshape(-1, 2, 6, 100)
    np.testing.assert_array_equal(mine.transpose(0, 1, 3, 2), windows.signals[:, patch])
    np.testing.assert_array_equal(np.load(folder / "is_test.npy")[clip == "slow_0"], windows.is_test)
    assert (facts["rate_hz"], facts["classes"], facts["units"][:4]) == (
        50,
        ["fast", "slow"],
        ["m/s2"] * 3 + ["rad/s"],
    )


@pytest.mark.slow
def test_a_dataset_for_pytorch_that_needs_no_w2w(results, tmp_path, torch):
    folder = exported(results, tmp_path, "torch", "--places", "left wrist")
    spec = importlib.util.spec_from_file_location("w2w_windows", folder / "w2w_windows.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    data = module.Windows(folder, clips=["slow_0", "fast_1"])
    x, y = next(iter(torch.utils.data.DataLoader(data, batch_size=len(data))))
    assert x.shape[1:] == (6, 100)
    assert x.dtype == torch.float32
    names = np.array(data.classes)[y.numpy()]
    assert {(clip, name) for clip, name in zip(data.clips, names, strict=True)} == {
        ("slow_0", "slow"), ("fast_1", "fast"),
    }  # fmt: skip
    assert 0 < len(module.Windows(folder, train=False)) < len(module.Windows(folder))
    stored = np.load(folder / "X.npy")[np.isin(np.load(folder / "clip.npy"), ["slow_0", "fast_1"])]
    np.testing.assert_array_equal(x.numpy(), stored)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["transpose", "imuposer", "mobileposer"])
def test_training_data_of_pose_estimators(results, bundled_body, tmp_path, torch, method):
    folder = exported(results, tmp_path, method)
    facts = json.loads((folder / "clips.json").read_text())
    clips = [clip for clip, *_ in facts["clips"]]
    parts = {path.stem: torch.load(path, weights_only=True) for path in folder.glob("*.pt")}
    is_mobile, whole = method == "mobileposer", parts.pop("test", parts.pop("w2w", None))
    if is_mobile:
        assert parts == {}
        parts = {"vacc": whole.pop("acc"), "vrot": whole.pop("ori"), **whole}
    elif method == "transpose":
        assert whole.keys() == {"acc", "ori", "pose", "tran"}
        assert all(map(torch.equal, whole["acc"], parts["vacc"]))
    expected = {"pose", "tran", "shape", "joint", "vrot", "vacc"}
    assert set(parts) == (expected | {"contact"} if is_mobile else expected)
    assert all(len(values) == 8 for values in parts.values())
    legs = "lower leg" if method == "transpose" else "thigh"
    places = ["left forearm", "right forearm", f"left {legs}", f"right {legs}", "head", "pelvis"]
    assert [name.split(" ", 1)[1] for name in facts["sensors"]] == places
    number = clips.index("fast_1")
    one = {name: values[number].numpy() for name, values in parts.items()}
    assert facts["rate_hz"] == (30 if is_mobile else 60)
    n_frames, step = (150, 1) if is_mobile else (299, 2)  # of 150 frames at 30 Hz
    assert {name: values.shape for name, values in one.items()} == {
        "pose": (n_frames, 24, *((3, 3) if is_mobile else (3,))), "tran": (n_frames, 3), "shape": (10,),
        "joint": (n_frames, 24, 3), "vrot": (n_frames, 6, 3, 3), "vacc": (n_frames, 6, 3),
    } | ({"contact": (n_frames, 2)} if is_mobile else {})  # fmt: skip
    assert all(values.dtype in (np.float32, np.int32) for values in one.values())
    motion = Motion.load(results / "motions" / "fast_1.npz")
    stored = np.load(results / "motions" / "fast_1.npz")
    pose = one["pose"][::step]
    if not is_mobile:
        pose = Rotation.from_rotvec(pose.reshape(-1, 3)).as_matrix().reshape(-1, 24, 3, 3)
    amass = Rotation.from_rotvec(stored["poses"].reshape(-1, 3)).as_matrix().reshape(-1, 24, 3, 3)
    np.testing.assert_allclose(pose[:, 1:], amass[:, 1:], atol=1e-5)
    np.testing.assert_allclose(pose[:, 0], Y_UP @ amass[:, 0], atol=1e-5)
    np.testing.assert_allclose(one["tran"][::step], stored["trans"] @ Y_UP.T, atol=1e-5)
    _, joints = joint_transforms(bundled_body, motion)
    np.testing.assert_allclose(one["joint"][::step], (joints - SMPL_PELVIS) @ Y_UP.T, atol=1e-5)
    np.testing.assert_allclose(one["joint"][:, 0], one["tran"], atol=1e-5)
    # the head's sensor rides on the head's bone: its orientation is that bone's, as after calibration
    world = pose[:, 0]
    for joint in ("spine1", "spine2", "spine3", "neck", "head"):
        world = world @ pose[:, JOINT_INDEX[joint]]
    apart = Rotation.from_matrix(world.swapaxes(1, 2) @ one["vrot"][::step, 4]).magnitude()
    assert np.degrees(apart).max() < 3
    assert abs(one["vacc"][10:-10, 4].mean(axis=0)).max() < 1.5  # no 9.81 is left in it


@pytest.mark.slow
def test_acceleration_without_gravity_is_the_places_own(results, bundled_body, tmp_path, torch):
    vertex = int(bundled_body.vertices[:, 2].argmax())
    folder = exported(
        results, tmp_path, "transpose", "--places", f"{vertex}, left wrist", "--sensor", "ideal"
    )
    facts = json.loads((folder / "clips.json").read_text())
    assert facts["sensors"] == [f"vertex {vertex}", "left wrist"]
    number = [clip for clip, *_ in facts["clips"]].index("slow_2")
    acceleration = torch.load(folder / "vacc.pt", weights_only=True)[number].numpy()
    motion = at_rate(Motion.load(results / "motions" / "slow_2.npz"), 60.0)
    turns, joints = joint_transforms(bundled_body, motion)
    head = JOINT_INDEX["head"]
    top = joints[:, head] + turns[:, head] @ (bundled_body.vertices[vertex] - bundled_body.joints[head])
    second = (top[2:] - 2 * top[1:-1] + top[:-2]) * 3600 @ Y_UP.T
    inner = slice(20, -20)
    error = acceleration[1:-1][inner, 0] - second[inner]
    assert np.sqrt((error**2).mean()) < 0.15 * np.sqrt((second[inner] ** 2).mean())


@pytest.mark.slow
def test_bids_motion(results, tmp_path):
    folder = exported(results, tmp_path, "bids", "--places", "left wrist")
    about = json.loads((folder / "dataset_description.json").read_text())
    assert about["BIDSVersion"] == "1.9.0"
    people = (folder / "participants.tsv").read_text().splitlines()
    assert people == ["participant_id\tname", "sub-unknown\tunknown"]
    files = sorted(path.name for path in (folder / "sub-unknown" / "motion").iterdir())
    assert len(files) == 4 * 8
    stem = folder / "sub-unknown" / "motion" / "sub-unknown_task-slow_tracksys-imu_run-1"
    facts = json.loads(stem.with_name(f"{stem.name}_motion.json").read_text())
    assert (facts["TaskName"], facts["SamplingFrequency"], facts["TrackedPointsCount"]) == ("slow", 50, 1)
    assert (facts["ACCELChannelCount"], facts["GYROChannelCount"], facts["MotionChannelCount"]) == (3, 3, 6)
    header, *channels = [
        line.split("\t") for line in stem.with_name(f"{stem.name}_channels.tsv").read_text().splitlines()
    ]
    assert header == ["name", "component", "type", "tracked_point", "units", "placement", "reference_frame"]
    assert [(row[1], row[2], row[4]) for row in channels] == [
        *((axis, "ACCEL", "m/s^2") for axis in "xyz"), *((axis, "GYRO", "rad/s") for axis in "xyz"),
    ]  # fmt: skip
    values = np.loadtxt(stem.with_name(f"{stem.name}_motion.tsv"), delimiter="\t", dtype=np.float32)
    whole = recording_of(results)
    patch = whole.sites.index(channels[0][3].replace("_", " "))
    np.testing.assert_array_equal(values, np.concatenate([whole.acc[:, patch], whole.gyr[:, patch]], axis=1))


@pytest.mark.slow
def test_opensim_and_xsens(results, bundled_body, tmp_path):
    folder = exported(results, tmp_path, "opensim", "--places", "left wrist, sternum")
    quaternions, rate, sites = read_orientation_sto(folder / "slow_0.sto")
    assert (rate, sites) == (50, ("left_wrist", "sternum"))
    text = (folder / "slow_0.trc").read_text().splitlines()
    assert text[0].split("\t")[:3] == ["PathFileType", "4", "(X/Y/Z)"]
    names = text[3].split("\t")
    assert names[:2] == ["Frame#", "Time"]
    assert tuple(name for name in names[2:] if name) == JOINT_NAMES
    rows = np.array([line.split("\t") for line in text[6:]], dtype=float)
    assert text[2].split("\t")[:5] == ["50", "50", str(len(rows)), "24", "m"]
    assert len(rows) == len(quaternions)
    points = rows[:, 2:].reshape(len(rows), 24, 3)
    assert (points[:, JOINT_INDEX["head"], 1] > points[:, JOINT_INDEX["left_knee"], 1]).all()  # y is up
    motion = at_rate(Motion.load(results / "motions" / "slow_0.npz"), 50.0)
    np.testing.assert_allclose(points, joint_transforms(bundled_body, motion)[1] @ Y_UP.T, atol=1e-6)
    folder = exported(results, tmp_path, "xsens", "--places", "left wrist, sternum")
    recording = read_xsens_txt(folder / "slow_0" / "left_wrist.txt")
    turned = recording.orientation[:, 0]
    np.testing.assert_allclose(np.abs((turned * quaternions[:, 0]).sum(axis=1)), 1, atol=1e-6)
    patches = PatchSet.load(results / ".w2w" / "patches.npz")
    assert recording.n_samples == len(turned)
    assert len(patches) == 96


@pytest.mark.slow
def test_parquet(results, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", exc_type=ImportError)
    folder = exported(results, tmp_path, "parquet", "--places", "left wrist, sternum")
    table = parquet.read_table(folder / "data")
    channels = json.loads(table.schema.metadata[b"channels"])
    assert [name[-6:] for name in channels] == 2 * [f" {r} {axis}" for r in ("acc", "gyr") for axis in "xyz"]
    columns = table.to_pydict()
    assert set(columns["clip"]) == {f"{name}_{number}" for name in ("slow", "fast") for number in range(4)}
    assert "acc is specific force" in (folder / "README.md").read_text().replace("`", "")
    whole, patch = (
        recording_of(results),
        recording_of(results).sites.index(channels[11].removesuffix(" gyr z")),
    )
    rows = [k for k, clip in enumerate(columns["clip"]) if clip == "slow_0"]
    for row in rows:
        start, found = columns["start"][row], np.float32(columns["signals"][row][11])
        np.testing.assert_array_equal(found, whole.gyr[start : start + len(found), patch, 2])
    assert sum(columns["is_test"][row] for row in rows) == 1 + (len(rows) - 1) // 2


@pytest.mark.slow
def test_parquet_in_parts_holds_the_same(results, tmp_path, monkeypatch):
    parquet = pytest.importorskip("pyarrow.parquet", exc_type=ImportError)
    whole = parquet.read_table(exported(results, tmp_path / "whole", "parquet") / "data")
    monkeypatch.setattr("w2w.core.exports.arrays.PART_BYTES", 1)
    monkeypatch.setattr("w2w.core.exports.arrays.GROUP_BYTES", 1)
    folder = exported(results, tmp_path / "parts", "parquet") / "data"
    assert len(list(folder.iterdir())) == 8
    assert parquet.read_table(folder).equals(whole)


@pytest.mark.slow
def test_an_export_is_replaced_and_nothing_else_is(results, tmp_path):
    code, output = cli("export", results, "--for", "bids")
    assert code == 0, output
    assert (results / "export" / "bids" / "participants.tsv").is_file()
    code, output = cli("export", results, "--for", "bids")  # its own may be replaced
    assert code == 0, output
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "notes.txt").write_text("mine")
    code, output = cli("export", results, "--for", "bids", "--out", tmp_path / "mine")
    assert (code, "holds notes.txt, which W2W did not write" in " ".join(output.split())) == (2, True)
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["notes.txt"]
    (results / "export" / "bids" / "sub-1").mkdir(exist_ok=True)
    added = results / "export" / "bids" / "sub-1" / "notes.txt"  # what somebody puts into an export stays
    added.write_text("mine")
    code, output = cli("export", results, "--for", "bids")
    assert (code, "holds sub-1/notes.txt, which W2W did not write" in " ".join(output.split())) == (2, True)
    assert added.read_text() == "mine"
    added.unlink()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--for", "excel"], 2, "--for must be one of aeon, torch, parquet, transpose"),
        (["--for", "aeon", "--places", "lft wirst"], 2, "did you mean left wrist"),
        (["--for", "aeon", "--places", "left wrist, left wrist dorsal"], 2, "are both the place"),
        (["--for", "aeon", "--sensor", "ideal"], 2, "give the sensor to `w2w run`"),
        (["--for", "transpose", "--places", "99999999"], 2, "which the skin of this body does not have"),
        (["--for", "opensim", "--sensor", "nosuch"], 2, "there is no sensor preset"),
    ],
)
def test_wrong_use_is_a_sentence(results, tmp_path, options, code, message):
    found, output = cli("export", results, "--out", tmp_path / "out", *options)
    assert (found, message in output) == (code, True), output
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_patch_that_is_not_near_its_place_is_said(results, tmp_path):
    code, output = cli("export", results, "--for", "parquet", "--places", "chest", "--out", tmp_path / "out")
    assert code == 0
    assert "The nearest patch to 'chest' is " in output


@pytest.mark.slow
def test_a_damaged_or_unfinished_run_is_said(results, tmp_path):
    code, output = cli("export", tmp_path, "--for", "aeon")
    assert (code, "is not the results folder of a finished run" in output) == (2, True)
    shutil.copytree(results, tmp_path / "out")
    (tmp_path / "out" / "signals" / "slow_1.npz").write_bytes(b"cut")
    code, output = cli("export", tmp_path / "out", "--for", "aeon", "--out", tmp_path / "x")
    assert (code, "Nothing written: " in output, "slow_1.npz" in output) == (1, True, True)
    assert not (tmp_path / "x").exists()
    assert not list(tmp_path.glob(".x*"))


def test_a_motion_at_another_rate_keeps_its_poses(shared_data):
    motion = read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    again = at_rate(at_rate(motion, 2 * motion.rate), motion.rate)
    np.testing.assert_allclose(again.rotations, motion.rotations, atol=1e-9)
    np.testing.assert_allclose(again.pelvis, motion.pelvis, atol=1e-9)
