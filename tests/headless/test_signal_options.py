# SPDX-License-Identifier: GPL-3.0-or-later
"""The sensor, the bands and the convention in the user's hands: what is given is used and kept."""

import json

import numpy as np
import pytest

from w2w.core.files import write_npz
from w2w.core.imu.presets import preset
from w2w.core.imu.recording import FURTHER, ImuRecording
from w2w.core.imu.virtual import NOTHING, FurtherSensors
from w2w.core.study.clip_files import features_file
from w2w.core.study.config import StudyConfig
from w2w.headless.options import further_sensors

from ..command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    """Two activities of three clips each: an arm swings slowly or fast while the root shakes."""
    folder = tmp_path_factory.mktemp("library")
    rng = np.random.default_rng(3)
    time = np.arange(150) / 50
    for activity, speed in (("slow", 1.0), ("fast", 2.0)):
        (folder / activity).mkdir()
        for clip in range(3):
            poses = np.zeros((150, 72))
            swing = (0.8 + 0.1 * clip) * np.sin(2 * np.pi * speed * time)
            poses[:, 3 * 17 : 3 * 18] = swing[:, None] * [1.0, 0.6 * clip, 0.0]
            trans = np.zeros((150, 3)) + [0, 0, 1] + 0.002 * rng.normal(size=(150, 3))
            arrays = {"poses": poses, "trans": trans, "mocap_framerate": np.array(50.0)}
            write_npz(folder / activity / f"{clip}.npz", arrays)
    return folder


def run(library, out, *options):
    code, output = cli(
        "run", library, "--out", out, "--patches", 8, "--folds", 3, "--no-pictures", "--no-report",
        "--workers", 1, *options,
    )  # fmt: skip
    assert code == 0, output
    config = json.loads((out / "config.json").read_text())["parameters"]
    return config, ImuRecording.load(out / "signals" / "fast_0.npz")


@pytest.mark.slow
def test_an_own_sensor_is_used_kept_and_heeded_when_it_changes(library, tmp_path):
    part = tmp_path / "my part.json"
    part.write_text('{"like": "bmi270", "gyroscope": {"full_scale": "250 dps", "lowpass_hz": null}}')
    config, first = run(library, tmp_path / "out", "--sensor", part)
    assert config["sensor"] == "my part"
    assert config["own_sensor"]["gyroscope"]["full_scale"] == pytest.approx(np.radians(250))
    assert config["sensor_model"] == config["own_sensor"]
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert summary["sensor"] == "my part"
    baked = (tmp_path / "out" / "signals" / "fast_0.npz").stat().st_mtime_ns
    run(library, tmp_path / "out", "--sensor", part)
    assert (tmp_path / "out" / "signals" / "fast_0.npz").stat().st_mtime_ns == baked
    part.write_text('{"like": "bmi270", "gyroscope": {"full_scale": "125 dps"}}')
    _, second = run(library, tmp_path / "out", "--sensor", part)
    assert np.abs(first.gyr).max() > np.radians(130) > np.abs(second.gyr).max()  # clips at the new range
    assert preset("bmi270").gyroscope.full_scale > np.abs(first.gyr).max()
    clipped = json.loads((tmp_path / "out" / "summary.json").read_text())
    said = [caution["text"] for caution in clipped["cautions"] if "full scale" in caution["text"]]
    assert said[0].startswith("6 clips read the sensor's full scale in more than 1 % of the samples")


