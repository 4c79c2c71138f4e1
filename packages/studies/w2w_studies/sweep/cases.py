# SPDX-License-Identifier: GPL-3.0-or-later
"""What a sweep changes: the motion, the body, the sensor and how it is worn, the windows, one at a time."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, replace
from functools import partial

from w2w.core.body.body import JOINT_NAMES
from w2w.core.motion.motion import Motion
from w2w.core.study.config import StudyConfig
from w2w.core.study.variants import FORCE_RANGE, KNOBS, TURN_RANGE, variants, with_model

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


def _of_knob(knob: str, config: StudyConfig) -> list[Case]:
    return [Case(knob, variant.name, variant.config) for variant in variants(config, knob)]


def _ranges(config: StudyConfig) -> list[Case]:
    found = []
    for g, degrees in RANGES:
        both = KNOBS[TURN_RANGE].altered(KNOBS[FORCE_RANGE].altered(config, g), degrees)
        if (
            max(abs(KNOBS[knob].own(both) - KNOBS[knob].own(config)) for knob in (FORCE_RANGE, TURN_RANGE))
            > 1e-3
        ):
            found.append(Case("range", f"{g} g, {degrees} deg/s", both))
    return found


def _mountings(config: StudyConfig) -> list[Case]:
    usual, found = config.sensor_model(), []
    for turn, shift in MOUNTINGS:
        model = replace(usual, mounting_turn_deg=float(turn), mounting_shift_m=shift / 1000)
        if model != usual:
            found.append(Case("mounting", f"{turn} deg, {shift} mm", with_model(config, model)))
    return found


def _tissues(config: StudyConfig) -> list[Case]:
    usual, found = config.sensor_model(), []
    for frequency in TISSUES_HZ:
        model = replace(usual, soft_tissue_hz=frequency, soft_tissue_gain=TISSUE_GAIN)
        if model != usual:
            found.append(Case("soft tissue", f"{frequency:g} Hz", with_model(config, model)))
    return found


FACTORS: dict[str, Callable[[StudyConfig], list[Case]]] = {
    "tempo": _tempi,
    "asymmetry": _asymmetries,
    "body": _bodies,
    "sensor": _sensors,
    "range": _ranges,
    "mounting": _mountings,
    "soft tissue": _tissues,
    **{knob: partial(_of_knob, knob) for knob in KNOBS},
}
"""What can be swept."""
