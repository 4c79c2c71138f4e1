# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of an own part that a form asks for, in a datasheet's units; ranges are those of its file."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from .quantities import Quantity
from .sensor import SensorModel
from .sensor_fields import TRIADS, WHOLE

DIGITS = 6
"""Digits that a figure keeps: a form may hold it in single precision."""


class Figure(NamedTuple):
    """One figure.

    Attributes
    ----------
    kind : {"accelerometer", "gyroscope", ""}
        Which triad it is of; empty for the whole sensor.
    field : str
        Its name in the sensor's file.
    unit : str
        The unit that datasheets print it in.
    label, about : str
        For people.
    """

    kind: str
    field: str
    unit: str
    label: str
    about: str

    @property
    def quantity(self) -> Quantity:
        """What the file allows."""
        return (TRIADS[self.kind] if self.kind else WHOLE)[self.field]

    @property
    def size(self) -> float:
        """One of its unit in the model's."""
        return self.quantity.units[self.unit]

    @property
    def most(self) -> float:
        """The highest value, in its unit."""
        return self.quantity.most / self.size

    def of(self, model: SensorModel) -> float:
        """The figure of a sensor, in its unit; 0 where it is switched off."""
        held = getattr(getattr(model, self.kind) if self.kind else model, self.field)
        return 0.0 if held is None else held / self.size

    def given(self, model: SensorModel, value: float) -> SensorModel:
        """The sensor with another figure, in its unit; 0 switches it off.

        Raises
        ------
        ValueError
            If it is out of range.
        """
        plain = float(f"{value:.{DIGITS}g}") * self.size
        if value <= self.most:  # rounding may not carry it out of its range
            plain = min(plain, self.quantity.most)
        held = self.quantity.read(None if not plain and self.quantity.may_be_off else plain, self.label)
        if not self.kind:
            return replace(model, **{self.field: held})
        return replace(model, **{self.kind: replace(getattr(model, self.kind), **{self.field: held})})


FIGURES: dict[str, Figure] = {
    "acc_range": Figure(
        "accelerometer", "full_scale", "g", "Range (g)", "Readings are clipped to this; 0 for no limit"
    ),
    "acc_noise": Figure(
        "accelerometer", "noise_density", "ug/sqrt(Hz)", "Noise (µg/√Hz)", "Density of the white noise"
    ),
    "acc_bias": Figure(
        "accelerometer", "turn_on_bias", "mg", "Bias (mg)",
        "Constant bias of each axis, anew in every clip (one standard deviation)",
    ),
    "acc_drift": Figure(
        "accelerometer", "bias_instability", "ug", "Drift (µg)", "Bias instability of the Allan plot"
    ),
    "gyr_range": Figure(
        "gyroscope", "full_scale", "deg/s", "Range (°/s)", "Readings are clipped to this; 0 for no limit"
    ),
    "gyr_noise": Figure(
        "gyroscope", "noise_density", "mdps/sqrt(Hz)", "Noise (mdps/√Hz)", "Density of the white noise"
    ),
    "gyr_bias": Figure(
        "gyroscope", "turn_on_bias", "deg/s", "Bias (°/s)",
        "Constant bias of each axis, anew in every clip (one standard deviation)",
    ),
    "gyr_drift": Figure(
        "gyroscope", "bias_instability", "deg/h", "Drift (°/h)", "Bias instability of the Allan plot"
    ),
    "misalignment": Figure(
        "", "fixed_misalignment_deg", "deg", "Misalignment (°)",
        "How far the sensor is turned against its place, the same in every clip (one standard deviation)",
    ),
}  # fmt: skip
"""By the names of a form's fields."""
