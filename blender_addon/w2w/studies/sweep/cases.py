# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sweep changes: the motion, the body, the sensor and how it is worn, the windows, one at a time."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from math import radians

from w2w.core.body.skeleton import JOINT_NAMES
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import STANDARD_GRAVITY
from w2w.core.motion.motion import Motion
from w2w.core.study.config import StudyConfig

from .augmentation import at_tempo, scaled

TEMPI = (0.75, 1.25, 1.5)
NARROW = 0.5
"""Width of one side's movements, where the two sides differ."""

BODIES: dict[str, dict[str, float]] = {
    "female": {"gender": -1.0},
    "male": {"gender": 1.0},
    "short": {"height": 1.55},
    "tall": {"height": 1.90},
    "heavy": {"weight": 90.0},
}
SENSORS = ("ideal", "bmi270", "mpu-6050", "phone")
WINDOWS_S = (1.0, 2.0, 4.0)
RATES_HZ = (25.0, 50.0, 100.0, 200.0)

RANGES = ((2, 250), (4, 500), (8, 1000), (16, 2000))
"""Full scale of the accelerometer, g, and of the gyroscope, degrees a second, as parts pair them."""

MOUNTINGS = ((5, 5), (10, 10), (20, 20))
"""Turn on the skin, degrees about each axis, and shift along it, mm; both one standard deviation."""

TISSUES_HZ = (5.0, 10.0, 20.0)
TISSUE_GAIN = 0.5
"""Soft tissue under the sensor: its natural frequency, and the part of the motion that goes through it."""

USUAL = "as run"


@dataclass(frozen=True)
class Case:
    """One map of a sweep."""

    factor: str  # what is changed; empty in the usual case
    name: str  # to what
    config: StudyConfig
    tempo: float = 1.0  # speed of all motions
    narrow: tuple[str, ...] = ()  # joints that move half as far
    shape: tuple[tuple[str, float], ...] = ()  # parameters of `shapes.shaped`; empty for the study's own body

    @property
    def title(self) -> str:
        """Factor and value in words."""
        return f"{self.factor}: {self.name}" if self.factor else self.name

    def motion(self, motion: Motion) -> Motion:
        """The motion as this case has it."""
        if self.narrow:
            motion = scaled(motion, NARROW, self.narrow)
        return at_tempo(motion, self.tempo) if self.tempo != 1.0 else motion


def cases(config: StudyConfig, factors: Collection[str]) -> list[Case]:
    """The usual case, then those of each factor.

    `config`: of the study.
    `factors`: of `FACTORS`.
    Raises ValueError if a factor is unknown.
    """
    unknown = sorted(set(factors) - set(FACTORS))
    if unknown:
        raise ValueError(f"'{unknown[0]}' cannot be swept; there are {', '.join(FACTORS)}")
    found = [Case("", USUAL, config)]
    for factor in factors:
        found += FACTORS[factor](config)
    return found


def _tempi(config: StudyConfig) -> list[Case]:
    return [Case("tempo", f"{tempo:g} x", config, tempo=tempo) for tempo in TEMPI]


def _asymmetries(config: StudyConfig) -> list[Case]:
    return [
        Case(
            "asymmetry",
            f"{side} limbs half as far",
            config,
            narrow=tuple(joint for joint in JOINT_NAMES if joint.startswith(f"{side}_")),
        )
        for side in ("left", "right")
    ]


def _bodies(config: StudyConfig) -> list[Case]:
    return [Case("body", name, config, shape=tuple(shape.items())) for name, shape in BODIES.items()]


def _sensors(config: StudyConfig) -> list[Case]:
    return [Case("sensor", name, replace(config, sensor=name)) for name in SENSORS if name != config.sensor]


def _with_sensor(config: StudyConfig, factor: str, name: str, model: SensorModel) -> Case:
    """A case of the study's sensor altered."""
    model = replace(model, name=f"{config.sensor}, {factor} {name}")
    return Case(factor, name, replace(config, sensor=model.name, own_sensor=model))


def _rates(config: StudyConfig) -> list[Case]:
    usual = config.synthesis
    return [
        Case("rate", f"{rate:g} Hz", replace(config, synthesis=replace(usual, rate_hz=rate)))
        for rate in RATES_HZ
        if rate != usual.rate_hz
    ]


def _ranges(config: StudyConfig) -> list[Case]:
    usual, found = config.sensor_model(), []
    for g, degrees in RANGES:
        acc = replace(usual.accelerometer, full_scale=g * STANDARD_GRAVITY)
        gyr = replace(usual.gyroscope, full_scale=radians(degrees))
        model = replace(usual, accelerometer=acc, gyroscope=gyr)
        if model != usual:
            found.append(_with_sensor(config, "range", f"{g} g, {degrees} deg/s", model))
    return found


def _mountings(config: StudyConfig) -> list[Case]:
    usual, found = config.sensor_model(), []
    for turn, shift in MOUNTINGS:
        model = replace(usual, mounting_turn_deg=float(turn), mounting_shift_m=shift / 1000)
        if model != usual:
            found.append(_with_sensor(config, "mounting", f"{turn} deg, {shift} mm", model))
    return found


def _tissues(config: StudyConfig) -> list[Case]:
    usual, found = config.sensor_model(), []
    for frequency in TISSUES_HZ:
        model = replace(usual, soft_tissue_hz=frequency, soft_tissue_gain=TISSUE_GAIN)
        if model != usual:
            found.append(_with_sensor(config, "soft tissue", f"{frequency:g} Hz", model))
    return found


def _windows(config: StudyConfig) -> list[Case]:
    usual = config.windows
    share = usual.stride_s / usual.length_s
    return [
        Case(
            "window",
            f"{length:g} s",
            replace(config, windows=replace(usual, length_s=length, stride_s=share * length)),
        )
        for length in WINDOWS_S
        if length != usual.length_s
    ]


FACTORS: dict[str, Callable[[StudyConfig], list[Case]]] = {
    "tempo": _tempi,
    "asymmetry": _asymmetries,
    "body": _bodies,
    "sensor": _sensors,
    "rate": _rates,
    "range": _ranges,
    "mounting": _mountings,
    "soft tissue": _tissues,
    "window": _windows,
}
"""What can be swept."""
