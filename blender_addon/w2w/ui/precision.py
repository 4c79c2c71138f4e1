# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as they were given: Blender's properties keep single precision only."""

from __future__ import annotations

SINGLE, DIGITS = 1e-6, 6
"""How far a property, in single precision, may be from the value it was given, and the decimals it keeps."""


def as_given(shown: float, given: float) -> float:
    """A property's value: the one given where it is that in single precision, else in few decimals."""
    return given if abs(shown - given) <= SINGLE * abs(given) else round(shown, DIGITS)
