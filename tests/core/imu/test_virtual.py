# SPDX-License-Identifier: GPL-3.0-or-later
"""A body's recording made part by part is the one made at once."""

from dataclasses import replace
from types import SimpleNamespace
from typing import NamedTuple

import numpy as np
import pytest

from w2w.core.imu import virtual as virtual_imu
from w2w.core.imu.presets import preset
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.imu.virtual import record_motion
from w2w.core.motion.skinning import patch_matrices

from ...sensor_steps import assert_same_to_one_step


class Patches(NamedTuple):
    """What `record_motion` reads of a PatchSet."""

    triangles: np.ndarray
    names: tuple[str, ...]


@pytest.fixture
def patches(bundled_body) -> Patches:
    triangles = bundled_body.faces[::300]
    return Patches(triangles, tuple(f"patch {k}" for k in range(len(triangles))))


@pytest.mark.parametrize("rate_hz", [None, 25.0])
def test_parts_make_up_the_whole(bundled_body, patches, waving, monkeypatch, rate_hz):
    monkeypatch.setattr(virtual_imu, "SENSORS_AT_ONCE", 7)
    settings, sensor = Synthesis(rate_hz=50), replace(preset("watch"), rate_hz=rate_hz)
    recording = record_motion(bundled_body, patches, waving, settings, sensor, seed=4)
    ideal = synthesize(patch_matrices(bundled_body, patches.triangles, waving), waving.rate, settings)
    whole = sensor.apply(replace(ideal, clip=waving.clip), seed=4)
    assert recording.rate == whole.rate == (rate_hz or 50)
    # a rounding difference may tip a sample over to the next count
    np.testing.assert_allclose(recording.acc, whole.acc, atol=1.01 * sensor.accelerometer.resolution)
    np.testing.assert_allclose(recording.gyr, whole.gyr, atol=1.01 * sensor.gyroscope.resolution)
    assert (recording.sites, recording.activity) == (patches.names, waving.activity)
    assert (recording.subject, recording.clip) == (waving.subject, waving.clip)


def test_chosen_sensors_are_those_of_the_whole_whatever_lay_in_memory(
    bundled_body, patches, waving, monkeypatch
):
    monkeypatch.setattr(virtual_imu, "SENSORS_AT_ONCE", 7)
    whole = record_motion(bundled_body, patches, waving)
    dirty = {"empty": lambda shape, dtype: np.full(shape, np.inf, dtype)}
    monkeypatch.setattr(virtual_imu, "np", SimpleNamespace(**vars(np) | dirty))
    chosen = record_motion(bundled_body, patches, waving, chosen=[9, 2])
    # a product of other shape may round otherwise
    assert_same_to_one_step(chosen, whole.at([9, 2]), virtual_imu.IDEAL)
    assert chosen.sites == (patches.names[9], patches.names[2])


def test_it_is_ideal_unless_told(bundled_body, patches, waving):
    recording = record_motion(bundled_body, patches, waving)
    ideal = synthesize(patch_matrices(bundled_body, patches.triangles, waving), waving.rate)
    np.testing.assert_allclose(recording.acc, ideal.acc, atol=1e-4)
    np.testing.assert_allclose(recording.gyr, ideal.gyr, atol=1e-5)
