# SPDX-License-Identifier: GPL-3.0-or-later
"""The MIG HAR garment, on files made in its format, and the csv that says where its sensors are."""

import gzip

import numpy as np
import pytest

from w2w_studies.datasets.mighar import MIGHAR_RATE, MIGHAR_SENSORS, read_mighar, read_positions

WIDTH = 9 * MIGHAR_SENSORS
KINDS = [f"{kind}{axis}" for kind in "agm" for axis in "xyz"]
HEADER = ",".join(f"{kind}_{sensor}" for sensor in range(MIGHAR_SENSORS) for kind in KINDS)


def trial(folder, subject=1, activity="sitting", number=1, seconds=4.0, cells=None, header=HEADER):
    """All sensors read 0 but those of `cells`, text by row and column; no row stands for every one."""
    path = folder / f"subject{subject}" / activity / f"data{number}.csv.gz"
    path.parent.mkdir(parents=True, exist_ok=True)
    lines = [header]
    for row in range(round(seconds * 100)):
        line = ["0"] * WIDTH
        for (where, column), text in (cells or {}).items():
            if where is None or where == row:
                line[column] = text
        lines.append(",".join(line))
    with gzip.open(path, "wt", compresslevel=1) as stream:
        stream.write("\n".join(lines) + "\n")
    return path


def test_chosen_sensors_come_in_si_units_at_half_the_rate(tmp_path):
    cells = {(None, 9 * 7 + 2): "1.0", (None, 9 * 395 + 3): "90", (None, 9 * 395 + 6): "55"}
    trial(tmp_path / "data", 3, cells=cells)
    (found,), left_out = read_mighar(tmp_path, (395, 7))
    assert left_out == ()
    assert (found.activity, found.subject, found.clip) == ("sitting", "subject3", "subject3 sitting 1")
    assert (found.rate, found.sites, found.n_samples) == (MIGHAR_RATE, ("sensor 395", "sensor 7"), 200)
    np.testing.assert_allclose(found.acc[:, 1], np.tile([0, 0, 9.80665], (200, 1)), atol=1e-4)
    np.testing.assert_allclose(found.gyr[:, 0], np.tile([np.pi / 2, 0, 0], (200, 1)), atol=1e-4)
    assert np.abs(found.acc[:, 0]).max() < 1e-6


def test_the_start_of_what_begins_from_standing_is_cut(tmp_path):
    cells = {(row, 0): "1" for row in range(150)}
    for activity in ("walking", "folding"):
        trial(tmp_path, activity=activity, seconds=6, cells=cells)
    (folding, walking), _ = read_mighar(tmp_path, (0,))
    assert folding.n_samples - walking.n_samples == 100
    assert np.abs(walking.acc).max() < 0.5
    assert folding.acc[:50, 0, 0].mean() == pytest.approx(9.8, abs=0.1)


def test_short_gaps_are_bridged_and_long_ones_are_nan(tmp_path):
    cells = {(None, 1): "1"}
    cells |= {(row, 1): "" for row in range(50, 61)}
    cells |= {(row, 1): "NaN" for row in range(200, 260)}
    trial(tmp_path, cells=cells)
    (found,), _ = read_mighar(tmp_path, (0, 1))
    lost = np.isnan(found.acc[:, 0]).any(axis=1)
    assert np.flatnonzero(lost).tolist() == list(range(100, 130))
    np.testing.assert_allclose(found.acc[20:35, 0, 1], 9.80665, rtol=1e-3)
    assert np.isfinite(found.acc[:, 1]).all()


def test_a_damaged_file_costs_only_itself(tmp_path):
    trial(tmp_path)
    trial(tmp_path, 2, header=HEADER.rpartition(",")[0])
    trial(tmp_path, 3, cells={(7, 0): "wrong"})
    trial(tmp_path, 4, activity="dancing")
    trial(tmp_path, 5, cells={(None, 0): "nan"})
    whole = trial(tmp_path, 6).read_bytes()
    (tmp_path / "subject6" / "sitting" / "data1.csv.gz").write_bytes(whole[: len(whole) // 2])
    trial(tmp_path, 7, seconds=0.5)
    found, left_out = read_mighar(tmp_path, (0,))
    assert [recording.subject for recording in found] == ["subject1"]
    reasons = dict(line.split(": ", 1) for line in left_out)
    assert reasons["subject2/sitting/data1.csv.gz"] == f"it has {WIDTH - 1} columns, not {WIDTH}"
    assert "wrong" in reasons["subject3/sitting/data1.csv.gz"]
    assert reasons["subject4/dancing/data1.csv.gz"] == "the data set has no activity 'dancing'"
    assert reasons["subject5/sitting/data1.csv.gz"] == "a sensor has no reading"
    assert "end-of-stream" in reasons["subject6/sitting/data1.csv.gz"]
    assert reasons["subject7/sitting/data1.csv.gz"].startswith("it has 50 rows")
    with pytest.raises(ValueError, match=r"holds no subject1/walking/data1.csv.gz"):
        read_mighar(tmp_path / "subject1", (0,))


def test_sensors_of_one_region_are_one_site(tmp_path):
    path = tmp_path / "sensors.csv"
    path.write_text("sensor,region,vertex\n0,,\n5,Left Wrist,\n9,,4021\n2,left wrist,\n395,chest,\n")
    worn = read_positions(path)
    assert worn.sensors == (5, 9, 2, 395)
    assert worn.sites == {"left wrist": "left wrist", "vertex 4021": 4021, "chest": "chest"}
    assert worn.site_of.tolist() == [0, 1, 0, 2]


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ("1,chest,5", "line 2: give the sensor a region or a vertex, not both"),
        ("396,chest,", "line 2: the sensor must be a whole number from 0 to 395, not '396'"),
        ("1,,-4", "line 2: the vertex must be a whole number"),
        ("1,chest,\n1,head,", "line 3: sensor 1 is listed twice"),
        ("1,chest,\n2,head,\n3,head,\n4,,", "places sensors at 2 sites, and a ranking needs three"),
    ],
)
def test_positions_that_cannot_be_meant_are_refused(tmp_path, rows, message):
    (tmp_path / "sensors.csv").write_text(f"sensor,region,vertex\n{rows}\n")
    with pytest.raises(ValueError, match=message):
        read_positions(tmp_path / "sensors.csv")
