# SPDX-License-Identifier: GPL-3.0-or-later
"""What the options for signals mean: the sensor, its rate, the bands, the convention."""

from __future__ import annotations

import math
from pathlib import Path

from w2w.core.imu.further import FurtherSensors
from w2w.core.imu.presets import PRESETS, preset
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.sensor_file import read_sensor
from w2w.core.imu.synthesis import CONVENTIONS, Synthesis


def further_sensors(record: str, features: str, magnetic_dip: float) -> FurtherSensors:
    """`--record`, `--recognise-by` and `--magnetic-dip` as `FurtherSensors`.

    Raises
    ------
    ValueError
        If a name is wrong; the message names the option.
    """
    try:
        return FurtherSensors(_names(record), _names(features), magnetic_dip)
    except ValueError as error:
        raise ValueError(f"--record, --recognise-by, --magnetic-dip: {error}") from error


def _names(text: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(part.strip().lower() for part in text.split(",") if part.strip()))


def chosen_sensor(text: str) -> SensorModel:
    """The sensor that `--sensor` names: a preset, or a file's.

    Raises
    ------
    ValueError
        If there is no such preset or the file does not describe a sensor; the message says why.
    """
    if not (text.lower().endswith(".json") or Path(text).is_file()):
        try:
            return preset(text)
        except ValueError as error:
            raise ValueError(f"--sensor: {error}, or a JSON file of your own part") from error
    try:
        return read_sensor(text)
    except OSError as error:
        raise ValueError(f"--sensor: {text} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ValueError(f"--sensor: {error}") from error


def sensor_settings(text: str) -> dict[str, str | SensorModel]:
    """`--sensor` as fields of a `StudyConfig`."""
    model = chosen_sensor(text)
    if PRESETS.get(model.name) == model:
        return {"sensor": model.name}
    return {"sensor": model.name, "own_sensor": model}


def synthesis_settings(rate: float, band: float, convention: str) -> Synthesis:
    """`--rate`, `--band` and `--convention` as a `Synthesis`.

    Raises
    ------
    ValueError
        If the convention is unknown.
    """
    if convention not in CONVENTIONS:
        raise ValueError(f"--convention must be {' or '.join(CONVENTIONS)}, not {convention}")
    if not (math.isfinite(rate) and math.isfinite(band)):
        raise ValueError("--rate and --band must be numbers of Hz")
    return Synthesis(rate_hz=rate, cutoff_hz=band or None, convention=convention)
