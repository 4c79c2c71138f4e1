# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensor and Bands, under Signals: the figures of an own part, its file, and the bands."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, StringProperty
from bpy_extras.io_utils import ExportHelper

from ...core.given import file_name
from ...core.imu.presets import preset, read_sensor, write_sensor
from ...core.imu.recording import FURTHER
from ...core.imu.synthesis import FOLDED_BACK
from ...core.ranking.utility import inputs_of
from ...core.wording import capital, restated
from ..jobs import jobs
from ..jobs.text import draw_text, styled
from ..study import covers, operators, sensors, state
from .base import Layout, PartPanel, draw_parameters, draw_warning, form
from .properties import SENSORS


class W2W_OT_start_sensor(operators.OnBody, bpy.types.Operator):
    """Take the figures of a preset for a part of your own, to alter them"""

    bl_label = "Start from Preset"

    like: EnumProperty(name="Preset", description="Whose figures to take", items=SENSORS[:-1])

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        sensors.keep_own_sensor(body.w2w, preset(self.like))
        body.w2w.sensor = sensors.OWN


class W2W_OT_load_sensor(operators.AsksForFile, operators.OnBody, bpy.types.Operator):
    """Read a part of your own from a file (json), as w2w run --sensor takes it"""

    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> str:
        path = self.path()
        with restated(lambda error: f"{path.name} cannot be read: {error.strerror or error}", OSError):
            sensors.keep_own_sensor(body.w2w, read_sensor(path))
        body.w2w.sensor = sensors.OWN
        return f"Read the sensor {sensors.own_sensor(body.w2w).name} from {path.name}"


class W2W_OT_save_sensor(operators.OnBody, bpy.types.Operator, ExportHelper):
    """Save your part as a file (json) that w2w run --sensor reads"""

    bl_options = {"REGISTER"}
    filename_ext = ".json"
    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.filepath = f"{file_name(sensors.own_sensor(state.polled_body(context).w2w).name)}.json"
        return super().invoke(context, event)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> str:
        path = Path(bpy.path.abspath(self.filepath))
        with restated(lambda error: f"{path.name} cannot be written: {error.strerror or error}", OSError):
            write_sensor(path, sensors.own_sensor(body.w2w))
        return f"Saved {path.name}"


class W2W_PT_sensor(PartPanel, bpy.types.Panel):
    """Bands, further sensors and the figures of a part."""

    def draw(self, context: bpy.types.Context) -> None:
        study = state.polled_body(context).w2w
        layout = styled(form(self.layout), enabled=jobs.running is None)
        draw_parameters(layout, study, "bands")
        if not study.band:
            draw_warning(layout, context, f"{capital(FOLDED_BACK)}.")
        draw_further(study, context, layout)
        if study.sensor == sensors.OWN:
            layout.prop(study, "own_sensor_name")
            for title, kind in (("Accelerometer", "acc"), ("Gyroscope", "gyr")):
                # names with their units are too long for a split row
                column = styled(layout.column(align=True), use_property_split=False)
                column.label(text=title, translate=False)
                for field in ("range", "noise", "bias", "drift"):
                    column.prop(study, f"{kind}_{field}")
            layout.prop(study, "misalignment")
        else:
            draw_text(layout, context, "For a part of your own, start from a preset or load a file")
        column = layout.column(align=True)
        column.operator_menu_enum("w2w.start_sensor", "like", text="Start from Preset", translate=False)
        row = column.row(align=True)
        row.operator("w2w.load_sensor", text="Load", translate=False, icon="FILE_FOLDER")
        row.operator("w2w.save_sensor", text="Save", translate=False, icon="EXPORT")


def draw_further(study: bpy.types.PropertyGroup, context: bpy.types.Context, layout: Layout) -> None:
    """Draw the choice, or why it has no effect."""
    _draw_ticks(study, layout, "record", set(FURTHER))
    if not study.record:
        return
    if covers.worn_by(study):
        draw_text(layout, context, "Sensors on cloth record accelerometer and gyroscope alone")
        return
    if "magnetometer" in study.record:
        layout.prop(study, "magnetic_dip")
    if inputs_of(study.classifier) != "features":
        draw_text(layout, context, f"{study.classifier} learns from accelerometer and gyroscope alone")
        return
    _draw_ticks(study, layout, "recognise_by", study.record)


def _draw_ticks(study: bpy.types.PropertyGroup, layout: Layout, name: str, offered: set[str]) -> None:
    """Draw a tick for each of the sensors that are offered."""
    ticks = sensors.TICKS[name]
    column = layout.column(heading=study.bl_rna.properties[ticks].name)
    for index, (sensor, text, *_) in enumerate(sensors.ITEMS):
        if sensor in offered:
            column.prop(study, ticks, index=index, text=text, translate=False)
