# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties made from the parameters that `StudyConfig` declares, and numbers as the user gave them."""

from typing import Any, Literal, get_args, get_origin

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ...core.parameters import Parameter, parameters_of, with_values
from ...core.ranking.utility import CLASSIFIERS
from ...core.study.config import StudyConfig

SINGLE, DIGITS = 1e-6, 7
"""Relative error and significant digits of a property, which is in single precision."""

SHOWN = {name: each for name, each in parameters_of(StudyConfig).items() if each.panel}
"""Parameters shown as one property with the same value; 0 stands for None."""

KINDS = {bool: BoolProperty, int: IntProperty, float: FloatProperty, str: StringProperty}

PROPERTIES = {"patches": "patch_count"}
"""Properties whose name differs from their parameter's."""


def declared(name: str, **other: Any) -> dict[str, Any]:
    """Arguments of the property of a parameter of `StudyConfig`, with these `other` ones; 0 stands for none.

    Where Blender shows the `unit`, the label does not.
    """
    parameter = parameters_of(StudyConfig)[name]
    unit = f" ({parameter.unit})" if parameter.unit and "unit" not in other else ""
    none = "; 0 for none" if parameter.default is None else ""
    about = {
        "name": parameter.title + unit,
        "description": parameter.help.removesuffix(".") + none,
        "default": 0 if parameter.default is None else parameter.default,
        "min": 0 if parameter.is_optional else parameter.least,
        "max": parameter.most,
        "soft_min": parameter.usual[0],
        "soft_max": parameter.usual[1],
    }
    return {key: value for key, value in about.items() if value is not None} | other


def properties(**other: dict[str, Any]) -> dict[str, Any]:
    """A property for each parameter that is shown as one; `other` arguments go by the parameter's name."""
    return {property_of(name): _property(each, other.get(name, {})) for name, each in SHOWN.items()}


def _property(parameter: Parameter, other: dict[str, Any]) -> Any:
    about = declared(parameter.name, **other)
    if get_origin(parameter.kind) is Literal:
        about["items"] = [(value, value.capitalize(), value) for value in get_args(parameter.kind)]
    return (EnumProperty if "items" in about else KINDS[parameter.kinds[0]])(**about)


def property_of(name: str) -> str:
    """The property of a parameter."""
    return PROPERTIES.get(name, name)


def config_shown(study: bpy.types.PropertyGroup, run: StudyConfig) -> StudyConfig:
    """A run's config with the properties that were set; untouched numbers are the run's own."""
    values: dict[str, Any] = {}
    for name, parameter in SHOWN.items():
        if study.is_property_set(property_of(name)):
            value = getattr(study, property_of(name))
            if isinstance(value, float):
                value = as_given(value, parameter.of(run) or 0.0)
            values[name] = (value or None) if parameter.is_optional else value
    return with_values(run, values)


def show_config(study: bpy.types.PropertyGroup, config: StudyConfig) -> None:
    """Let the panel's properties show a config."""
    for name, parameter in SHOWN.items():
        value = parameter.of(config)
        if name == "classifier" and value not in CLASSIFIERS:  # kept, and not to be had here
            continue
        setattr(study, property_of(name), 0 if value is None else value)


def as_given(shown: float, given: float) -> float:
    """A property's value: `given` if it is the same in single precision, else rounded to few digits."""
    return given if abs(shown - given) <= SINGLE * abs(given) else float(f"{shown:.{DIGITS}g}")
