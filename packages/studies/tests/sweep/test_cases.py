# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w sweep` ranks the same motions again, one thing changed at a time."""

import csv

import numpy as np
import pytest

from tests.command_line import cli
from w2w.core.ranking.utility import UtilityMap
from w2w.core.study.results import StudyResults
from w2w_studies.sweep.cases import FACTORS, cases

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("one_worker")]

PLACES = 10


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Two clips an activity of W2W's own library."""
    folder = tmp_path_factory.mktemp("sweep")
    assert cli("demo-library", folder / "library", "--clips", 2)[0] == 0
    code, output = cli(
        *("run", folder / "library", "--out", folder / "out", "--patches", PLACES, "--no-pictures"),
        *("--workers", 1, "--folds", 2, "--max", 2),
    )
    assert code == 0, output
    return StudyResults.load(folder / "out")


def test_a_sweep_ranks_the_same_motions_again(study):
    options = ("--by", "sensor,asymmetry", "--patches", PLACES, "--workers", 1)
    code, output = cli("sweep", study.out, *options)
    assert code == 0, output
    assert "These very clips resampled agree by a rho of" in output
    folder = study.out / "sweep"
    with (folder / "sweep.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["case"] for row in rows] == [
        *("as run", "ideal", "mpu-6050", "phone", "left limbs half as far", "right limbs half as far"),
    ]
    assert float(rows[0]["rho"]) == 1.0
    for row in rows:
        assert -1 <= float(row["rho_low"]) <= float(row["rho_high"]) <= 1
        assert float(row["gain_low"]) <= float(row["gain"]) <= float(row["gain_high"])
    with (folder / "places.csv").open(newline="") as stream:
        places = list(csv.DictReader(stream))
    assert len(places) == len(rows) * PLACES
    again = [float(row["mean"]) for row in places[:PLACES]]
    np.testing.assert_allclose(again, study.utility.mean, atol=0.05)  # the motions passed through a file
    assert (folder / "sweep.png").stat().st_size > 20_000

    maps = {path: path.stat().st_mtime_ns for path in (folder / ".w2w").glob("map_*.npz")}
    assert len(maps) == len(rows)
    assert all(isinstance(UtilityMap.load(path), UtilityMap) for path in maps)
    assert cli("sweep", study.out, *options)[0] == 0
    assert maps == {path: path.stat().st_mtime_ns for path in (folder / ".w2w").glob("map_*.npz")}


def test_each_factor_changes_one_thing(study):
    config = study.config()
    usual, *others = cases(config, list(FACTORS))
    assert usual.config == config
    for case in others:
        changed = {
            "tempo": case.tempo != 1,
            "asymmetry": bool(case.narrow),
            "body": bool(case.shape),
            "sensor": case.config.sensor != config.sensor and case.config.own_sensor is None,
            "rate": case.config.synthesis != config.synthesis,
            "range": _altered(case, config, "full_scale"),
            "resolution": _altered(case, config, "resolution"),
            "noise": _altered(case, config, "noise_density"),
            "mounting": _altered(case, config, "mounting_turn_deg"),
            "soft tissue": _altered(case, config, "soft_tissue_hz"),
            "window": case.config.windows != config.windows,
        }
        kinds = [name for name, yes in changed.items() if yes]
        assert kinds[0] == case.factor.split()[-1] or case.factor in ("alone", "soft tissue"), case.title
        assert kinds[1:] in ([], ["resolution"]) or case.factor == "alone"  # a range's words stay as long
    with pytest.raises(ValueError, match="'mood' cannot be swept; there are tempo"):
        cases(config, ["mood"])


def _altered(case, config, field):
    """Whether a field of the sensor or its accelerometer is another one."""
    models = (case.config.sensor_model(), config.sensor_model())
    if case.config.own_sensor is None:
        return False
    parts = [(model, model.accelerometer, model.gyroscope) for model in models]
    ours, theirs = ([getattr(part, field, None) for part in each] for each in parts)
    return ours != theirs


def test_how_the_sensor_is_worn_reaches_the_signals(study):
    options = ("--by", "rate, mounting,soft-tissue", "--patches", PLACES, "--workers", 1)
    code, output = cli("sweep", study.out, *options, "--out", study.out.parent / "worn")
    assert code == 0, output
    with (study.out.parent / "worn" / "sweep.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["factor"], row["case"]) for row in rows[1:]] == [
        *(("rate", name) for name in ("200 Hz", "100 Hz", "25 Hz", "20 Hz", "10 Hz", "5 Hz")),
        *(("mounting", name) for name in ("5 deg, 5 mm", "10 deg, 10 mm", "20 deg, 20 mm")),
        *(("soft tissue", name) for name in ("5 Hz", "10 Hz", "20 Hz")),
    ]
    assert len({row["mean_f1"] for row in rows}) > 5  # each changes the signals
    by_name = {case.title: case.config for case in cases(study.config(), list(FACTORS))}
    assert by_name["range: 2 g, 250 deg/s"].sensor_model().accelerometer.full_scale == pytest.approx(19.6133)
    assert by_name["range: 2 g, 250 deg/s"].sensor_model().gyroscope.full_scale == pytest.approx(
        4.36332, rel=1e-5
    )


def test_tempo_and_asymmetry_reach_the_motion(study, waving):
    by_name = {case.name: case for case in cases(study.config(), ["tempo", "asymmetry"])}
    assert by_name["1.5 x"].motion(waving).rate == waving.rate * 1.5
    limp = by_name["left limbs half as far"].motion(waving)
    assert not np.allclose(limp.rotations[:, 18], waving.rotations[:, 18])
    np.testing.assert_array_equal(limp.rotations[:, 19], waving.rotations[:, 19])
