# SPDX-License-Identifier: GPL-3.0-or-later
"""Options made of the parameters that a study's records declare: their help, range, heading and default."""

from __future__ import annotations

from dataclasses import field, make_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import typer

from w2w.core.parameters import Parameter, parameters_of
from w2w.core.study import StudyConfig

NAMES = {"max_places": "--max", "costs": "--cost"}
"""Options with another name than their parameter."""


def declared(name: str, or_none: bool = False, **other: Any) -> Any:
    """The annotation of the option for a parameter that `StudyConfig` or a record in it declares.

    `or_none` allows None for "not given"; `other` arguments of `typer.Option` replace declared ones.
    """
    parameter = parameters_of(StudyConfig)[name]
    kind = _kind(parameter)
    about = {"help": parameter.help, "min": parameter.least, "max": parameter.most}
    about |= {"rich_help_panel": parameter.group or None} | other
    names = (NAMES[name],) if name in NAMES else ()
    return Annotated[kind | None if or_none else kind, typer.Option(*names, **about)]


def _default(name: str) -> Any:
    """An option's default: empty for a list, None for a table."""
    parameter = parameters_of(StudyConfig)[name]
    if parameter.default == ():
        return "" if _kind(parameter) is str else None
    return parameter.default


def _kind(parameter: Parameter) -> Any:
    """The type of an option: words for a list, a file for a table, 0 for no limit."""
    if get_origin(parameter.kind) is tuple:
        return str if get_args(parameter.kind)[0] is str else Path | None
    if get_origin(parameter.kind) is Literal:
        return str
    if type(None) in get_args(parameter.kind) and parameter.default is not None:
        return get_args(parameter.kind)[0]
    return parameter.kind


DeclaredOptions = make_dataclass(
    "DeclaredOptions",
    [
        (name, declared(name), field(default=_default(name)))
        for name, parameter in parameters_of(StudyConfig).items()
        if parameter.group is not None
    ],
    frozen=True,
)
"""An option for every parameter that is not the panel's alone."""

DEFAULTS = DeclaredOptions()
"""The default of each."""
