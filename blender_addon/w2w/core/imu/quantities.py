# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers with units as datasheets print them: "160 ug/sqrt(Hz)", "0.07 dps", "8 g"."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, radians
from typing import Any

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
