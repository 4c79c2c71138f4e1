# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor of one's own: figures with units in, one sentence for whatever is wrong."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.body.body import TEMPLATES
from w2w.core.imu.presets import PRESETS, preset, read_sensor, write_sensor
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.sensor_fields import WRITTEN
from w2w.core.study.config import StudyConfig

G = 9.80665


def written(folder, content, name="my part.json"):
    path = folder / name
    path.write_text(content if isinstance(content, str) else json.dumps(content), encoding="utf-8")
    return path


@pytest.mark.parametrize("name", PRESETS)
def test_a_bundled_sensor_is_written_as_a_file_of_ones_own(tmp_path, name):
    content = json.loads((TEMPLATES / "sensors.json").read_text(encoding="utf-8"))[name]
    assert content.pop("sources", "") or name == "ideal"
    assert read_sensor(written(tmp_path, content | {"name": name})) == preset(name)


def test_figures_of_a_datasheet_with_their_units(tmp_path):
    model = read_sensor(
        written(
            tmp_path,
            {
                "like": "bmi270",
                "accelerometer": {
                    "full_scale": "16 g", "noise_density": "120 µg/√Hz", "turn_on_bias": "20 mg",
                    "random_walk": "0.01 mg/sqrt(s)", "scale_error": "0.5 %", "lowpass_hz": 100,
                },
                "gyroscope": {
                    "full_scale": "2000 dps", "noise_density": "5 mdps/rtHz", "bias_instability": "5 deg/hr",
                    "resolution": "0.07 dps",
                },
                "mounting_shift_m": "5 mm",
                "jitter_s": "1 ms",
                "drop_fraction": "2 %",
                "fixed_misalignment_deg": 3,
            },
        )
    )  # fmt: skip
    acc, gyr = model.accelerometer, model.gyroscope
    assert model.name == "my part"
    assert acc.full_scale == pytest.approx(16 * G)
    assert acc.noise_density == pytest.approx(120e-6 * G)
    assert acc.turn_on_bias == pytest.approx(0.02 * G)
    assert acc.random_walk == pytest.approx(1e-5 * G)
    assert acc.scale_error == pytest.approx(0.005)
    assert (acc.lowpass_hz, acc.lowpass_of_rate) == (100, None)  # instead of the base's own filter
    assert acc.resolution == preset("bmi270").accelerometer.resolution  # the base's
    assert gyr.full_scale == pytest.approx(math.radians(2000))
    assert gyr.noise_density == pytest.approx(math.radians(0.005))
    assert gyr.bias_instability == pytest.approx(math.radians(5 / 3600))
    assert gyr.lowpass_of_rate == preset("bmi270").gyroscope.lowpass_of_rate
    assert (model.mounting_shift_m, model.jitter_s, model.drop_fraction) == (0.005, 0.001, 0.02)
    assert model.fixed_misalignment_deg == 3


