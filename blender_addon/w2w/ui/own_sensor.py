# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of how signals are made: a part of one's own, the bands and the convention.

The part is kept whole, as the text of a file that `w2w run --sensor` reads; its fields read and write that.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache
from typing import Any

import bpy
from bpy.props import EnumProperty, FloatProperty, StringProperty

from ..core.imu.presets import DEFAULT_SENSOR, PRESETS, preset
from ..core.imu.sensor import SensorModel
from ..core.imu.sensor_fields import FIGURES
from ..core.imu.sensor_file import sensor_content, sensor_from
from ..core.imu.synthesis import CONVENTIONS
from .declared import declared

OWN = "OWN"
"""Choice of the menu of sensors that is no preset."""

FIRST_NAME = "own part"

CONVENTION_TEXTS = {
    "physical": ("Physical", "Specific force and angular velocity, both in the sensor's frame"),
    "paper": ("Paper", "The equations as the paper prints them, for comparison only"),
}
CONVENTION_ITEMS = tuple((name, *CONVENTION_TEXTS[name]) for name in CONVENTIONS)


def own_sensor(study: bpy.types.PropertyGroup) -> SensorModel:
    """The part of one's own; before anything is said of it, the default part's figures."""
    return _read(study.own_sensor_text)


def keep_own_sensor(study: bpy.types.PropertyGroup, model: SensorModel) -> None:
    """Make a sensor the part of one's own."""
    name = FIRST_NAME if model.name in PRESETS else model.name
    study.own_sensor_text = json.dumps(sensor_content(replace(model, name=name)))


@lru_cache(maxsize=16)
def _read(text: str) -> SensorModel:
    if not text:
        return replace(preset(DEFAULT_SENSOR), name=FIRST_NAME)
    return sensor_from(json.loads(text), FIRST_NAME)


def _name(study: bpy.types.PropertyGroup) -> str:
    return own_sensor(study).name


def _rename(study: bpy.types.PropertyGroup, name: str) -> None:
    plain = "".join(letter for letter in name.strip()[:60] if letter.isprintable())
    keep_own_sensor(study, replace(own_sensor(study), name=plain or FIRST_NAME))


def _figure(name: str) -> Any:
    """A field that shows a figure of the own part, in a datasheet's unit."""
    figure = FIGURES[name]

    def get(study: bpy.types.PropertyGroup) -> float:
        return figure.of(own_sensor(study))

    def given(study: bpy.types.PropertyGroup, value: float) -> None:
        value = min(max(value, 0.0), figure.most)
        keep_own_sensor(study, figure.given(own_sensor(study), value))

    return FloatProperty(
        name=figure.label, description=figure.about, get=get, set=given, min=0, max=figure.most, precision=3
    )


class OwnSensor:
    """The part of a study's properties that says how signals are made."""

    own_sensor_text: StringProperty(options={"HIDDEN"})
    own_sensor_name: StringProperty(
        name="Name", description="What you call your part", get=_name, set=_rename
    )
    acc_range: _figure("acc_range")
    acc_noise: _figure("acc_noise")
    acc_bias: _figure("acc_bias")
    acc_drift: _figure("acc_drift")
    gyr_range: _figure("gyr_range")
    gyr_noise: _figure("gyr_noise")
    gyr_bias: _figure("gyr_bias")
    gyr_drift: _figure("gyr_drift")
    misalignment: _figure("misalignment")
    band: FloatProperty(
        **declared("band"),
        description="Band limit of the paths; 0 for none. Raise it for clean motion capture",
        precision=1,
    )
    root_band: FloatProperty(
        **declared("root_band", min=0),
        description="Band limit of the root's path: about 3 for inertial suits; 0 for none",
        precision=1,
    )
    convention: EnumProperty(
        name="Convention",
        description="How specific force and angular velocity are defined",
        items=CONVENTION_ITEMS,
    )
