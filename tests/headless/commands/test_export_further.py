# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w export` of a run that recorded orientation, magnetometer and barometer: what holds them has them."""

import json
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from w2w.core.exports.study_signals import WornSignals, placed
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.vendor_formats import read_xsens_txt
from w2w.core.motion.motion import Motion
from w2w.core.study.results import StudyResults
from w2w.headless.app import APP

from ...orientation_sto import read_orientation_sto

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("made_once_here")]


def w2w(*arguments):
    result = CliRunner().invoke(APP, [str(argument) for argument in arguments], env={"COLUMNS": "300"})
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    assert result.exit_code == 0, result.output


@pytest.fixture(scope="module")
def results(made_once):
    """A finished run of four made clips at eight places, all recorded."""
    return made_once("recorded", _run) / "out"


def _run(folder):
    library, time = folder / "motions", np.arange(120) / 30
    for activity, pace in (("slow", 0.5), ("fast", 2.0)):
        (library / activity).mkdir(parents=True)
        for number in range(2):
            axes = np.random.default_rng(number).normal(size=(24, 3)) / 5
            angles = np.sin(2 * np.pi * pace * (1 + number / 20) * time)
            turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
            pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
            Motion(turns.reshape(-1, 24, 3, 3), pelvis, 30.0).save(library / activity / f"{number}.npz")
    w2w(
        "run", library, "--out", folder / "out", "--patches", 8, "--folds", 2, "--no-pictures", "--no-report",
        "--workers", 1, "--record", "orientation,magnetometer,barometer",
    )  # fmt: skip


def exported(results, tmp_path, tool):
    w2w("export", results, "--for", tool, "--out", tmp_path / tool, "--places", "all")
    return tmp_path / tool


def of_clip(results, clip):
    return ImuRecording.load(results / "signals" / f"{clip}.npz")


def test_arrays_hold_all_channels(results, tmp_path):
    folder = exported(results, tmp_path, "aeon")
    facts = json.loads((folder / "facts.json").read_text())
    x, clip = np.load(folder / "X.npy"), np.load(folder / "clip.npy")
    whole = of_clip(results, "slow_0")
    assert [name.removeprefix(f"{whole.sites[0]} ") for name in facts["channels"][6:14]] == [
        "quat w", "quat x", "quat y", "quat z", "mag x", "mag y", "mag z", "pressure"
    ]  # fmt: skip
    assert facts["units"][6:14] == ["", "", "", "", "uT", "uT", "uT", "Pa"]
    first = x[clip == "slow_0"][0].reshape(8, 14, 100)
    np.testing.assert_array_equal(first.transpose(2, 0, 1), whole.values[:100])


def test_bids_knows_what_each_channel_is(results, tmp_path):
    folder = exported(results, tmp_path, "bids") / "sub-unknown" / "motion"
    stem = "sub-unknown_task-slow_tracksys-imu_run-1"
    rows = [line.split("\t") for line in (folder / f"{stem}_channels.tsv").read_text().splitlines()[1:]]
    assert all(row[3] == row[5].replace(" ", "_") for row in rows)
    assert [(row[1], row[2], row[4], row[6]) for row in rows[6:14]] == [
        *((f"quat_{axis}", "ORNT", "n/a", "world") for axis in "wxyz"),
        *((axis, "MAGN", "uT", "sensor") for axis in "xyz"),
        ("n/a", "MISC", "Pa", "n/a"),
    ]
    frames = json.loads((folder / f"{stem}_channels.json").read_text())["reference_frame"]["Levels"]
    assert {row[6] for row in rows} == set(frames)
    facts = json.loads((folder / f"{stem}_motion.json").read_text())
    counts = {name: facts[f"{name}ChannelCount"] for name in ("ACCEL", "GYRO", "ORNT", "MAGN", "MISC")}
    assert counts == {"ACCEL": 24, "GYRO": 24, "ORNT": 32, "MAGN": 24, "MISC": 8}
    assert facts["MotionChannelCount"] == len(rows) == 8 * 14
    values = np.loadtxt(folder / f"{stem}_motion.tsv", delimiter="\t", dtype=np.float32)
    np.testing.assert_array_equal(values.reshape(len(values), 8, 14), of_clip(results, "slow_0").values)


def test_parquet_has_a_column_for_each(results, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", exc_type=ImportError)
    table = parquet.read_table(exported(results, tmp_path, "parquet") / "data")
    channels, units = (json.loads(table.schema.metadata[name]) for name in (b"channels", b"units"))
    columns = table.to_pydict()
    whole = of_clip(results, "fast_1")
    row = columns["clip"].index("fast_1")
    for name, unit, values in (
        ("quat w", "", whole.orientation[:, 0, 0]),
        ("pressure", "Pa", whole.barometer[:, 0, 0]),
    ):
        number = channels.index(f"{whole.sites[0]} {name}")
        found = np.float32(columns["signals"][row][number])
        assert units[number] == unit
        np.testing.assert_array_equal(found, values[: len(found)])


def test_opensim_and_xsens_get_the_orientation_that_was_recorded(results, tmp_path):
    quaternions, _, sites = read_orientation_sto(exported(results, tmp_path, "opensim") / "slow_1.sto")
    whole = of_clip(results, "slow_1")
    assert sites == tuple(site.replace(" ", "_") for site in whole.sites)
    alike = np.abs((quaternions * whole.orientation).sum(axis=2))
    np.testing.assert_allclose(alike, 1, atol=1e-6)
    read = read_xsens_txt(exported(results, tmp_path, "xsens") / "slow_1" / f"{sites[3]}.txt")
    turned = read.orientation[:, 0]
    np.testing.assert_allclose(np.abs((turned * quaternions[:, 3]).sum(axis=1)), 1, atol=1e-6)


def test_a_calibration_takes_the_mounting_out_and_leaves_the_error_of_the_orientation(results):
    study = StudyResults.load(results)
    patches = placed(study, ["left wrist", "sternum"])
    mounted = SensorModel(name="mounted", mounting_turn_deg=15.0)
    clip, *_ = WornSignals(study, patches, 60.0, mounted).clips()
    plain = replace(study.config(), further=replace(study.config().further, record=()))
    true, *_ = WornSignals(_Changed(study, plain), patches, 60.0, mounted).clips()
    raw = _apart(clip.orientations, true.orientations)
    calibrated = _apart(
        clip.orientations @ clip.rest.swapaxes(1, 2), true.orientations @ true.rest.swapaxes(1, 2)
    )
    assert raw.max() > 5  # how it sits
    assert 0 < calibrated.max() < 5  # what the part gets wrong


class _Changed:
    """A study with another config."""

    def __init__(self, study, config):
        self._study, self._config = study, config

    def config(self):
        return self._config

    def __getattr__(self, name):
        return getattr(self._study, name)


def _apart(a, b):
    turns = (a @ b.swapaxes(-1, -2)).reshape(-1, 3, 3)
    return np.degrees(Rotation.from_matrix(turns).magnitude())


def test_a_place_far_from_every_patch_is_refused(results, tmp_path):
    options = ("--for", "parquet", "--places", "left ear", "--out", tmp_path / "out")
    with pytest.raises(AssertionError, match="too far to stand for it"):
        w2w("export", results, *options)
    assert not (tmp_path / "out").exists()
