# SPDX-License-Identifier: GPL-3.0-or-later
"""Orientation, magnetometer and barometer read what a body moved as the test knows it gives them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.imu.presets import preset
from w2w.core.imu.recording import FURTHER, ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.imu.virtual import (
    LAPSE_PER_M,
    NOTHING,
    PRESSURE_EXPONENT,
    SEA_LEVEL_PA,
    FurtherSensors,
    further_signals,
    north_of,
    pressure_at,
)

RATE, SECONDS, SPIN, LIFT = 60.0, 4.0, 1.3, 0.25
SETTINGS = Synthesis(rate_hz=50.0, cutoff_hz=None)
EVERY = FurtherSensors(tuple(FURTHER), dip_deg=60.0, field_ut=48.0)
START = Rotation.from_euler("xyz", [[10, 20, 30], [-80, 5, 200], [170, -60, 0]], degrees=True)
"""Of three sensors on one rigid body."""
FIELD = np.array([0, 24.0, -48.0 * np.sqrt(0.75)])
"""48 microtesla, 60 degrees below the horizontal: east, north, up."""


def height_of(pressure):
    """Height above the sea, m, at which the standard atmosphere has a pressure, Pa."""
    return (1 - (pressure / SEA_LEVEL_PA) ** (1 / PRESSURE_EXPONENT)) / LAPSE_PER_M


def turning(n=3):
    """A body that turns about the vertical and is lifted, both steadily."""
    time = np.arange(int(RATE * SECONDS) + 1) / RATE
    matrices = np.tile(np.eye(4), (len(time), n, 1, 1))
    matrices[..., :3, :3] = np.stack(
        [(Rotation.from_rotvec([0, 0, SPIN * t]) * START[:n]).as_matrix() for t in time]
    )
    matrices[..., 2, 3] = 1.0 + LIFT * time[:, None]
    return matrices


def read(further, sensor=preset("ideal"), matrices=None, clip="a clip", seed=3):  # noqa: B008
    matrices = turning() if matrices is None else matrices
    return further_signals(matrices, RATE, SETTINGS, sensor, further, clip, seed)


def as_rotation(quaternions):
    return Rotation.from_quat(quaternions[..., [1, 2, 3, 0]].reshape(-1, 4))


def test_a_turning_body_in_a_known_field():
    found = read(EVERY)
    time = np.arange(len(found["magnetometer"])) / SETTINGS.rate_hz
    north = Rotation.from_rotvec([0, 0, north_of("a clip", 3)])
    field = north.apply(FIELD)
    for number in range(3):
        turned = Rotation.from_rotvec(SPIN * time[:, None] * [0, 0, 1]) * START[number]
        np.testing.assert_allclose(found["magnetometer"][:, number], turned.inv().apply(field), atol=2e-3)
        off = as_rotation(found["orientation"][:, number]) * turned.inv()
        assert off.magnitude().max() < 1e-5
    steps = np.abs(np.diff(found["orientation"], axis=0)).max()
    assert steps < SPIN / SETTINGS.rate_hz  # without jumps of the sign


def test_a_lifted_body_in_the_standard_atmosphere():
    pressure = read(EVERY)["barometer"][..., 0].astype(np.float64)
    time = np.arange(len(pressure)) / SETTINGS.rate_hz
    np.testing.assert_allclose(height_of(pressure), np.tile(1 + LIFT * time, (3, 1)).T, atol=2e-3)
    high = read(replace(EVERY, altitude_m=1600.0))["barometer"]
    assert height_of(high[0, 0, 0]) == pytest.approx(1601, abs=0.01)


@pytest.mark.parametrize(
    ("height", "pressure"), [(0, 101325), (1000, 89874.6), (3000, 70108.5), (11000, 22632.1)]
)  # table of the International Standard Atmosphere, ISO 2533, by geopotential height
def test_pressure_is_the_standard_atmospheres(height, pressure):
    assert pressure_at(height) == pytest.approx(pressure, rel=1e-4)


def test_they_sit_as_acc_and_gyr_do():
    worn = SensorModel(
        name="worn", mounting_turn_deg=15, fixed_misalignment_deg=10, worn_turn_deg=(20, 0, -70)
    )
    still = np.tile(turning()[:1], (90, 1, 1, 1))
    truth = replace(synthesize(still, RATE, SETTINGS), clip="a clip")
    acc = worn.apply(truth, seed=3).acc[20]
    exact = replace(EVERY, tilt_deg=0, heading_deg=0, hard_iron_ut=0, soft_iron=0, magnetometer_noise_ut=0)
    found = read(exact, worn, still)
    turned = as_rotation(found["orientation"][20])
    np.testing.assert_allclose(turned.inv().apply([0, 0, 9.80665]), acc, atol=1e-3)
    assert (turned * START.inv()).magnitude().min() > 0.02
    field = Rotation.from_rotvec([0, 0, north_of("a clip", 3)]).apply(FIELD)
    np.testing.assert_allclose(turned.inv().apply(field), found["magnetometer"][20], atol=1e-3)


def test_a_shift_on_the_skin_moves_the_barometer():
    shifted = SensorModel(name="worn", mounting_shift_m=0.5)
    calm = replace(EVERY, pressure_noise_pa=0, pressure_offset_pa=0, weather_pa=0)
    moved = read(calm, shifted)["barometer"].astype(np.float64) - read(calm)["barometer"]
    assert np.ptp(moved[0]) > 1  # Pa, some centimetres and more
    np.testing.assert_allclose(moved, np.tile(moved[:1], (len(moved), 1, 1)), atol=0.05)  # about the vertical


@pytest.mark.slow
def test_iron_noise_and_offsets_have_the_sizes_given():
    many = np.tile(turning(1)[:60], (1, 400, 1, 1))
    sensor = SensorModel(name="noisy", jitter_s=0.0001)  # any error makes it a real part
    errors = FurtherSensors(
        tuple(FURTHER), tilt_deg=2.0, heading_deg=4.0, magnetometer_noise_ut=0.5, hard_iron_ut=3.0,
        soft_iron=0.0, pressure_noise_pa=2.0, pressure_offset_pa=30.0,
    )  # fmt: skip
    found, exact = read(errors, sensor, many), read(errors, matrices=many)
    off = found["magnetometer"] - exact["magnetometer"]
    assert off.mean(axis=0).std() == pytest.approx(3.0, rel=0.1)
    assert off.std(axis=0).mean() == pytest.approx(0.5, rel=0.05)
    wrong = (as_rotation(found["orientation"]) * as_rotation(exact["orientation"]).inv()).as_rotvec(
        degrees=True
    )
    np.testing.assert_allclose(wrong.std(axis=0), [2, 2, 4], rtol=0.15)
    pressure = (found["barometer"] - exact["barometer"])[..., 0].astype(np.float64)
    assert pressure.mean(axis=0).std() == pytest.approx(30, rel=0.15)
    assert pressure.std(axis=0).mean() == pytest.approx(2.0, rel=0.05)
    assert abs(pressure.mean()) > 40  # the weather, the same for all
    iron = replace(errors, hard_iron_ut=0.0, magnetometer_noise_ut=0.0, soft_iron=0.05)
    bent = read(iron, sensor, many)["magnetometer"] - exact["magnetometer"]
    strength = np.linalg.norm(exact["magnetometer"][0, 0])
    assert bent[0].std() == pytest.approx(0.05 * strength, rel=0.1)


def test_every_clip_has_its_own_north_and_sensors_do_not_depend_on_their_company():
    assert north_of("a", 0) != north_of("b", 0) != north_of("b", 1)
    sensor, matrices = preset("phone"), turning()
    whole = read(EVERY, sensor, matrices)
    for name, values in whole.items():
        alone = further_signals(matrices[:, 1:], RATE, SETTINGS, sensor, EVERY, "a clip", 3, [1, 2])
        np.testing.assert_allclose(alone[name], values[:, 1:], rtol=1e-6, atol=1e-4)


def test_samples_are_lost_together():
    losing = SensorModel(name="losing", drop_fraction=0.3, dropped="nan")
    matrices = turning()
    acc = losing.apply(replace(synthesize(matrices, RATE, SETTINGS), clip="a clip"), seed=3).acc
    for values in read(EVERY, losing, matrices).values():
        np.testing.assert_array_equal(np.isnan(values).any(axis=2), np.isnan(acc).any(axis=2))
    assert np.isnan(acc).any()


def test_what_cannot_be_is_refused():
    with pytest.raises(ValueError, match="there are orientation, magnetometer, barometer, not 'gps'"):
        FurtherSensors(("gps",))
    with pytest.raises(ValueError, match="barometer must be recorded"):
        FurtherSensors(("orientation",), ("barometer",))
    with pytest.raises(ValueError, match="dips by -90 to 90 degrees and has 0 to 100 microtesla, not 91"):
        FurtherSensors(dip_deg=91.0)
    with pytest.raises(ValueError, match="rate of the sensor's own"):
        read(EVERY, SensorModel(rate_hz=25.0))
    assert read(NOTHING) == {}


def test_a_recording_keeps_them_and_is_the_same_without(tmp_path):
    acc = np.ones((10, 2, 3))
    plain, full = (
        ImuRecording(acc, acc, 50.0),
        ImuRecording(acc, acc, 50.0, barometer=np.full((10, 2, 1), 1e5)),
    )
    plain.save(tmp_path / "plain.npz")
    full.save(tmp_path / "full.npz")
    with np.load(tmp_path / "plain.npz") as data:
        assert set(data) == {"acc", "gyr", "rate", "sites", "activity", "subject", "clip"}
    again = ImuRecording.load(tmp_path / "full.npz")
    np.testing.assert_array_equal(again.barometer, full.barometer)
    assert again.orientation is None
    with pytest.raises(ValueError, match=r"magnetometer must have shape \(10, 2, 3\)"):
        ImuRecording(acc, acc, 50.0, magnetometer=np.ones((10, 2)))


def test_the_same_sensors_keep_the_order_that_features_follow():
    run = FurtherSensors(record=("barometer", "orientation"), features=("barometer",), dip_deg=60.0)
    same = run.of({"orientation", "barometer"}, {"barometer"}, 60.0)
    assert same == run
    assert run.of({"barometer", "magnetometer"}, set(), 50.0) == FurtherSensors(
        record=("magnetometer", "barometer"), dip_deg=50.0
    )
