# SPDX-License-Identifier: GPL-3.0-or-later
"""Real sensors on real people: DSADS ranks as published, from its npz and from its own text files."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.headless.app import APP
from w2w.studies.datasets.dsads import DSADS_SITES, read_dsads


@pytest.mark.slow
def test_real_sensors_rank_as_published(shared_data, tmp_path):
    """19 activities, leave-one-subject-out: legs over torso over arms."""
    data = shared_data / "imu" / "dsads" / "dsads_acc_gyr_25hz.npz"
    result = CliRunner().invoke(APP, ["dsads", str(data), "--out", str(tmp_path / "table.csv")])
    assert result.exit_code == 0, result.output
    with (tmp_path / "table.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    mean = {row["placement"]: float(row["f1"]) for row in rows if row["activity"] == "mean"}
    assert set(mean) == set(DSADS_SITES)
    assert min(mean["right leg"], mean["left leg"]) > 0.85
    assert 0.79 < mean["torso"] < 0.84
    assert 0.73 < mean["right arm"] < mean["left arm"] < 0.83
    assert "leave one of 8 subjects out" in result.output
    assert len(rows) == 5 * 20
    best = {row["placement"] for row in rows if row["activity"] == "mean" and row["same_as_best"] == "yes"}
    assert best == {"right leg", "left leg"}
    by_activity = {(row["activity"], row["placement"]): float(row["f1"]) for row in rows}
    assert by_activity["playing basketball", "left arm"] > by_activity["playing basketball", "right leg"]
    assert by_activity["cycling horizontal", "left leg"] > by_activity["cycling horizontal", "left arm"]


def test_its_own_text_files_give_the_same_recordings(tmp_path):
    rng = np.random.default_rng(0)
    values = rng.normal(size=(2, 125, 45)).round(4)
    for number, (activity, person) in enumerate([(3, 2), (12, 8)]):
        folder = tmp_path / f"a{activity:02d}" / f"p{person}"
        folder.mkdir(parents=True)
        np.savetxt(folder / "s07.txt", values[number], delimiter=",", fmt="%.4f")
    first, second = read_dsads(tmp_path)
    assert (first.activity, first.subject, first.clip) == ("lying on back", "p2", "a03_p2_s07")
    assert (second.activity, second.subject) == ("running on treadmill", "p8")
    np.testing.assert_allclose(first.acc[:, 1], values[0][:, 9:12], rtol=1e-6)
    np.testing.assert_allclose(second.gyr[:, 4], values[1][:, 39:42], rtol=1e-6)


def test_what_is_not_dsads_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"holds no segments a01/p1/s01\.txt"):
        read_dsads(tmp_path)
    folder = tmp_path / "a01" / "p1"
    folder.mkdir(parents=True)
    (folder / "s01.txt").write_text("1,2,3\n")
    with pytest.raises(ValueError, match=r"s01\.txt must have 125 lines of 45 numbers, not \(1, 3\)"):
        read_dsads(tmp_path)
    (folder / "s01.txt").write_text("1,2,walk\n")
    result = CliRunner().invoke(APP, ["dsads", str(tmp_path)])
    assert result.exit_code == 2
    assert "damaged line" in " ".join(result.output.split())
