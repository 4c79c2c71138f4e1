# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor of one's own as a JSON file: the figures of its datasheet, with their units."""

import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from ..files import write_json
from ..wording import shown
from .presets import PRESETS, preset
from .sensor import SensorModel
from .sensor_fields import GIVEN_ELSEWHERE, sensor_with

MAX_BYTES = 1 << 20
"""No description of a sensor is longer."""


def read_sensor(path: str | Path) -> SensorModel:
    """Read a sensor from a JSON file.

    Parameters
    ----------
    path : str or Path
        An object with any of ``name``, ``like`` (a preset whose figures stand where the file has none),
        ``accelerometer``, ``gyroscope`` and the fields of `SensorModel`. A bare number is in SI units
        (angles in degrees), text says its unit: ``"160 ug/sqrt(Hz)"``.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not such a file; the message names the field, its unit and range.
    """
    path = Path(path)
    try:
        return sensor_from(_content(path), path.stem)
    except ValueError as error:
        raise ValueError(f"{shown(path)}: {error}") from error


def sensor_from(content: Any, name: str) -> SensorModel:
    """A sensor from what a JSON file holds; `name` is its name where the content gives none.

    Raises ValueError if a field is unknown or out of its range.
    """
    if not isinstance(content, Mapping):
        raise ValueError('a sensor is a JSON object: {"name": ..., "accelerometer": {...}, ...}')
    model = sensor_with(_base(content.get("like")), content, name)
    if PRESETS.get(model.name, model) != model:
        raise ValueError(f"'name' must not be that of a preset ({model.name}) with other figures: change it")
    return model


def write_sensor(path: str | Path, model: SensorModel) -> None:
    """Write a sensor as `read_sensor` reads it."""
    write_json(path, sensor_content(model))


def sensor_content(model: SensorModel) -> dict[str, Any]:
    """A sensor as `sensor_from` takes it: every field, bare numbers."""
    return {name: value for name, value in asdict(model).items() if name not in GIVEN_ELSEWHERE}


def _content(path: Path) -> Any:
    if path.stat().st_size > MAX_BYTES:
        raise ValueError("it is too large to describe a sensor")
    try:
        return json.loads(path.read_text(encoding="utf-8-sig"), parse_constant=_refuse_constant)
    except UnicodeDecodeError as error:
        raise ValueError("it is not UTF-8 text") from error
    except json.JSONDecodeError as error:
        raise ValueError(f"it is not valid JSON: {error.msg} in line {error.lineno}") from error
    except RecursionError as error:
        raise ValueError("it is nested too deeply to describe a sensor") from error


def _refuse_constant(name: str) -> None:
    raise ValueError(f"it holds {name}, which is no figure of a sensor")


def _base(like: Any) -> SensorModel:
    if like is None:
        return SensorModel.ideal()
    if not isinstance(like, str):
        raise ValueError(f"'like' must be the name of a preset, not {like}")
    try:
        return preset(like)
    except ValueError as error:
        raise ValueError(f"'like': {error}") from error
