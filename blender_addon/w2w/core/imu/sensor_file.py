# SPDX-License-Identifier: GPL-3.0-or-later
"""A sensor of one's own as a JSON file: the figures of its datasheet, with their units."""

from __future__ import annotations

import difflib
import json
from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from pathlib import Path
from typing import Any

from ..file_names import shown
from ..files import write_json
from .errors import DRIFT_STEP_S
from .presets import PRESETS, preset
from .quantities import (
    ACCELERATION,
    ANGLE,
    HERTZ,
    METRES,
    SECONDS,
    SHARE,
    TURNING,
    Quantity,
    rooted,
)
from .sensor import SensorModel, Triad

MAX_BYTES = 1 << 20
"""No description of a sensor is longer."""


def _triad(units: Mapping[str, float], most: Mapping[str, float]) -> dict[str, Quantity]:
    """The fields of three axes; `most` holds the highest values that depend on the kind."""
    return {
        "full_scale": Quantity(units, 0, most["full_scale"], above=True, may_be_off=True),
        "resolution": Quantity(units, 0, most["resolution"]),
        "noise_density": Quantity(rooted(units, "Hz"), 0, most["noise_density"]),
        "bias_instability": Quantity(units, 0, most["bias_instability"]),
        "correlation_s": Quantity(SECONDS, DRIFT_STEP_S, 1e5),
        "random_walk": Quantity(rooted(units, "s"), 0, most["random_walk"]),
        "turn_on_bias": Quantity(units, 0, most["turn_on_bias"]),
        "scale_error": Quantity(SHARE, 0, 0.5),
        "misalignment_deg": Quantity(ANGLE, 0, 45),
        "nonorthogonality_deg": Quantity(ANGLE, 0, 20),
        "lowpass_hz": Quantity(HERTZ, 0, 5000, above=True, may_be_off=True),
        "lowpass_of_rate": Quantity(SHARE, 0, 0.5, above=True, may_be_off=True),
        "lowpass_order": Quantity({"": 1.0}, 1, 8, whole=True),
    }


TRIADS = {
    "accelerometer": _triad(
        ACCELERATION,
        {
            "full_scale": 1e4, "resolution": 10.0, "noise_density": 1.0, "bias_instability": 1.0,
            "random_walk": 1.0, "turn_on_bias": 20.0,
        },
    ),
    "gyroscope": _triad(
        TURNING,
        {
            "full_scale": 200.0, "resolution": 1.0, "noise_density": 0.1, "bias_instability": 0.1,
            "random_walk": 0.1, "turn_on_bias": 1.0,
        },
    ),
}  # fmt: skip
"""Fields of each triad."""

WHOLE = {
    "g_sensitivity": Quantity(
        {"(rad/s)/(m/s2)": 1.0, "deg/s/g": TURNING["deg/s"] / ACCELERATION["g"]}, 0, 0.1
    ),
    "jitter_s": Quantity(SECONDS, 0, 0.1),
    "drop_fraction": Quantity(SHARE, 0, 0.9),
    "drop_duration_s": Quantity(SECONDS, 0, 60),
    "mounting_turn_deg": Quantity(ANGLE, 0, 90),
    "mounting_shift_m": Quantity(METRES, 0, 0.2),
    "fixed_misalignment_deg": Quantity(ANGLE, 0, 90),
    "soft_tissue_hz": Quantity(HERTZ, 0, 500, above=True, may_be_off=True),
    "soft_tissue_damping": Quantity({"": 1.0}, 0, 5),
    "soft_tissue_gain": Quantity(SHARE, 0, 1),
}
"""Fields of the whole sensor that hold a number."""

TURN = Quantity(ANGLE, -360, 360)
"""Each of the three angles of ``worn_turn_deg``."""

OTHERS = ("name", "like", "zero_phase", "worn_turn_deg")

