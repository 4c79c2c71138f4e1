# SPDX-License-Identifier: GPL-3.0-or-later
"""The field of a location and the pressure of a height are those of the published models."""

import numpy as np
import pytest

from w2w.core.imu import earth
from w2w.core.imu.earth import SEA_LEVEL_PA, height_of, magnetic_field, pressure_at


def elements(latitude, longitude):
    """Total field in microtesla, inclination (down positive) and declination (east positive) in degrees."""
    east, north, up = magnetic_field(latitude, longitude)
    level = np.hypot(east, north)
    return np.hypot(level, up), np.degrees(np.arctan2(-up, level)), np.degrees(np.arctan2(east, north))


@pytest.mark.parametrize("latitude", [-70.0, -20.0, 0.0, 45.0, 80.0])
def test_an_axial_dipole_dips_as_a_dipole(latitude, monkeypatch):
    monkeypatch.setattr(earth, "EARTH_FIELD_NT", ((1, 0, -30000.0, 0.0),))
    total, inclination, declination = elements(latitude, 33.0)
    sine = np.sin(np.radians(latitude))
    assert total == pytest.approx(30 * np.sqrt(1 + 3 * sine**2), rel=1e-6)
    assert np.tan(np.radians(inclination)) == pytest.approx(2 * np.tan(np.radians(latitude)), abs=1e-6)
    assert declination == pytest.approx(0, abs=1e-9)


def test_outside_its_sources_the_field_has_none():
    # the flux through a sphere vanishes: the mean of the upward component over its area
    nodes, weights = np.polynomial.legendre.leggauss(12)
    longitudes = np.arange(0, 360, 20)
    ups = [[magnetic_field(np.degrees(np.arcsin(x)), lon)[2] for lon in longitudes] for x in nodes]
    assert weights @ np.mean(ups, axis=1) == pytest.approx(0, abs=1e-9)


def test_the_pole_has_a_field():
    assert np.isfinite(magnetic_field(90.0, 0.0)).all()
    assert elements(90.0, 0.0)[0] == pytest.approx(elements(89.0, 0.0)[0], rel=0.02)


@pytest.mark.parametrize(
    ("height", "pressure"), [(0, 101325), (1000, 89874.6), (3000, 70108.5), (11000, 22632.1)]
)  # table of the International Standard Atmosphere, ISO 2533, by geopotential height
def test_pressure_is_the_standard_atmospheres(height, pressure):
    assert pressure_at(height) == pytest.approx(pressure, rel=1e-4)
    assert height_of(pressure_at(height)) == pytest.approx(height, abs=1e-6)


def test_a_metre_near_the_sea_is_twelve_pascal():
    assert SEA_LEVEL_PA - pressure_at(1.0) == pytest.approx(1.225 * 9.80665, rel=1e-3)
