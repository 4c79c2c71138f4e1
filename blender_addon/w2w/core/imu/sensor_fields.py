# SPDX-License-Identifier: GPL-3.0-or-later
"""The fields of a sensor in JSON: ranges, and numbers with units as datasheets print them, "0.07 dps".

`FIGURES` are those of an own part that a form asks for, in a datasheet's units.
"""

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import inf, radians
from typing import Any, NamedTuple

from .errors import DRIFT_STEP_S
from .sensor import SensorModel, Triad

G = 9.80665

ACCELERATION = {"m/s2": 1.0, "g": G, "mg": G / 1e3, "ug": G / 1e6}
TURNING = {
    "rad/s": 1.0, "deg/s": radians(1), "dps": radians(1), "mdps": radians(1e-3), "deg/h": radians(1 / 3600),
}  # fmt: skip
ANGLE = {"deg": 1.0}
SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6}
METRES = {"m": 1.0, "cm": 0.01, "mm": 1e-3}
HERTZ = {"Hz": 1.0}
SHARE = {"": 1.0, "%": 0.01}

WRITTEN = re.compile(r"([-+]?(?:\d++(?:\.\d*+)?|\.\d++)(?:[eE][-+]?\d++)?)\s*+(.*)")

SPELLINGS = (
    ("µ", "u"), ("μ", "u"), ("°", "deg"), ("²", "2"), ("^2", "2"), (" ", ""), ("√", "sqrt"),
    ("sqrthz", "sqrt(hz)"), ("rthz", "sqrt(hz)"), ("sqrts", "sqrt(s)"), ("rts", "sqrt(s)"), ("/hr", "/h"),
)  # fmt: skip


def rooted(units: Mapping[str, float], under: str) -> dict[str, float]:
    """The units of a density: each over the square root of Hz or s."""
    return {f"{name}/sqrt({under})": factor for name, factor in units.items()}


@dataclass(frozen=True)
class Quantity:
    """The values that a field may have."""

    units: Mapping[str, float]  # unit -> its size in the first one, which a bare number is in
    least: float = 0.0  # in the first unit
    most: float = 1.0  # in the first unit
    may_be_off: bool = False  # whether null switches it off; the least itself is then out of range
    whole: bool = False  # whether it counts something

    @property
    def unit(self) -> str:
        """The unit of a bare number."""
        return next(iter(self.units))

    @property
    def range_text(self) -> str:
        """The range in words, with its unit."""
        low = f"above {self.least:g}, at most" if self.may_be_off else f"{self.least:g} to"
        text = f"{low} {self.most:g} {self.unit}".rstrip()
        return f"{text}, or null for none" if self.may_be_off else text

    def read(self, value: Any, name: str) -> float | int | None:
        """The value in the first unit; ValueError, with field, unit and range, if it is none."""
        if value is None and self.may_be_off:
            return None
        number = self._number(value, name)
        in_range = self.least < number if self.may_be_off else self.least <= number
        if not (in_range and number <= self.most):
            raise ValueError(f"'{name}' must be {self.range_text}, not {_shown(value)}{self._hint(value)}")
        if self.whole and number != int(number):
            raise ValueError(f"'{name}' must be a whole number, {self.range_text}, not {_shown(value)}")
        return int(number) if self.whole else number

    def _number(self, value: Any, name: str) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float | str):
            raise ValueError(f"'{name}' must be a number, {self.range_text}, not {_shown(value)}")
        if not isinstance(value, str):
            try:
                return float(value)
            except OverflowError:  # a whole number of hundreds of digits
                return inf
        written = WRITTEN.fullmatch(value.strip())
        unit = None if written is None else self._unit(written[2])
        if written is None or unit is None:
            known = ", ".join(f"'{known}'" for known in self.units if known)
            as_text = f", or text such as '{self.least + 1:g} {list(self.units)[-1]}' (units: {known})"
            raise ValueError(
                f"'{name}' must be a number in {self.unit or 'no unit'}{as_text if known else ''}, "
                f"not {_shown(value)}"
            )
        return float(written[1]) * self.units[unit]

    def _unit(self, text: str) -> str | None:
        plain = text.lower()
        for spelling, meant in SPELLINGS:
            plain = plain.replace(spelling, meant)
        if not plain:
            return self.unit
        return next((unit for unit in self.units if unit.lower() == plain), None)

    def _hint(self, value: Any) -> str:
        """How the number would have to be written in a datasheet's unit, if one makes it possible."""
        if isinstance(value, str):
            return ""
        number = self._number(value, "")
        for unit, size in self.units.items():
            if size != 1 and self.least < size * number <= self.most:
                return f": it is taken in {self.unit}; if {unit} is meant, write '{number:g} {unit}'"
        return ""


