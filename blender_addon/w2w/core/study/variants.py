# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's config with another part: slower, shorter in range, coarser, noisier, without a sensor."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf, log2, radians
from typing import NamedTuple

from ..imu.sensor import SensorModel, Triad
from ..imu.synthesis import STANDARD_GRAVITY
from .config import StudyConfig

FINEST_HZ = 200.0
"""Rate at which a part sees the motion before it takes its own samples, at least."""

RATE, FORCE_RANGE, TURN_RANGE = "rate", "accelerometer range", "gyroscope range"
BITS, NOISE, ALONE, WINDOW = "resolution", "noise", "alone", "window"

USUAL_RANGES = (16 * STANDARD_GRAVITY, radians(2000.0))
"""Ranges that a word length is of in a part without any, m/s2 and rad/s."""

ABSENT = Triad(resolution=1e9)
"""A sensor that is left out: no reading is half a step, so all are 0."""

ACCELEROMETER, GYROSCOPE = 0.0, 1.0
"""Values of `ALONE`: the sensor that is kept."""


@dataclass(frozen=True)
class Variant:
    """A study with one thing of its part at another value."""

    knob: str  # of `KNOBS`
    value: float
    config: StudyConfig

    @property
    def name(self) -> str:
        """The value with its unit."""
        return KNOBS[self.knob].text(self.value)


class Knob(NamedTuple):
    """What can be changed of a part."""

    values: tuple[float, ...]  # from dear to cheap
    own: Callable[[StudyConfig], float]
    altered: Callable[[StudyConfig, float], StudyConfig]
    text: Callable[[float], str]

    def dearer(self, first: float, second: float) -> bool:
        """Whether the first value is the dearer one."""
        return (first - second) * (self.values[0] - self.values[-1]) > 0


def variants(config: StudyConfig, knob: str, values: Sequence[float] = ()) -> list[Variant]:
    """The config at each of some values but its own, from dear to cheap, by default at all usual ones."""
    one = KNOBS[knob]
    values = [value for value in values or one.values if abs(value - one.own(config)) > 1e-3]
    return [Variant(knob, value, one.altered(config, value)) for value in values]


def at_rate(config: StudyConfig, rate: float) -> StudyConfig:
    """The config with a part that samples at a rate, through its own filter alone: the rest folds back."""
    synthesis = replace(config.synthesis, rate_hz=max(FINEST_HZ, rate, config.synthesis.rate_hz))
    return _with(replace(config, synthesis=synthesis), rate_hz=rate)


def own_rate(config: StudyConfig) -> float:
    """Samples a second of a study's sensor."""
    return config.sensor_model().rate_hz or config.synthesis.rate_hz


def with_model(config: StudyConfig, model: SensorModel) -> StudyConfig:
    """The config with a sensor model of the study's own, named after the study's sensor."""
    model = replace(model, name=f"{config.sensor.removesuffix(ALTERED)}{ALTERED}")
    return replace(config, sensor=model.name, own_sensor=model)


ALTERED = ", altered"


def _with(config: StudyConfig, **changes: object) -> StudyConfig:
    return with_model(config, replace(config.sensor_model(), **changes))  # type: ignore[arg-type]


def _range_of(name: str, unit: float) -> tuple[Callable[[StudyConfig], float], Callable[..., StudyConfig]]:
    """A triad's range in some unit, and how it is changed: its words stay as long."""

    def own(config: StudyConfig) -> float:
        return (getattr(config.sensor_model(), name).full_scale or inf) / unit

    def altered(config: StudyConfig, value: float) -> StudyConfig:
        triad: Triad = getattr(config.sensor_model(), name)
        step = triad.resolution * (value * unit / triad.full_scale if triad.full_scale else 1.0)
        return _with(config, **{name: replace(triad, full_scale=value * unit, resolution=step)})

    return own, altered


def _of_bits(config: StudyConfig, bits: float) -> StudyConfig:
    model = config.sensor_model()
    worded = [
        replace(
            triad, full_scale=triad.full_scale or usual, resolution=2 * (triad.full_scale or usual) / 2**bits
        )
        for triad, usual in zip((model.accelerometer, model.gyroscope), USUAL_RANGES, strict=True)
    ]
    return _with(config, accelerometer=worded[0], gyroscope=worded[1])


def _own_bits(config: StudyConfig) -> float:
    triad = config.sensor_model().accelerometer
    return log2(2 * triad.full_scale / triad.resolution) if triad.full_scale and triad.resolution else inf


def _own_noise(config: StudyConfig) -> float:
    return 1.0 if config.sensor_model().accelerometer.noise_density else inf


def _noisier(config: StudyConfig, factor: float) -> StudyConfig:
    model = config.sensor_model()
    acc, gyr = (
        replace(triad, noise_density=factor * triad.noise_density)
        for triad in (model.accelerometer, model.gyroscope)
    )
    return _with(config, accelerometer=acc, gyroscope=gyr)


def _alone(config: StudyConfig, kept: float) -> StudyConfig:
    return _with(config, **{"gyroscope" if kept == ACCELEROMETER else "accelerometer": ABSENT})


def _windowed(config: StudyConfig, length: float) -> StudyConfig:
    usual = config.windows
    stride = usual.stride_s / usual.length_s * length
    return replace(config, windows=replace(usual, length_s=length, stride_s=stride))


KNOBS = {
    RATE: Knob((200, 100, 50, 25, 20, 10, 5), own_rate, at_rate, "{:g} Hz".format),
    FORCE_RANGE: Knob((16, 8, 4, 2), *_range_of("accelerometer", STANDARD_GRAVITY), "±{:g} g".format),
    TURN_RANGE: Knob((2000, 1000, 500, 250, 125), *_range_of("gyroscope", radians(1.0)), "±{:g} °/s".format),
    BITS: Knob((16, 12, 10, 8, 6, 4), _own_bits, _of_bits, "{:.3g} bit".format),
    NOISE: Knob((1, 3, 10, 30, 100), _own_noise, _noisier, "{:g} ×".format),
    ALONE: Knob(
        (ACCELEROMETER, GYROSCOPE),
        lambda _: inf,
        _alone,
        lambda kept: "gyroscope alone" if kept else "accelerometer alone",
    ),
    WINDOW: Knob((4, 2, 1, 0.5), lambda config: config.windows.length_s, _windowed, "{:g} s".format),
}
"""What can be changed of a part, by name, in units that datasheets use: Hz, g, degrees a second, bits."""