@pytest.mark.parametrize("name", list(PRESETS))
def test_every_preset_can_be_written_altered_and_read_again(tmp_path, name):
    path = tmp_path / "part.json"
    write_sensor(path, preset(name))
    assert read_sensor(path) == preset(name)
    content = json.loads(path.read_text())
    path.write_text(json.dumps(content | {"name": "mine", "mounting_turn_deg": 12}))
    assert read_sensor(path).mounting_turn_deg == 12


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("{", "not valid JSON"),
        ("[1]", "a sensor is a JSON object"),
        ('{"jitter_s": NaN}', "it holds NaN"),
        ("[" * 100_000, "nested too deeply"),
        ({"noise": 1}, "'noise' is no field of a sensor; there are name"),
        ({"jitter": 0.1}, "'jitter' is no field of a sensor; did you mean 'jitter_s'?"),
        ({"rate_hz": 100}, "'rate_hz' does not belong in a sensor's file: the rate is the study's"),
        ({"accelerometer": 3}, "'accelerometer' must be an object"),
        ({"gyroscope": {"fullscale": 1}}, "'gyroscope.fullscale' is no field of a sensor; did you mean "),
        ({"accelerometer": {"noise_density": 160}}, "noise_density' must be 0 to 1 m/s2/sqrt(Hz), not 160: "),
        ({"accelerometer": {"noise_density": "160 ug"}}, "'ug/sqrt(Hz)'"),
        ({"accelerometer": {"full_scale": 0}}, "full_scale' must be above 0, at most 10000 m/s2, or null"),
        ({"accelerometer": {"full_scale": "8 dps"}}, "(units: 'm/s2', 'g', 'mg', 'ug')"),
        ({"gyroscope": {"full_scale": 2000}}, "taken in rad/s; if deg/s is meant, write '2000 deg/s'"),
        ({"gyroscope": {"turn_on_bias": -1}}, "'gyroscope.turn_on_bias' must be 0 to 1 rad/s, not -1"),
        ({"gyroscope": {"lowpass_order": 2.5}}, "'gyroscope.lowpass_order' must be a whole number, 1 to 8"),
        ({"gyroscope": {"lowpass_hz": 40, "lowpass_of_rate": 0.4}}, "both 'lowpass_hz' and 'lowpass_of_"),
        ({"drop_fraction": True}, "'drop_fraction' must be a number, 0 to 0.9, not True"),
        ({"jitter_s": 10**400}, "'jitter_s' must be 0 to 0.1 s"),
        ({"jitter_s": None}, "'jitter_s' must be a number"),
        ({"worn_turn_deg": 30}, "'worn_turn_deg' must be a list of three angles in degrees, such as"),
        ({"worn_turn_deg": [0, 0, 400]}, "'worn_turn_deg' must be -360 to 360 deg, not 400"),
        ({"zero_phase": "yes"}, "'zero_phase' must be true or false"),
        ({"name": ""}, "'name' must be text"),
        ({"name": "bmi270"}, "'name' must not be that of a preset (bmi270)"),
        ({"like": "nothing"}, "'like': there is no sensor preset 'nothing'"),
        ({"like": 3}, "'like' must be the name of a preset"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_named_with_unit_and_range(tmp_path, content, message):
    with pytest.raises(ValueError, match=r"my part\.json: ") as caught:
        read_sensor(written(tmp_path, content))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_bytes_that_are_no_text_and_a_huge_file(tmp_path):
    (tmp_path / "a.json").write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(ValueError, match="not UTF-8 text"):
        read_sensor(tmp_path / "a.json")
    (tmp_path / "b.json").write_text(" " * (1 << 21))
    with pytest.raises(ValueError, match="too large"):
        read_sensor(tmp_path / "b.json")


def test_a_study_keeps_its_own_sensor_and_its_signals_depend_on_it(tmp_path):
    model = read_sensor(written(tmp_path, {"like": "phone", "mounting_turn_deg": 3}))
    config = StudyConfig(sensor=model.name, own_sensor=model, root_band_hz=3.0)
    again = StudyConfig.from_dict(json.loads(json.dumps(config.as_dict())))
    assert again == config
    assert again.sensor_model() == model
    other = StudyConfig(sensor=model.name, own_sensor=replace(model, jitter_s=0.01))
    assert other.signal_parameters() != StudyConfig(sensor=model.name, own_sensor=model).signal_parameters()
    assert StudyConfig(root_band_hz=3.0).signal_parameters() != StudyConfig().signal_parameters()
    with pytest.raises(ValueError, match="no sensor preset"):
        StudyConfig(sensor="another", own_sensor=model)


def test_a_fixed_misalignment_is_the_sensors_own_in_every_clip():
    still = np.tile([0.0, 0.0, G], (50, 4, 1))
    clips = [ImuRecording(still, np.zeros_like(still), 50.0, clip=name) for name in ("one", "two")]
    fixed = SensorModel(name="x", fixed_misalignment_deg=5.0)
    anew = SensorModel(name="y", mounting_turn_deg=5.0)
    first, second = (fixed.apply(clip, 0).acc for clip in clips)
    np.testing.assert_array_equal(first, second)
    assert (np.abs(first[0] - still[0]).max(axis=1) > 0.05).all()  # each sensor is turned
    assert len(np.unique(first[0, :, 0])) == 4  # each its own way
    np.testing.assert_allclose(np.linalg.norm(first, axis=2), G, rtol=1e-5)
    assert not np.array_equal(*(anew.apply(clip, 0).acc for clip in clips))
    assert not np.array_equal(fixed.apply(clips[0], 1).acc, first)  # another seed, another wearing
    part = ImuRecording(still[:, 2:], np.zeros_like(still[:, 2:]), 50.0, clip="one")
    np.testing.assert_array_equal(fixed.apply(part, 0, [2, 3]).acc, first[:, 2:])


def test_a_worn_sensors_turn_is_that_of_all_sensors_in_every_clip(tmp_path):
    model = read_sensor(written(tmp_path, {"worn_turn_deg": [0, 0, 90]}))
    read = model.apply(ImuRecording(np.tile([1.0, 2.0, G], (9, 3, 1)), np.ones((9, 3, 3)), 50.0), 0)
    np.testing.assert_allclose(read.acc, np.tile([2.0, -1.0, G], (9, 3, 1)), atol=1e-5)
    np.testing.assert_allclose(read.gyr, np.tile([1.0, -1.0, 1.0], (9, 3, 1)), atol=1e-5)
    config = StudyConfig(sensor=model.name, own_sensor=model)
    assert StudyConfig.from_dict(json.loads(json.dumps(config.as_dict()))) == config


def test_the_paper_preset_has_noise_drift_and_a_fixed_misalignment():
    model = preset("paper")
    for triad in (model.accelerometer, model.gyroscope):
        assert triad.noise_density > 0
        assert triad.bias_instability > 0
        assert triad.random_walk > 0
    assert model.fixed_misalignment_deg == 5
    assert model.mounting_turn_deg == 0
    still = np.tile([0.0, 0.0, G], (50 * 600, 1, 1))
    read = model.apply(ImuRecording(still, np.zeros_like(still), 50.0, clip="rest"), 0)
    noise = np.diff(read.gyr[:, 0, 0]).std() / np.sqrt(2)
    assert noise == pytest.approx(model.gyroscope.noise_density * 5, rel=0.1)  # over 25 Hz
    minutes = read.gyr[:, 0].reshape(10, -1, 3).mean(axis=1)
    assert np.ptp(minutes, axis=0).max() > 5 * noise / np.sqrt(3000)  # the bias wanders


@pytest.mark.parametrize("letter", ["1", " ", "."])
def test_a_quantity_is_searched_once_however_long_it_is(letter):
    """A million letters were gone over for each of them, which took hours."""
    for text in (f"1{letter * 2**20}a\n!", f"1 a{letter * 2**20}a\n!"):
        assert WRITTEN.fullmatch(text) is None


def test_a_quantity_is_a_number_and_a_unit():
    assert WRITTEN.fullmatch("16 g").groups() == ("16", "g")
    assert WRITTEN.fullmatch("-.5e3mg").groups() == ("-.5e3", "mg")
    assert WRITTEN.fullmatch("7.").groups() == ("7.", "")