def _shown(value: Any) -> str:
    """A value from a file, short enough for a sentence."""
    text = repr(value) if isinstance(value, str) else str(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _triad(units: Mapping[str, float], **most: float) -> dict[str, Quantity]:
    """The fields of three axes; `most` holds the highest values that depend on the kind."""
    return {
        "full_scale": Quantity(units, 0, most["full_scale"], may_be_off=True),
        "resolution": Quantity(units, 0, most["resolution"]),
        "noise_density": Quantity(rooted(units, "Hz"), 0, most["noise_density"]),
        "bias_instability": Quantity(units, 0, most["bias_instability"]),
        "correlation_s": Quantity(SECONDS, DRIFT_STEP_S, 1e5),
        "random_walk": Quantity(rooted(units, "s"), 0, most["random_walk"]),
        "turn_on_bias": Quantity(units, 0, most["turn_on_bias"]),
        "scale_error": Quantity(SHARE, 0, 0.5),
        "misalignment_deg": Quantity(ANGLE, 0, 45),
        "nonorthogonality_deg": Quantity(ANGLE, 0, 20),
        "lowpass_hz": Quantity(HERTZ, 0, 5000, may_be_off=True),
        "lowpass_of_rate": Quantity(SHARE, 0, 0.5, may_be_off=True),
        "lowpass_order": Quantity({"": 1.0}, 1, 8, whole=True),
    }


TRIADS = {
    "accelerometer": _triad(
        ACCELERATION, full_scale=1e4, resolution=10.0, noise_density=1.0, bias_instability=1.0,
        random_walk=1.0, turn_on_bias=20.0,
    ),
    "gyroscope": _triad(
        TURNING, full_scale=200.0, resolution=1.0, noise_density=0.1, bias_instability=0.1,
        random_walk=0.1, turn_on_bias=1.0,
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
    "soft_tissue_hz": Quantity(HERTZ, 0, 500, may_be_off=True),
    "soft_tissue_damping": Quantity({"": 1.0}, 0, 5),
    "soft_tissue_gain": Quantity(SHARE, 0, 1),
}
"""Fields of the whole sensor that hold a number."""

TURN = Quantity(ANGLE, -360, 360)
"""Each of the three angles of ``worn_turn_deg``."""

OTHERS = ("name", "like", "zero_phase", "worn_turn_deg")

GIVEN_ELSEWHERE = {
    "rate_hz": "the rate is the study's, not the part's",
    "dropped": "lost samples are always held",
}


def sensor_with(base: SensorModel, content: Mapping[str, Any], name: str) -> SensorModel:
    """A sensor with the fields that JSON content gives and the others of `base`; errors name a wrong one."""
    _refuse_unknown(content, (*OTHERS, *TRIADS, *WHOLE), "")
    given: dict[str, Any] = {
        field: WHOLE[field].read(content[field], field) for field in WHOLE if field in content
    }
    given["zero_phase"] = content.get("zero_phase", base.zero_phase)
    if not isinstance(given["zero_phase"], bool):
        raise ValueError(f"'zero_phase' must be true or false, not {given['zero_phase']}")
    if "worn_turn_deg" in content:
        turn = content["worn_turn_deg"]
        if not isinstance(turn, list) or len(turn) != 3:
            raise ValueError(
                f"'worn_turn_deg' must be a list of three angles in degrees, such as [0, 0, 90], not {turn}"
            )
        given["worn_turn_deg"] = tuple(TURN.read(angle, "worn_turn_deg") for angle in turn)
    for kind, quantities in TRIADS.items():
        given[kind] = _read_triad(content.get(kind, {}), kind, quantities, getattr(base, kind))
    name = content.get("name", name)
    if not isinstance(name, str) or not name.strip() or len(name) > 60 or not name.isprintable():
        raise ValueError("'name' must be text of 1 to 60 printable characters")
    return replace(base, name=name.strip(), **given)


def _refuse_unknown(content: Mapping[str, Any], known: tuple[str, ...], inside: str) -> None:
    for field in content:
        if field in known:
            continue
        if not inside and field in GIVEN_ELSEWHERE:
            raise ValueError(f"'{field}' does not belong in a sensor's file: {GIVEN_ELSEWHERE[field]}")
        near = difflib.get_close_matches(field, known, 1)
        hint = f"; did you mean '{near[0]}'?" if near else f"; there are {', '.join(known)}"
        raise ValueError(f"'{inside}{field}' is no field of a sensor{hint}")


def _read_triad(content: Any, kind: str, quantities: Mapping[str, Quantity], base: Triad) -> Triad:
    if not isinstance(content, Mapping):
        raise ValueError(f"'{kind}' must be an object with fields such as 'noise_density', not {content}")
    _refuse_unknown(content, tuple(quantities), f"{kind}.")
    given: dict[str, Any] = {
        field: quantities[field].read(value, f"{kind}.{field}") for field, value in content.items()
    }
    filters = {"lowpass_hz", "lowpass_of_rate"}
    chosen = {field for field in filters if given.get(field) is not None}
    if chosen == filters:
        raise ValueError(f"'{kind}' gives both 'lowpass_hz' and 'lowpass_of_rate': leave one out")
    if chosen:
        given |= dict.fromkeys(filters - chosen)  # the base's own filter goes
    return replace(base, **given)


DIGITS = 6
"""Digits that a figure keeps: a form may hold it in single precision."""


class Figure(NamedTuple):
    """One figure."""

    kind: str  # the triad it is of; empty for the whole sensor
    field: str  # its name in the sensor's file
    unit: str  # the one that datasheets print it in
    label: str  # for people
    about: str  # for people

    @property
    def quantity(self) -> Quantity:
        """Its units and range in the file."""
        return (TRIADS[self.kind] if self.kind else WHOLE)[self.field]

    @property
    def size(self) -> float:
        """One of its unit in the model's."""
        return self.quantity.units[self.unit]

    @property
    def most(self) -> float:
        """The highest value, in its unit."""
        return self.quantity.most / self.size

    def of(self, model: SensorModel) -> float:
        """The figure of a sensor, in its unit; 0 if it is switched off."""
        held = getattr(getattr(model, self.kind) if self.kind else model, self.field)
        return 0.0 if held is None else held / self.size

    def given(self, model: SensorModel, value: float) -> SensorModel:
        """The sensor with another figure, in its unit; 0 switches it off.

        Raises ValueError if it is out of range.
        """
        plain = float(f"{value:.{DIGITS}g}") * self.size
        if value <= self.most:  # rounding may not carry it out of its range
            plain = min(plain, self.quantity.most)
        held = self.quantity.read(None if not plain and self.quantity.may_be_off else plain, self.label)
        changed: dict[str, Any] = {self.field: held}
        if self.kind:
            changed = {self.kind: replace(getattr(model, self.kind), **changed)}
        return replace(model, **changed)


RANGE = "Readings are clipped to this; 0 for no limit"
NOISE = "Density of the white noise"
BIAS = "Constant bias of each axis, anew in every clip (one standard deviation)"
DRIFT = "Bias instability of the Allan plot"
TURNED = "How far the sensor is turned against its place, the same in every clip (one standard deviation)"

FIGURES = {
    "acc_range": Figure("accelerometer", "full_scale", "g", "Range (g)", RANGE),
    "acc_noise": Figure("accelerometer", "noise_density", "ug/sqrt(Hz)", "Noise (µg/√Hz)", NOISE),
    "acc_bias": Figure("accelerometer", "turn_on_bias", "mg", "Bias (mg)", BIAS),
    "acc_drift": Figure("accelerometer", "bias_instability", "ug", "Drift (µg)", DRIFT),
    "gyr_range": Figure("gyroscope", "full_scale", "deg/s", "Range (°/s)", RANGE),
    "gyr_noise": Figure("gyroscope", "noise_density", "mdps/sqrt(Hz)", "Noise (mdps/√Hz)", NOISE),
    "gyr_bias": Figure("gyroscope", "turn_on_bias", "deg/s", "Bias (°/s)", BIAS),
    "gyr_drift": Figure("gyroscope", "bias_instability", "deg/h", "Drift (°/h)", DRIFT),
    "misalignment": Figure("", "fixed_misalignment_deg", "deg", "Misalignment (°)", TURNED),
}
"""Sensor fields by the names of a form's fields."""
