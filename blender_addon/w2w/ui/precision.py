# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as they were given: Blender's properties keep single precision only."""

from __future__ import annotations

SINGLE, DIGITS = 1e-6, 7
"""How far a property, in single precision, may be from the value it was given, and the digits it keeps."""


def as_given(shown: float, given: float) -> float:
    """A property's value: the one given where it is that in single precision, else in few digits."""
    return given if abs(shown - given) <= SINGLE * abs(given) else float(f"{shown:.{DIGITS}g}")
