# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w synth` and `w2w sensors` give a designer one sensor's signal, and say which sensors there are."""

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import N_JOINTS
from w2w.core.imu.formats import read_csv, read_recording
from w2w.core.imu.presets import PRESETS
from w2w.core.motion.motion import Motion

from ...command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

JACKS = "mixamo/Sushim30__ARFitness/Jumping Jacks.fbx"


@pytest.fixture(scope="module")
def jacks(shared_data, tmp_path_factory):
    """The motion of `JACKS` in a file that is read at once."""
    path = tmp_path_factory.mktemp("jacks") / "jacks.npz"
    w2w.load(shared_data / JACKS)[0].save(path)
    return path


def test_a_signal_and_its_picture(shared_data, tmp_path):
    out, plot = tmp_path / "x.csv", tmp_path / "x.png"
    code, output = cli(
        "synth", shared_data / JACKS, "--patch", "left wrist", "--sensor", "ideal", "--rate", 100,
        "--out", out, "--plot", plot,
    )  # fmt: skip
    assert code == 0, output
    recording = read_csv(out)
    assert (recording.rate, recording.n_sensors) == (100, 1)
    assert recording.n_samples == pytest.approx(107, abs=1)
    assert "left wrist" in recording.sites[0]
    turning = np.abs(np.linalg.norm(recording.gyr[:, 0], axis=1))
    assert 5 < turning.max() < 40  # an arm that swings half a turn in half a second
    with Image.open(plot) as picture:
        assert picture.size[0] > 1000


def test_units_and_other_tools_formats_on_request(jacks, tmp_path):
    options = ["--patch", "sternum", "--sensor", "ideal", "--rate", 50]
    files = {"a.csv": [], "b.csv": ["--acc-unit", "g", "--gyr-unit", "deg/s"]}
    formats = {"MT_wrist.txt": "xsens", "log": "x-io", "a.npz": "npz"}
    for name, more in (files | {name: ["--format", kind] for name, kind in formats.items()}).items():
        code, output = cli("synth", jacks, *options, "--out", tmp_path / name, *more)
        assert code == 0, output
    expected = read_csv(tmp_path / "a.csv")
    for name in formats:
        found = read_recording(tmp_path / name)
        np.testing.assert_allclose(found.acc, expected.acc, rtol=1e-5, atol=1e-5)
        np.testing.assert_allclose(found.gyr, expected.gyr, rtol=1e-5, atol=1e-5)
    a, b = (np.loadtxt(tmp_path / name, delimiter=",", skiprows=8) for name in files)
    np.testing.assert_allclose(b[:, 1:4] * 9.80665, a[:, 1:4], rtol=1e-6)
    np.testing.assert_allclose(np.radians(b[:, 4:]), a[:, 4:], rtol=1e-6)
    assert 'acc_unit: "g"' in (tmp_path / "b.csv").read_text()


@pytest.mark.parametrize(("kind", "name"), [("csv", "x.csv"), ("npz", "x.npz")])
def test_what_else_a_part_has_is_recorded_on_request(jacks, tmp_path, kind, name):
    options = ("synth", jacks, "--patch", "left wrist", "--format", kind, "--out")
    code, output = cli(*options, tmp_path / f"plain_{name}")
    assert code == 0, output
    pictures = ("--plot", tmp_path / "x.png") if kind == "csv" else ()
    code, output = cli(
        *options, tmp_path / name, "--record", "barometer,orientation,magnetometer",
        "--magnetic-dip", "-64.3", *pictures,
    )  # fmt: skip
    assert code == 0, output
    plain, full = (read_recording(tmp_path / file) for file in (f"plain_{name}", name))
    assert plain.further == {}
    np.testing.assert_array_equal(full.acc, plain.acc)
    assert set(full.further) == {"orientation", "magnetometer", "barometer"}
    assert np.linalg.norm(full.magnetometer.mean(axis=0)) < 70  # as on earth, in microtesla
    np.testing.assert_allclose(np.linalg.norm(full.orientation, axis=2), 1, atol=1e-5)
    assert np.ptp(full.barometer) > 5  # the hand goes up a metre and more: 12 Pa each
    if pictures:
        with Image.open(tmp_path / "x.png") as picture:
            assert picture.size[1] > 1500


