# SPDX-License-Identifier: GPL-3.0-or-later
"""UP-Fall, on files made in its layout: SI units, an even clock, no falls; damage is refused by its line."""

import csv
from datetime import datetime, timedelta

import numpy as np
import pytest

from w2w_studies.datasets.upfall import UPFALL_ACTIVITIES, UPFALL_RATE, UPFALL_SITES, read_upfall

PARTS = ("Ankle", "RightPocket", "Belt", "Neck", "Wrist")
KINDS = (("Accelerometer", "g", 3), ("AngularVelocity", "deg/s", 3), ("Luminosity", "lx", 1))
START = datetime(2018, 7, 4, 12, 4, 17, 738369)  # the file's own times have no zone


def headings():
    names, units = ["TimeStamps"], ["Time"]
    for part in PARTS:
        for kind, unit, size in KINDS:
            names += [part + kind, *[""] * (size - 1)]
            units += [f"{axis}-axis ({unit})" for axis in "xyz"] if size == 3 else [f"illuminance ({unit})"]
    names += [
        "BrainSensor",
        *(f"Infrared{number}" for number in range(1, 7)),
        "Subject",
        "Activity",
        "Trial",
        "Tag",
    ]
    return names, [*units, "RAW", *["RAW"] * 6, "", "", "", ""]


def rows(subject=1, activity=6, trial=1, seconds=5.0, start=0.0):
    """Each sensor reads its number in g and ten times that in degrees a second along x."""
    found = []
    for step in range(round(seconds * 18.3)):
        cells = [(START + timedelta(seconds=start + step / 18.3)).isoformat()]
        for number in range(1, 6):
            cells += [number, 0, 1, 10 * number, 0, 0, 5.5]
        found.append([*cells, -1, *[1] * 6, subject, activity, trial, activity])
    return found


def written(path, *parts, head=None):
    with path.open("w", newline="") as stream:
        csv.writer(stream).writerows([*(head or headings()), *(row for part in parts for row in part)])
    return path


def test_trials_come_in_si_units_on_an_even_clock(tmp_path):
    path = written(tmp_path / "CompleteDataSet.csv", rows(), rows(activity=9, trial=2, start=60), rows(17, 1))
    (walk, pick), left_out = read_upfall(path)
    assert left_out == ()
    assert (walk.activity, walk.subject, walk.clip) == ("walking", "s01", "s01_a06_t1")
    assert pick.activity == "picking up an object"
    assert (walk.rate, walk.sites) == (UPFALL_RATE, UPFALL_SITES)
    assert walk.n_samples == pytest.approx(5 * UPFALL_RATE, abs=2)
    np.testing.assert_allclose(
        walk.acc[:, :, 0], np.tile(9.80665 * np.arange(1, 6), (walk.n_samples, 1)), rtol=1e-6
    )
    np.testing.assert_allclose(walk.gyr[0, :, 0], np.radians(10 * np.arange(1, 6)), rtol=1e-6)
    assert len(read_upfall(tmp_path)[0]) == 2  # the folder will do


def test_a_folder_of_single_trials_is_read_as_the_one_file(tmp_path):
    parts = [rows(), rows(2, 9, 3)]
    for number, part in enumerate(parts, start=1):
        folder = tmp_path / "dataset" / f"Subject{number}"
        folder.mkdir(parents=True)
        written(folder / f"Subject{number}Activity6Trial1.csv", part)
    whole = read_upfall(written(tmp_path / "one.csv", *parts))[0]
    apart = read_upfall(tmp_path / "dataset")[0]
    assert [one.clip for one in apart] == [one.clip for one in whole] == ["s01_a06_t1", "s02_a09_t3"]
    for one, other in zip(apart, whole, strict=True):
        np.testing.assert_array_equal(one.acc, other.acc)


def test_a_silence_is_nan_and_a_repeated_time_no_fault(tmp_path):
    trial = rows(seconds=6)
    del trial[40:60]
    trial[10][0] = trial[9][0]
    trial[80][1] = ""
    (found,), _ = read_upfall(written(tmp_path / "a.csv", trial))
    lost = np.isnan(found.acc).any(axis=(1, 2))
    assert 15 <= lost.sum() <= 22
    assert not lost[:30].any()


def test_who_lacks_a_sensor_stays_at_the_other_sites(tmp_path):
    trial = rows()
    for cells in trial:
        cells[8:14] = [""] * 6
    (found,), left_out = read_upfall(written(tmp_path / "a.csv", trial))
    assert left_out == ()
    assert np.isnan(found.acc[:, 1]).all()
    assert np.isfinite(found.acc[:, [0, 2, 3, 4]]).all()


def test_a_trial_of_no_use_costs_only_itself(tmp_path):
    found, left_out = read_upfall(written(tmp_path / "a.csv", rows(), rows(2, 7, seconds=1)))
    assert len(found) == 1
    assert left_out == ("subject 2, activity 7, trial 1: its sensors share less than 2 s",)


def test_what_is_not_the_file_is_refused_with_a_reason(tmp_path):
    def fails(message, *parts, head=None):
        with pytest.raises(ValueError, match=message):
            read_upfall(written(tmp_path / "a.csv", *parts, head=head))

    names, units = headings()
    fails("its first line lacks TimeStamps, Subject, Activity, Trial", head=(["a"], ["b"]))
    without = [name.replace("NeckAccelerometer", "Neck") for name in names]
    fails("its first line lacks NeckAccelerometer", head=(without, units))
    fails(r"below AnkleAccelerometer its second line must have x-axis \(g\)", head=(names, [""] * len(units)))
    fails("no trial of a daily activity can be read", rows(activity=2))
    wrong = rows()
    wrong[3][2] = "none"
    fails("is damaged: line 6: could not convert string to float: 'none'", wrong)
    fails("is damaged: line 3: ", [row[:20] for row in rows()])
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00rubbish")
    with pytest.raises(ValueError, match="no text of comma-separated cells"):
        read_upfall(tmp_path / "b.csv")
    with pytest.raises(OSError, match="CompleteDataSet"):
        read_upfall(tmp_path)


def test_falls_are_no_daily_activities():
    assert min(UPFALL_ACTIVITIES) == 6