GIVEN_ELSEWHERE = {
    "rate_hz": "the rate is given on the command line (--rate)",
    "dropped": "lost samples are always held",
}


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
    """A sensor from what a JSON file holds.

    Parameters
    ----------
    content : Any
    name : str
        The sensor's, where the content gives none.

    Raises
    ------
    ValueError
        If a field is unknown or out of its range.
    """
    if not isinstance(content, Mapping):
        raise ValueError('a sensor is a JSON object: {"name": ..., "accelerometer": {...}, ...}')
    _refuse_unknown(content, (*OTHERS, *TRIADS, *WHOLE), "")
    base = _base(content.get("like"))
    given = {field: WHOLE[field].read(content[field], field) for field in WHOLE if field in content}
    if "zero_phase" in content:
        given["zero_phase"] = _switch(content["zero_phase"])
    if "worn_turn_deg" in content:
        given["worn_turn_deg"] = _turn(content["worn_turn_deg"])
    for kind, quantities in TRIADS.items():
        given[kind] = _read_triad(content.get(kind, {}), kind, quantities, getattr(base, kind))
    model = replace(base, name=_name(content.get("name", name)), **given)
    known = PRESETS.get(model.name)
    if known is not None and known != model:
        raise ValueError(f"'name' must not be that of a preset ({model.name}) with other figures: change it")
    return model


def write_sensor(path: str | Path, model: SensorModel) -> None:
    """Write a sensor as `read_sensor` reads it."""
    write_json(path, sensor_content(model))


def sensor_content(model: SensorModel) -> dict[str, Any]:
    """A sensor as `sensor_from` takes it: every field, bare numbers."""
    content = asdict(model)
    for field in GIVEN_ELSEWHERE:
        del content[field]
    return content


def sensor_of_plain(values: Mapping[str, Any]) -> SensorModel:
    """The sensor that `dataclasses.asdict` turned into plain values; fields it lacks take their defaults."""
    known = {item.name for item in fields(SensorModel)}
    given = {name: value for name, value in values.items() if name in known}
    triads = {kind: Triad(**given[kind]) for kind in TRIADS if kind in given}
    return SensorModel(**given | triads)


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


def _refuse_unknown(content: Mapping[str, Any], known: tuple[str, ...], inside: str) -> None:
    for field in content:
        if field in known:
            continue
        full = f"{inside}{field}"
        if not inside and field in GIVEN_ELSEWHERE:
            raise ValueError(f"'{full}' does not belong in a sensor's file: {GIVEN_ELSEWHERE[field]}")
        near = difflib.get_close_matches(field, known, 1)
        hint = f"; did you mean '{near[0]}'?" if near else f"; there are {', '.join(known)}"
        raise ValueError(f"'{full}' is no field of a sensor{hint}")


def _base(like: Any) -> SensorModel:
    if like is None:
        return SensorModel.ideal()
    if not isinstance(like, str):
        raise ValueError(f"'like' must be the name of a preset, not {like}")
    try:
        return preset(like)
    except ValueError as error:
        raise ValueError(f"'like': {error}") from error


def _read_triad(content: Any, kind: str, quantities: Mapping[str, Quantity], base: Triad) -> Triad:
    if not isinstance(content, Mapping):
        raise ValueError(f"'{kind}' must be an object with fields such as 'noise_density', not {content}")
    _refuse_unknown(content, tuple(quantities), f"{kind}.")
    given = {field: quantities[field].read(value, f"{kind}.{field}") for field, value in content.items()}
    for one, other in (("lowpass_hz", "lowpass_of_rate"), ("lowpass_of_rate", "lowpass_hz")):
        if given.get(one) is not None:
            if given.get(other) is not None:
                raise ValueError(f"'{kind}' gives both 'lowpass_hz' and 'lowpass_of_rate': leave one out")
            given[other] = None  # the base's own filter goes
    return replace(base, **given)


def _switch(value: Any) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"'zero_phase' must be true or false, not {value}")
    return value


def _turn(value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != 3:
        raise ValueError(
            f"'worn_turn_deg' must be a list of three angles in degrees, such as [0, 0, 90], not {value}"
        )
    return tuple(TURN.read(angle, "worn_turn_deg") for angle in value)


def _name(value: Any) -> str:
    if not isinstance(value, str) or not value.strip() or len(value) > 60 or not value.isprintable():
        raise ValueError("'name' must be text of 1 to 60 printable characters")
    return value.strip()
