# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w sensors`: the sensor presets and what sets them apart, or all figures of one sensor."""

from dataclasses import fields
from math import degrees
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table
from rich.text import Text

from ...core.imu.presets import DEFAULT_SENSOR, PRESETS, write_sensor
from ...core.imu.sensor import SensorModel, Triad
from ...core.imu.sensor_fields import TRIADS, WHOLE
from ...core.imu.synthesis import STANDARD_GRAVITY
from ...core.study.config import plain
from ...core.wording import clean
from ..console import NOTHING_TO_DO, USAGE, console_beside, ending, print_json
from ..options import AsJson, argument, option, read_or_preset
from ..runs.own_files import new_file


def sensors(
    sensor: Annotated[
        str, argument("[SENSOR]", "A preset, or a JSON file of your own part, to see whole.")
    ] = "",
    out: Annotated[
        Path | None,
        option("Write SENSOR as a JSON file, to alter and give to `run --sensor`.", "--out", "-o"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the sensor presets: range, noise density and bandwidth of accelerometer and gyroscope.

    With SENSOR, every figure of that one: a check of a file of your own.

    Exit codes: 0 shown, 1 --out cannot be written, 2 no such preset, or a file that is wrong (and why).
    """
    console = console_beside(as_json)
    if not sensor and out is None:
        console.print(_presets())
        if as_json:
            print_json({name: plain(model) for name, model in PRESETS.items()})
        return
    with ending(USAGE, console):
        if not sensor:
            raise ValueError("--out writes one sensor: name it, as w2w sensors bmi270 --out mine.json")
        model = read_or_preset(sensor)
        new_file(out)
    console.print(_whole(model))
    if as_json:
        print_json(plain(model))
    if out is None:
        return
    try:
        write_sensor(out, model)
    except OSError as error:
        console.print(f"{clean(out)} cannot be written: {error.strerror or error}", style="red")
        raise typer.Exit(NOTHING_TO_DO) from error
    console.print(f"Written: {clean(out)}. Change its name and figures, and give it to --sensor.")


def _presets() -> Table:
    triads = {name: (model.accelerometer, model.gyroscope) for name, model in PRESETS.items()}
    drifting = [
        name for name in triads if any(axis.bias_instability or axis.random_walk for axis in triads[name])
    ]
    worn = [f"{name} ({how})" for name, model in PRESETS.items() if (how := _worn(model))]
    table = Table(
        title=f"Sensor presets ('{DEFAULT_SENSOR}' by default)",
        title_justify="left",
        caption=(
            "Bandwidth in Hz, or in per cent of the sample rate where the part's filter follows it.\n"
            f"With drift: {', '.join(drifting)}.\n"
            f"Turned, on tissue or with losses: {', '.join(worn)}.\n"
            "All figures of one: w2w sensors NAME. A file of your own part: docs/sensors.md."
        ),
        caption_justify="left",
    )
    table.add_column("name", no_wrap=True)
    for column in (
        "acc range\ng", "noise\nug/rtHz", "band\nHz",
        "gyr range\ndeg/s", "noise\nmdps/rtHz", "band\nHz",
    ):  # fmt: skip
        table.add_column(column, justify="right", no_wrap=True)
    for name, (acc, gyr) in triads.items():
        table.add_row(
            name,
            _number(acc.full_scale, 1 / STANDARD_GRAVITY),
            _number(acc.noise_density, 1e6 / STANDARD_GRAVITY),
            _bandwidth(acc.lowpass_hz, acc.lowpass_of_rate),
            _number(gyr.full_scale, degrees(1)),
            _number(gyr.noise_density, 1e3 * degrees(1)),
            _bandwidth(gyr.lowpass_hz, gyr.lowpass_of_rate),
        )
    return table


def _worn(model: SensorModel) -> str:
    parts = (
        f"{model.mounting_turn_deg:g} deg, another turn in every clip" if model.mounting_turn_deg else "",
        f"{model.fixed_misalignment_deg:g} deg, fixed" if model.fixed_misalignment_deg else "",
        f"tissue {model.soft_tissue_hz:g} Hz" if model.soft_tissue_hz else "",
        f"{model.drop_fraction:.1%} lost".replace("%", " %") if model.drop_fraction else "",
    )
    return ", ".join(part for part in parts if part)


def _whole(model: SensorModel) -> Table:
    """Every field of a sensor, by the names of its file."""
    table = Table(title=model.name, title_justify="left")
    for column in ("field", "accelerometer", "unit", "gyroscope", "unit"):
        table.add_column(column, justify="right" if column in TRIADS else "left", no_wrap=True)
    for item in fields(Triad):
        cells = []
        for kind, quantities in TRIADS.items():
            cells += [_plain(getattr(getattr(model, kind), item.name)), quantities[item.name].unit]
        table.add_row(item.name, *cells)
    table.add_section()
    table.add_row("", Text("both", style="bold"))
    for field, quantity in WHOLE.items():
        table.add_row(field, _plain(getattr(model, field)), quantity.unit)
    table.add_row("worn_turn_deg", " ".join(_plain(angle) for angle in model.worn_turn_deg), "deg")
    table.add_row("zero_phase", "yes" if model.zero_phase else "no")
    return table


def _plain(value: float | None) -> str:
    return "none" if value is None else f"{value:.6g}"


def _number(value: float | None, factor: float) -> str:
    if not value:
        return "-"
    figure = value * factor
    return f"{figure:.0f}" if figure >= 100 else f"{figure:.3g}"


def _bandwidth(hertz: float | None, of_rate: float | None) -> str:
    if of_rate is not None:
        return f"{of_rate:.0%}".replace("%", " %")
    return _number(hertz, 1)