@pytest.mark.slow
def test_bands_and_convention_are_used_and_kept(library, tmp_path):
    options = ("--sensor", "ideal", "--rate", 50)
    config, usual = run(library, tmp_path / "out", *options)
    assert (config["synthesis"]["cutoff_hz"], config["root_band_hz"]) == (10, None)
    config, rooted = run(library, tmp_path / "out", *options, "--root-band", 2)
    assert config["root_band_hz"] == 2
    assert rooted.acc.std(axis=0).mean() < 0.8 * usual.acc.std(axis=0).mean()
    np.testing.assert_allclose(rooted.gyr, usual.gyr, atol=1e-6)  # turns know nothing of the path
    config, narrow = run(library, tmp_path / "out", *options, "--band", 3)
    assert config["synthesis"]["cutoff_hz"] == 3
    assert narrow.acc.std(axis=0).mean() < 0.8 * usual.acc.std(axis=0).mean()
    config, printed = run(library, tmp_path / "out", *options, "--convention", "paper", "--band", 0)
    assert (config["synthesis"]["convention"], config["synthesis"]["cutoff_hz"]) == ("paper", None)
    assert "folded back" in str(json.loads((tmp_path / "out" / "summary.json").read_text())["cautions"])
    assert np.median(np.abs(printed.acc - usual.acc)) > 1


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--sensor", "nosuch"], "there is no sensor preset 'nosuch'"),
        (["--sensor", "gone.json"], "--sensor: gone.json cannot be read: No such file"),
        (["--sensor", "BAD"], "'accelerometer.noise_density' must be 0 to 1 m/s2/sqrt(Hz), not 160"),
        (["--convention", "mine"], "--convention must be physical or paper, not mine"),
    ],
)
def test_wrong_use_is_a_sentence_before_anything_is_made(library, tmp_path, options, message):
    bad = tmp_path / "bad.json"
    bad.write_text('{"accelerometer": {"noise_density": 160}}')
    options = [str(bad) if word == "BAD" else word for word in options]
    code, output = cli("run", library, "--out", tmp_path / "out", *options)
    assert code == 2
    assert message in output
    assert not (tmp_path / "out").exists()


def test_sensors_shows_one_whole_and_writes_it(tmp_path):
    code, output = cli("sensors")
    assert code == 0
    assert "paper (5 deg, fixed)" in output
    code, output = cli("sensors", "bmi270", "--out", tmp_path / "mine.json")
    assert code == 0
    assert "noise_density" in output
    code, output = cli("sensors", tmp_path / "mine.json")
    assert code == 0, output
    (tmp_path / "mine.json").write_text('{"jitter": 1}')
    code, output = cli("sensors", tmp_path / "mine.json")
    assert (code, "did you mean 'jitter_s'" in output) == (2, True)
    assert cli("sensors", "--out", tmp_path / "x.json")[0] == 2
    code, output = cli("sensors", "bmi270", "--out", tmp_path / "no" / "x.json")
    assert (code, "there is no folder" in output) == (2, True)


def test_further_sensors_are_read_from_the_options():
    found = further_sensors("Barometer, orientation", "barometer", -64.3)
    assert found == FurtherSensors(("barometer", "orientation"), ("barometer",), -64.3)
    assert further_sensors("", "", NOTHING.dip_deg) == NOTHING
    for record, features, dip, words in (
        ("gps", "", NOTHING.dip_deg, "orientation, magnetometer, barometer, not 'gps'"),
        ("", "barometer", NOTHING.dip_deg, "barometer must be recorded"),
        ("", "", 95.0, "dips by -90 to 90 degrees"),
    ):
        with pytest.raises(ValueError, match=words) as caught:
            further_sensors(record, features, dip)
        assert str(caught.value).startswith("--")


def test_without_further_sensors_the_parameters_are_what_they_were():
    config = StudyConfig()
    assert "further" not in config.as_dict()
    assert "further" not in config.signal_parameters()
    assert StudyConfig.from_dict(config.as_dict()) == config
    full = StudyConfig(further=FurtherSensors(("barometer",), ("barometer",), altitude_m=300.0))
    assert StudyConfig.from_dict(json.loads(json.dumps(full.as_dict()))) == full
    assert full.signal_parameters() != config.signal_parameters()
    with pytest.raises(ValueError, match="multi3net learns from acc and gyr alone, not from barometer"):
        StudyConfig(classifier="multi3net", further=full.further)


@pytest.mark.slow
def test_what_else_is_recorded_stands_beside_acc_and_gyr_and_changes_nothing_of_them(library, tmp_path):
    every = ",".join(FURTHER)
    _, plain = run(library, tmp_path / "plain")
    config, full = run(library, tmp_path / "full", "--record", every, "--recognise-by", every)
    np.testing.assert_array_equal(full.acc, plain.acc)
    np.testing.assert_array_equal(full.gyr, plain.gyr)
    assert plain.further == {}
    assert {name: array.shape[2] for name, array in full.further.items()} == FURTHER
    assert np.isfinite(full.magnetometer).all()
    assert config["further"]["features"] == list(FURTHER)
    widths = [
        np.load(features_file(tmp_path / name, "fast_0"))["features"].shape[2] for name in ("plain", "full")
    ]
    assert widths[1] == widths[0] + 30 + 20 + 4
