# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w sensors`: the sensor presets and what sets them apart."""

from __future__ import annotations

from math import degrees

from rich.console import Console
from rich.table import Table

from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import STANDARD_GRAVITY


def sensors() -> None:
    """List the sensor presets: range, noise density and bandwidth of accelerometer and gyroscope."""
    table = Table(
        title=f"Sensor presets ('{DEFAULT_SENSOR}' by default)",
        title_justify="left",
        caption="Bandwidth in Hz, or in per cent of the sample rate where the part's filter follows it.",
        caption_justify="left",
    )
    table.add_column("name")
    for column in (
        "acc range\ng",
        "noise\nug/rtHz",
        "band\nHz",
        "gyr range\ndeg/s",
        "noise\nmdps/rtHz",
        "band\nHz",
    ):
        table.add_column(column, justify="right", no_wrap=True)
    for name, model in PRESETS.items():
        table.add_row(name, *_figures(model))
    Console(highlight=False).print(table)


def _figures(model: SensorModel) -> list[str]:
    acc, gyr = model.accelerometer, model.gyroscope
    return [
        _number(acc.full_scale, 1 / STANDARD_GRAVITY),
        _number(acc.noise_density, 1e6 / STANDARD_GRAVITY),
        _bandwidth(acc.lowpass_hz, acc.lowpass_of_rate),
        _number(gyr.full_scale, degrees(1)),
        _number(gyr.noise_density, 1e3 * degrees(1)),
        _bandwidth(gyr.lowpass_hz, gyr.lowpass_of_rate),
    ]


def _number(value: float | None, factor: float) -> str:
    if not value:
        return "-"
    figure = value * factor
    return f"{figure:.0f}" if figure >= 100 else f"{figure:.3g}"


def _bandwidth(hertz: float | None, of_rate: float | None) -> str:
    if of_rate is not None:
        return f"{of_rate:.0%}".replace("%", " %")
    return _number(hertz, 1)
