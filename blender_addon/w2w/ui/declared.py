# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties made of the parameters that a study's records declare: their label, default and limits."""

from __future__ import annotations

from typing import Any

from ..core.parameters import parameters_of
from ..core.study import StudyConfig


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
    about = {
        "name": label,
        "default": 0 if parameter.default is None else parameter.default,
        "min": parameter.least,
        "max": parameter.most,
        "soft_min": parameter.usual[0],
        "soft_max": parameter.usual[1],
    }
    return {key: value for key, value in about.items() if value is not None} | other
