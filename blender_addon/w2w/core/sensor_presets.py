# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensor models of real parts, with the datasheet each figure comes from."""

from __future__ import annotations

import numpy as np

from .sensor import SensorModel, Triad

G = 9.80665
MG = G / 1000
UG = G / 1e6
DPS = np.pi / 180

DEFAULT_SENSOR = "bmi270"


def preset(name: str) -> SensorModel:
    """Sensor model of a real part.

    Parameters
    ----------
    name : str
        One of `PRESETS`; case, spaces, hyphens and underscores do not matter.
    """
    wanted = "".join(character for character in name.lower() if character.isalnum())
    for known, model in PRESETS.items():
        if "".join(character for character in known if character.isalnum()) == wanted:
            return model
    raise ValueError(f"there is no sensor preset {name!r}; choose one of {', '.join(PRESETS)}")


PRESETS: dict[str, SensorModel] = {
    "ideal": SensorModel.ideal(),
    "bmi270": SensorModel(
        name="bmi270",
        accelerometer=Triad(
            full_scale=8 * G,
            resolution=8 * G / 32768,
            noise_density=160 * UG,
            turn_on_bias=20 * MG,
            lowpass_hz=40.0,
        ),
        gyroscope=Triad(
            full_scale=2000 * DPS,
            resolution=2000 * DPS / 32768,
            noise_density=0.007 * DPS,
            turn_on_bias=0.5 * DPS,
            lowpass_hz=40.0,
        ),
    ),
}
