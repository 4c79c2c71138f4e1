# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties made of the parameters that a study's records declare, and numbers as they were given to one."""

from __future__ import annotations

from typing import Any, get_args

from ..core.parameters import parameters_of
from ..core.study import StudyConfig

SINGLE, DIGITS = 1e-6, 7
"""How far a property, in single precision, may be from the value it was given, and the digits it keeps."""


def declared(name: str, **other: Any) -> dict[str, Any]:
    """Arguments of the property of that parameter; 0 stands for none.

    Parameters
    ----------
    name : str
        Of a parameter that `StudyConfig` or a record in it declares.
    **other
        Further arguments, and what differs from the declaration. Where Blender shows the `unit`, the label
        does not.
    """
    parameter = parameters_of(StudyConfig)[name]
    label = (
        parameter.title if "unit" in other or not parameter.unit else f"{parameter.title} ({parameter.unit})"
    )
    or_none = type(None) in get_args(parameter.kind)
    about = {
        "name": label,
        "description": parameter.help.removesuffix(".") + "; 0 for none" * (parameter.default is None),
        "default": 0 if parameter.default is None else parameter.default,
        "min": 0 if or_none else parameter.least,
        "max": parameter.most,
        "soft_min": parameter.usual[0],
        "soft_max": parameter.usual[1],
    }
    return {key: value for key, value in about.items() if value is not None} | other


def as_given(shown: float, given: float) -> float:
    """A property's value: the one given where it is that in single precision, else in few digits."""
    return given if abs(shown - given) <= SINGLE * abs(given) else float(f"{shown:.{DIGITS}g}")
