# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of how signals are made: the user's own sensor, the bands, and further sensors.

The part is kept whole, as the text of a file that `w2w run --sensor` reads; its fields read and write that.
"""

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

import bpy
from bpy.props import BoolVectorProperty, EnumProperty, FloatProperty, StringProperty

from ...core.imu.presets import DEFAULT_SENSOR, PRESETS, preset, sensor_content, sensor_from
from ...core.imu.recording import FURTHER
from ...core.imu.sensor import SensorModel
from ...core.imu.sensor_fields import FIGURES
from ...core.imu.virtual import NOTHING, FurtherSensors
from ...core.ranking.utility import inputs_of
from .declared import as_given, declared

OWN = "OWN"
"""Choice of the menu of sensors that is no preset."""

FIRST_NAME = "own part"

TEXTS = {
    "orientation": "Quaternions, as a part with sensor fusion gives them",
    "magnetometer": "The earth's magnetic field, with the dip below",
    "barometer": "The pressure of the air, which tells height",
}
ITEMS = [(name, name.capitalize(), TEXTS[name], 1 << bit) for bit, name in enumerate(FURTHER)]

TICKS = {"record": "recorded", "recognise_by": "recognised_by"}
"""Tick boxes for a set of sensors: Blender's own enum buttons would clear the other flags on a click."""


def own_sensor(study: bpy.types.PropertyGroup) -> SensorModel:
    """The user's own sensor; until it is edited, a copy of the default preset."""
    return _read(study.own_sensor_text)


def keep_own_sensor(study: bpy.types.PropertyGroup, model: SensorModel) -> None:
    """Make a sensor the user's own."""
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


def _ticks(name: str, title: str, about: str) -> Any:
    """Tick boxes that show and change a set of further sensors."""

    def get(study: bpy.types.PropertyGroup) -> list[bool]:
        return [sensor in getattr(study, name) for sensor in FURTHER]

    def tick(study: bpy.types.PropertyGroup, ticks: Sequence[bool]) -> None:
        setattr(study, name, {sensor for sensor, on in zip(FURTHER, ticks, strict=True) if on})

    return BoolVectorProperty(name=title, description=about, size=len(FURTHER), get=get, set=tick)


class FigureProperties:
    """The figures of the own part."""

    __annotations__ = {name: _figure(name) for name in FIGURES}


class SensorProperties(FigureProperties):
    """The part of a study's properties that says how signals are made."""

    own_sensor_text: StringProperty(options={"HIDDEN"})
    own_sensor_name: StringProperty(
        name="Name", description="What you call your part", get=_name, set=_rename
    )
    record: EnumProperty(**declared("record", default=set()), items=ITEMS, options={"ENUM_FLAG"})
    recognise_by: EnumProperty(**declared("recognise_by", default=set()), items=ITEMS, options={"ENUM_FLAG"})
    recorded: _ticks(
        "record",
        "Record",
        "Recorded besides accelerometer and gyroscope: orientation as quaternions, as a part with "
        "sensor fusion gives them; the earth's magnetic field; the air's pressure, which tells height",
    )
    recognised_by: _ticks("recognise_by", "Recognise By", "Activities are recognised by this, too")
    magnetic_dip: FloatProperty(**declared("magnetic_dip"), precision=1)


def further_of(study: bpy.types.PropertyGroup, run: FurtherSensors, dressed: bool) -> FurtherSensors:
    """`FurtherSensors` of the study; errors of the parts are those of the run opened.

    `dressed` is whether cloth carries the sensors: these record acc and gyr alone.
    """
    shown: dict[str, Any] = {
        "record": set(run.record),
        "recognise_by": set(run.features),
        "magnetic_dip": run.dip_deg,
    }
    shown |= {name: getattr(study, name) for name in shown if study.is_property_set(name)}
    record, by = shown["record"], shown["recognise_by"]
    if dressed or not record:
        return NOTHING
    by = by & record if inputs_of(study.classifier) == "features" else set()
    return run.of(record, by, as_given(shown["magnetic_dip"], run.dip_deg))
