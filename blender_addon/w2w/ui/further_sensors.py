# SPDX-License-Identifier: GPL-3.0-or-later
"""Orientation, magnetometer and barometer in the panel: which are recorded, and which to recognise by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import bpy
from bpy.props import BoolVectorProperty, EnumProperty, FloatProperty

from ..core.imu.further import NOTHING, FurtherSensors
from ..core.imu.recording import FURTHER
from ..core.ranking.utility import inputs_of
from .declared import declared
from .garment_properties import worn_by
from .precision import as_given
from .text import draw_text

Layout = bpy.types.UILayout

TEXTS = {
    "orientation": "Quaternions, as a part with sensor fusion gives them",
    "magnetometer": "The earth's magnetic field, with the dip below",
    "barometer": "The pressure of the air, which tells height",
}
ITEMS = [(name, name.capitalize(), TEXTS[name], 1 << bit) for bit, name in enumerate(FURTHER)]

TICKS = {"record": "recorded", "recognise_by": "recognised_by"}
"""The ticks that show a set of sensors: a click on Blender's own buttons for one lets go of the others."""


def _ticked(name: str) -> Callable[[bpy.types.PropertyGroup], list[bool]]:
    return lambda study: [sensor in getattr(study, name) for sensor in FURTHER]


def _tick(name: str) -> Callable[[bpy.types.PropertyGroup, Sequence[bool]], None]:
    def tick(study: bpy.types.PropertyGroup, ticks: Sequence[bool]) -> None:
        setattr(study, name, {sensor for sensor, on in zip(FURTHER, ticks, strict=True) if on})

    return tick


class FurtherProperties:
    """The part of a study's properties that says what is recorded beside acc and gyr."""

    record: EnumProperty(
        **declared("record", default=set()),
        description="Recorded beside accelerometer and gyroscope",
        items=ITEMS,
        options={"ENUM_FLAG"},
    )
    recognise_by: EnumProperty(
        **declared("recognise_by", default=set()),
        description="Activities are recognised by these, too, of those that are recorded",
        items=ITEMS,
        options={"ENUM_FLAG"},
    )
    recorded: BoolVectorProperty(
        name="Record",
        description="Recorded beside accelerometer and gyroscope: orientation as quaternions, as a part with "
        "sensor fusion gives them; the earth's magnetic field; the air's pressure, which tells height",
        size=len(FURTHER),
        get=_ticked("record"),
        set=_tick("record"),
    )
    recognised_by: BoolVectorProperty(
        name="Recognise By",
        description="Activities are recognised by this, too",
        size=len(FURTHER),
        get=_ticked("recognise_by"),
        set=_tick("recognise_by"),
    )
    magnetic_dip: FloatProperty(
        **declared("magnetic_dip"),
        description="Angle of the earth's magnetic field below the horizontal, for the magnetometer",
        precision=1,
    )


def further_of(study: bpy.types.PropertyGroup, run: FurtherSensors, dressed: bool) -> FurtherSensors:
    """What is recorded beside acc and gyr as core takes it; errors of the parts are those of the run opened.

    Parameters
    ----------
    study : PropertyGroup
    run : FurtherSensors
        Of the run that the study was opened from, else nothing.
    dressed : bool
        Whether garments carry sensors, which record acc and gyr alone.
    """
    record, by = (
        set(_value(study, *pair)) for pair in (("record", run.record), ("recognise_by", run.features))
    )
    if dressed or not record:
        return NOTHING
    by = by & record if inputs_of(study.classifier) == "features" else set()
    return replace(
        run,
        record=_in_order(record, run.record),
        features=_in_order(by, run.features),
        dip_deg=as_given(_value(study, "magnetic_dip", run.dip_deg), run.dip_deg),
    )


def keep_further(study: bpy.types.PropertyGroup, further: FurtherSensors) -> None:
    """Show in the panel what a run recorded."""
    study.record, study.recognise_by = set(further.record), set(further.features)
    study.magnetic_dip = further.dip_deg


def further_text(study: bpy.types.PropertyGroup) -> str:
    """What signals and features depend on; empty where nothing is recorded beside acc and gyr."""
    if not study.record:
        return ""
    record, by = (
        ",".join(name for name in FURTHER if name in chosen) for chosen in (study.record, study.recognise_by)
    )
    return f" record={record} by={by} dip={study.magnetic_dip:g}"


def draw_further(study: bpy.types.PropertyGroup, context: bpy.types.Context, layout: Layout) -> None:
    """Draw the choice, and where it comes to nothing."""
    _draw_ticks(study, layout, "record", set(FURTHER))
    if not study.record:
        return
    if worn_by(study):
        draw_text(layout, context, "Sensors on garments record accelerometer and gyroscope alone")
        return
    if "magnetometer" in study.record:
        layout.prop(study, "magnetic_dip")
    if inputs_of(study.classifier) != "features":
        draw_text(layout, context, f"{study.classifier} learns from accelerometer and gyroscope alone")
        return
    _draw_ticks(study, layout, "recognise_by", study.record)


def _draw_ticks(study: bpy.types.PropertyGroup, layout: Layout, name: str, offered: set[str]) -> None:
    """Draw a tick for each of the sensors that are offered."""
    ticks = TICKS[name]
    column = layout.column(heading=study.bl_rna.properties[ticks].name)
    for index, (sensor, text, *_) in enumerate(ITEMS):
        if sensor in offered:
            column.prop(study, ticks, index=index, text=text)


def _value(study: bpy.types.PropertyGroup, name: str, given: Any) -> Any:
    """A property's value; that of the run opened where the panel has not set it."""
    return getattr(study, name) if study.is_property_set(name) else given


def _in_order(chosen: set[str], run: tuple[str, ...]) -> tuple[str, ...]:
    """In the run's own order where it is the same choice: features follow it."""
    return run if chosen == set(run) else tuple(name for name in FURTHER if name in chosen)
