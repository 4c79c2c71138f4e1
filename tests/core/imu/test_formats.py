# SPDX-License-Identifier: GPL-3.0-or-later
"""Every file of a recording names what it holds by one list, and gives it back."""

import json

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.formats import HELD, read_recording, write_csv, write_recording
from w2w.core.imu.recording import FURTHER, READINGS, ImuRecording

SUFFIXES = {"npz": ".npz", "csv": ".csv", "xsens": ".txt", "x-io": ""}


@pytest.fixture
def full():
    """Three sensors that record everything, drawn at random."""
    rng = np.random.default_rng(4)
    turns = Rotation.random(150, rng).as_quat().reshape(50, 3, 4)
    force, turning, field = rng.normal(size=(3, 50, 3, 3)) * [[[[10]]], [[[2]]], [[[40]]]]
    return ImuRecording(
        force, turning, 50.0, ("a", "b", "c"), "wave", "me", "clip",
        turns, field, 1e5 + rng.normal(size=(50, 3, 1)),
    )  # fmt: skip


def test_channels_are_distinct_and_as_many_as_the_arrays_hold(full):
    names = [channel for reading in READINGS for channel in reading.channels]
    assert len(set(names)) == len(names) == full.values.shape[2]
    assert full.readings == READINGS
    assert {name: array.shape[2] for name, array in full.further.items()} == FURTHER


def test_some_sensors_keep_all_that_they_read(full):
    chosen = full.at([2, 0])
    assert chosen.sites == ("c", "a")
    assert (chosen.activity, chosen.subject, chosen.clip) == ("wave", "me", "clip")
    np.testing.assert_array_equal(chosen.values, full.values[:, [2, 0]])
    assert ImuRecording(full.acc, full.gyr, 50.0).at([1]).readings == READINGS[:2]


@pytest.mark.parametrize("kind", ["npz", "csv", "xsens", "x-io"])
def test_each_format_gives_back_what_it_holds(full, tmp_path, kind):
    path = tmp_path / f"one{SUFFIXES[kind]}"
    write_recording(path, full.at([1]), kind)
    found = read_recording(path)
    assert tuple(found.further) == HELD[kind]
    for name, values in found.further.items():
        np.testing.assert_array_equal(values, full.further[name][:, [1]])
    np.testing.assert_allclose(found.acc, full.acc[:, [1]], rtol=1e-6)


def test_a_csv_names_its_columns_and_units(full, tmp_path):
    write_csv(tmp_path / "one.csv", full, 1)
    lines = (tmp_path / "one.csv").read_text().splitlines()
    facts = dict(line[2:].split(": ", 1) for line in lines if line.startswith("#"))
    assert json.loads(facts["magnetometer_unit"]) == "uT"
    assert json.loads(facts["barometer_unit"]) == "Pa"
    header = next(line for line in lines if not line.startswith("#"))
    assert header.split(",")[7:] == [
        "quat_w", "quat_x", "quat_y", "quat_z", "mag_x", "mag_y", "mag_z", "pressure"
    ]  # fmt: skip
    (tmp_path / "other.csv").write_text("\n".join(line for line in lines if "uT" not in line))
    assert tuple(read_recording(tmp_path / "other.csv").further) == ("orientation", "barometer")


def test_x_io_reads_its_quaternions(full, tmp_path):
    ximu3csv = pytest.importorskip("ximu3csv")
    write_recording(tmp_path / "log" / "device", full, "x-io", sensor=2)
    (device,) = ximu3csv.read(tmp_path / "log")
    np.testing.assert_allclose(device.quaternion.quaternion.wxyz, full.orientation[:, 2], rtol=1e-6)
    np.testing.assert_array_equal(device.quaternion.timestamp, np.arange(50) * 20_000)
