# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties made from the parameters that `StudyConfig` declares, and numbers as the user gave them."""

from dataclasses import replace
from typing import Any, get_args

import bpy

from ...core.parameters import Parameter, parameters_of
from ...core.ranking.utility import CLASSIFIERS
from ...core.study.config import StudyConfig

SINGLE, DIGITS = 1e-6, 7
"""Relative error and significant digits of a property, which is in single precision."""

SHOWN = (
    "patches", "rate", "band", "root_band", "classifier", "folds", "by_subject", "target", "every_activity",
    "max_places", "seed",
)  # fmt: skip
"""Parameters shown as one property with the same value; 0 stands for None."""

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
        "min": 0 if _is_optional(parameter) else parameter.least,
        "max": parameter.most,
        "soft_min": parameter.usual[0],
        "soft_max": parameter.usual[1],
    }
    return {key: value for key, value in about.items() if value is not None} | other


def config_values(study: bpy.types.PropertyGroup, run: StudyConfig) -> dict[str, Any]:
    """Fields of a config from the properties that were set; untouched numbers are the run's own."""
    fields: dict[str, Any] = {}
    for name in SHOWN:
        parameter, shown = parameters_of(StudyConfig)[name], PROPERTIES.get(name, name)
        if not study.is_property_set(shown):
            continue
        value = getattr(study, shown)
        if isinstance(value, float):
            value = as_given(value, parameter.of(run) or 0.0)
        if _is_optional(parameter):
            value = value or None
        *inside, field = parameter.path
        (fields.setdefault(inside[0], {}) if inside else fields)[field] = value
    return {
        name: replace(getattr(run, name), **value) if isinstance(value, dict) else value
        for name, value in fields.items()
    }


def show_config(study: bpy.types.PropertyGroup, config: StudyConfig) -> None:
    """Let the panel's properties show a config."""
    for name in SHOWN:
        value = parameters_of(StudyConfig)[name].of(config)
        if name == "classifier" and value not in CLASSIFIERS:  # kept, and not to be had here
            continue
        setattr(study, PROPERTIES.get(name, name), 0 if value is None else value)


def _is_optional(parameter: Parameter) -> bool:
    return type(None) in get_args(parameter.kind)


def as_given(shown: float, given: float) -> float:
    """A property's value: `given` if it is the same in single precision, else rounded to few digits."""
    return given if abs(shown - given) <= SINGLE * abs(given) else float(f"{shown:.{DIGITS}g}")