def test_no_band_limit_is_cautioned_of(tmp_path):
    time = np.arange(90) / 30
    turns = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
    turns[:, 16] = Rotation.from_euler("x", np.sin(6 * time)[:, None]).as_matrix()
    Motion(turns, np.zeros((len(time), 3)), 30.0).save(tmp_path / "wave.npz")
    for band, cautioned in ((0, True), (10, False)):
        code, output = cli(
            "synth", tmp_path / "wave.npz", "--patch", "left wrist", "--band", band,
            "--out", tmp_path / f"{band}.csv",
        )  # fmt: skip
        assert code == 0, output
        assert ("motion above half the sensor rate is folded back" in output) == cautioned


def test_rate_and_up_of_a_file_that_says_neither_are_given(tmp_path):
    time = np.arange(90) / 30
    turns = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
    turns[:, 16] = Rotation.from_euler("x", np.sin(6 * time)[:, None]).as_matrix()
    turns[:, 0] = np.diag([1.0, -1.0, -1.0])
    Motion(turns, np.zeros((len(time), 3)), 30.0).save(tmp_path / "wave.npz")
    with np.load(tmp_path / "wave.npz") as stored:
        kept = {name: stored[name] for name in ("poses", "trans")}
    np.savez(tmp_path / "down.npz", **kept)
    out = tmp_path / "out.csv"
    options = ("synth", tmp_path / "down.npz", "--patch", "left wrist", "--sensor", "ideal", "--out", out)
    code, output = cli(*options)
    assert (code, "give --pose-rate" in output) == (1, True), output
    code, output = cli(*options, "--pose-rate", 30)
    assert (code, "give --pose-up" in output) == (1, True), output
    code, output = cli(*options, "--pose-rate", 30, "--pose-up", "-z")
    assert code == 0, output
    assert read_csv(out).n_samples == pytest.approx(149, abs=1)
    assert cli(*options, "--pose-up", "w")[0] == 2


@pytest.mark.slow
def test_bands_on_request(shared_data, tmp_path):
    shaken = {}
    for name, options in {"as is": [], "narrow": ["--band", 3], "root": ["--root-band", 1]}.items():
        out = tmp_path / f"{name}.csv"
        code, output = cli(
            "synth", shared_data / JACKS, "--patch", "sternum", "--sensor", "ideal", "--out", out, *options
        )
        assert code == 0, output
        recording = read_csv(out)
        shaken[name] = [np.std(values, axis=0).sum() for values in (recording.acc[:, 0], recording.gyr[:, 0])]
    assert shaken["narrow"][0] < 0.9 * shaken["as is"][0]
    assert shaken["narrow"][1] < 0.9 * shaken["as is"][1]
    assert shaken["root"][0] < 0.7 * shaken["as is"][0]
    assert shaken["root"][1] == shaken["as is"][1]  # turns know nothing of the path


@pytest.mark.parametrize(
    ("options", "code", "message"),
    [
        (["--patch", "lft wirst"], 2, "did you mean left wrist"),
        (["--patch", "wrist", "--sensor", "nosuch"], 2, "there is no sensor preset"),
        (["--patch", "wrist", "--record", "gps"], 2, "orientation, magnetometer, barometer, not 'gps'"),
        (
            ["--patch", "wrist", "--record", "orientation,barometer", "--format", "xsens"],
            2,
            "a file of --format xsens does not hold barometer; npz and csv do",
        ),
    ],
)
def test_wrong_use_is_explained(shared_data, tmp_path, options, code, message):
    found, output = cli("synth", shared_data / JACKS, "--out", tmp_path / "x.csv", *options)
    assert found == code
    assert message in output
    assert not (tmp_path / "x.csv").exists()


def test_a_clip_that_cannot_be_used_is_explained(shared_data, tmp_path):
    code, output = cli(
        "synth",
        shared_data / "mixamo/_broken/zero_bytes.fbx",
        "--patch",
        "wrist",
        "--out",
        tmp_path / "x.csv",
    )
    assert code == 1
    assert "the file is empty" in output


def test_every_preset_is_listed():
    code, output = cli("sensors")
    assert code == 0
    assert all(name in output for name in PRESETS)


def test_an_unknown_format_is_said(shared_data, tmp_path):
    code, output = cli(
        "synth", shared_data / JACKS, "--patch", "sternum", "--out", tmp_path / "a", "--format", "mvnx"
    )
    assert (code, "--format must be one of npz, csv, xsens, x-io, not mvnx" in output) == (2, True)
