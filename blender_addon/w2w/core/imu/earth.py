# SPDX-License-Identifier: GPL-3.0-or-later
"""What the earth gives sensors beside gravity: the magnetic field of a location, and the air's pressure."""

from __future__ import annotations

from math import factorial

import numpy as np
from scipy.special import lpmv

EARTH_FIELD_NT = (
    (1, 0, -29350.0, 0.0), (1, 1, -1410.3, 4545.5),
    (2, 0, -2556.2, 0.0), (2, 1, 2950.9, -3133.6), (2, 2, 1648.7, -814.2),
    (3, 0, 1360.9, 0.0), (3, 1, -2404.2, -56.9), (3, 2, 1243.8, 237.6), (3, 3, 453.4, -549.6),
    (4, 0, 894.7, 0.0), (4, 1, 799.6, 278.6), (4, 2, 55.8, -134.0), (4, 3, -281.1, 212.0),
    (4, 4, 12.0, -375.4),
    (5, 0, -232.9, 0.0), (5, 1, 369.0, 45.3), (5, 2, 187.2, 220.0), (5, 3, -138.7, -122.9),
    (5, 4, -141.9, 42.9), (5, 5, 20.9, 106.2),
    (6, 0, 64.3, 0.0), (6, 1, 63.8, -18.4), (6, 2, 76.7, 16.8), (6, 3, -115.7, 48.9),
    (6, 4, -40.9, -59.8), (6, 5, 14.9, 10.9), (6, 6, -60.8, 72.8),
)  # fmt: skip
"""Degree, order, g and h of the International Geomagnetic Reference Field, IGRF-14 for 2025, to degree 6 of
13; the World Magnetic Model 2025 differs from it by at most 2 nT in each."""

POLE_DEG = 89.99
"""Latitudes beyond this, where east has no meaning, are taken as this."""

STEP = 1e-5
"""Radians from which the derivative by colatitude is taken."""

SEA_LEVEL_PA = 101_325.0
LAPSE_PER_M = 0.0065 / 288.15
PRESSURE_EXPONENT = 9.80665 * 0.0289644 / (8.3144598 * 0.0065)
"""International Standard Atmosphere up to 11 km: 15 degrees C at the sea, 6.5 degrees less each kilometre."""


def magnetic_field(latitude: float, longitude: float) -> np.ndarray:
    """The earth's magnetic field at sea level, without what buildings and steel do to it.

    Parameters
    ----------
    latitude, longitude : float
        Degrees, north and east positive. The earth is taken as a sphere.

    Returns
    -------
    ndarray, shape (3,)
        East, north and up, microtesla.
    """
    theta = np.radians(90 - np.clip(latitude, -POLE_DEG, POLE_DEG))
    phi = np.radians(longitude)
    east = north = up = 0.0
    for n, m, g, h in EARTH_FIELD_NT:
        along = g * np.cos(m * phi) + h * np.sin(m * phi)
        across = g * np.sin(m * phi) - h * np.cos(m * phi)
        value = _legendre(n, m, theta)
        slope = (_legendre(n, m, theta + STEP) - _legendre(n, m, theta - STEP)) / (2 * STEP)
        north += along * slope
        east += m * across * value / np.sin(theta)
        up += (n + 1) * along * value
    return np.array([east, north, up]) / 1000


def _legendre(n: int, m: int, theta: float) -> float:
    """Schmidt semi-normalised associated Legendre function of cos(theta)."""
    plain = (-1) ** m * float(lpmv(m, n, np.cos(theta)))  # without the Condon-Shortley phase
    return plain * (np.sqrt(2 * factorial(n - m) / factorial(n + m)) if m else 1.0)


def pressure_at(height: np.ndarray, sea_level: float = SEA_LEVEL_PA) -> np.ndarray:
    """Pressure of the standard atmosphere, Pa, at heights above the sea, m."""
    return sea_level * (1 - LAPSE_PER_M * np.asarray(height)) ** PRESSURE_EXPONENT


def height_of(pressure: np.ndarray, sea_level: float = SEA_LEVEL_PA) -> np.ndarray:
    """Height above the sea, m, at which the standard atmosphere has a pressure, Pa."""
    return (1 - (np.asarray(pressure) / sea_level) ** (1 / PRESSURE_EXPONENT)) / LAPSE_PER_M
