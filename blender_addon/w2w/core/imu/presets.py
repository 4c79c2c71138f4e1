# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensor models of real parts, in figures and in words, and the user's own sensor as a JSON file.

`sensors.json` has the figures of the presets and the datasheet that each comes from.

How a datasheet is read there:

- A "typical" deviation of Bosch or ST is one standard deviation, as both makers define it; a tolerance of
  InvenSense and any minimum or maximum is three.
- Cross-axis sensitivity becomes lean between the axes, its arcsine.
- Ranges are the ones common in activity recognition, the resolution that of the part's word at that range.
- What a datasheet leaves out stays switched off. None of the chips' datasheets prints a bias instability.

`sources` notes which figures were read in the document's text ("read"), which agree with the register tables
that public drivers of the part print ("in drivers"), which were found as others copied them from the named
table ("copied"), and which are quoted from memory of the document ("recalled") and deserve a second look
before work that leans on them.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict
from json import JSONDecodeError
from pathlib import Path
from typing import Any

from ..body.body import template
from ..files import write_json
from ..given import given_path
from ..wording import clean, join_words, restated
from .sensor import SensorModel
from .sensor_fields import GIVEN_ELSEWHERE, sensor_with

MAX_BYTES = 1 << 20
"""No description of a sensor is longer."""

DEFAULT_SENSOR = "bmi270"
"""A current consumer part."""


def _bundled() -> dict[str, SensorModel]:
    presets: dict[str, SensorModel] = {}
    for name, sensor in template("sensors.json").items():
        base = presets[sensor["like"]] if "like" in sensor else SensorModel.ideal()
        figures = {field: value for field, value in sensor.items() if field != "sources"}
        presets[name] = sensor_with(base, figures, name)
    return presets


PRESETS = _bundled()
"""All presets by name."""


def preset(name: str) -> SensorModel:
    """Sensor model of a real part.

    Parameters
    ----------
    name : str
        One of `PRESETS`; case, spaces, hyphens and underscores do not matter.

    Returns
    -------
    SensorModel
        The sensor with the figures of its datasheet.

    Raises
    ------
    ValueError
        If there is no such preset; the message lists them.

    Examples
    --------
    >>> w2w.preset("BMI270").accelerometer.full_scale  # 8 g, m/s2
    78.4532
    """
    if not isinstance(name, str):
        raise ValueError(
            f"a sensor is a preset's name or a SensorModel (read_sensor reads a file), not {name!r}"
        )
    for known, model in PRESETS.items():
        if _plain(known) == _plain(name):
            return model
    raise ValueError(f"there is no sensor preset {name!r}; choose one of {', '.join(PRESETS)}")


def _plain(name: str) -> str:
    return "".join(character for character in name.lower() if character.isalnum())


def read_sensor(path: str | Path) -> SensorModel:
    """Read a sensor from a JSON file.

    Parameters
    ----------
    path : str or Path
        An object with any of ``name``, ``like`` (a preset whose figures stand if the file has none),
        ``accelerometer``, ``gyroscope`` and the fields of `SensorModel`. A bare number is in SI units
        (angles in degrees), text says its unit: ``"160 ug/sqrt(Hz)"``.

    Returns
    -------
    SensorModel
        The sensor with the figures of the file.

    Raises
    ------
    OSError
        If the file cannot be read.
    ValueError
        If it is not such a file; the message names the field, its unit and range.

    Examples
    --------
    >>> Path("mine.json").write_text('{"like": "bmi270", "name": "mine"}') > 0
    True
    >>> w2w.read_sensor("mine.json").name
    'mine'
    """
    path = given_path(path, "a sensor")
    with restated(f"{clean(path)}:", ValueError):
        return sensor_from(_content(path), path.stem)


def sensor_from(content: Any, name: str) -> SensorModel:
    """A sensor from the content of a JSON file; `name` is its name if the content gives none.

    Raises ValueError if a field is unknown or out of its range.
    """
    if not isinstance(content, Mapping):
        raise ValueError('a sensor is a JSON object: {"name": ..., "accelerometer": {...}, ...}')
    like = "ideal" if content.get("like") is None else content["like"]
    if not isinstance(like, str):
        raise ValueError(f"'like' must be the name of a preset, not {like}")
    with restated("'like':", ValueError):
        base = preset(like)
    model = sensor_with(base, content, name)
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
    with (
        restated("it is not UTF-8 text", UnicodeDecodeError),
        restated(lambda error: f"it is not valid JSON: {error.msg} in line {error.lineno}", JSONDecodeError),
        restated("it is nested too deeply to describe a sensor", RecursionError),
    ):
        return json.loads(path.read_text(encoding="utf-8-sig"), parse_constant=_refuse_constant)


def _refuse_constant(name: str) -> None:
    raise ValueError(f"it holds {name}, which is no figure of a sensor")


def wearing_sentences(model: SensorModel) -> str:
    """How much of the way a sensor is worn its signals contain, and how much they do not.

    Examples
    --------
    >>> wearing_sentences(SensorModel.ideal())
    'Loose straps, soft tissue and clothes are not in it.'
    """
    held, missing = [], []
    if model.mounting_turn_deg or model.mounting_shift_m:
        off = f"{model.mounting_turn_deg:g}° and {1000 * model.mounting_shift_m:g} mm"
        held.append(f"sits {off} off its place, anew in every clip (one standard deviation)")
    else:
        missing.append("loose straps")
    if model.fixed_misalignment_deg:
        held.append(f"is turned by {model.fixed_misalignment_deg:g}° for good (one standard deviation)")
    if any(model.worn_turn_deg):
        held.append("is turned as the sensor was that it was calibrated with")
    if model.soft_tissue_hz:
        share = f"{model.soft_tissue_gain:.0%}".replace("%", " %")
        held.append(f"rides on soft tissue ({model.soft_tissue_hz:g} Hz, {share} of its motion)")
    else:
        missing.append("soft tissue")
    if model.drop_fraction:
        held.append(f"loses {100 * model.drop_fraction:g} % of its samples")
    missing.append("clothes")
    lacks = f"{join_words(missing).capitalize()} are not in it."
    return f"It {join_words(held)}. {lacks}" if held else lacks
