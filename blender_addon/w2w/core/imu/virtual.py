# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors all over a moving body: their recordings, part by part, and readings besides those of an IMU.

These are orientation, magnetometer and barometer.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from scipy.spatial.transform import Rotation

from ..blas import multiply
from ..body.body import Body
from ..filtering import count_resampled
from ..motion.motion import Motion
from ..motion.skinning import posed_patches, skinning_transforms
from ..parameters import parameter
from ..patches.naming import place
from ..patches.own_placements import patches_at
from ..patches.patches import PatchSet
from ..rotations import decompose
from ..threads import chunks
from ..wording import plain_words
from .errors import SensorStreams
from .recording import FURTHER, ImuRecording
from .sensor import SensorModel
from .synthesis import CHUNK_SENSORS, Poses, Synthesis, synthesize
from .trajectory import bridge, spline_windows

ORIENTATION, MAGNETOMETER, BAROMETER = FURTHER

SEA_LEVEL_PA = 101_325.0
LAPSE_PER_M = 0.0065 / 288.15
PRESSURE_EXPONENT = 9.80665 * 0.0289644 / (8.3144598 * 0.0065)
"""International Standard Atmosphere up to 11 km: 15 degrees C at the sea, 6.5 degrees less each kilometre."""

MOST_UT = 100.0
"""The earth's own field has 22 to 67 microtesla."""


@dataclass(frozen=True)
class FurtherSensors:
    """Readings besides specific force and angular velocity, and their errors.

    Random constants are drawn for every sensor and clip, Gaussian, with the given value as their
    standard deviation. A part without errors (`SensorModel.is_ideal`) has none here either.

    The earth's magnetic field is by default that of Central Europe (IGRF-14 for 2025 at 50 degrees N, 10 E);
    the direction of north is drawn for every clip.
    """

    record: tuple[str, ...] = parameter(
        (),
        f"Record these besides acc and gyr, comma-separated: {', '.join(FURTHER)}.",
        title="Record", group="Signals",
    )  # fmt: skip
    features: tuple[str, ...] = parameter(
        (),
        "Recognise activities by these, too, of those that are recorded.",
        "recognise_by",
        title="Recognise By", group="Signals",
    )  # fmt: skip
    dip_deg: float = parameter(
        66.8,
        "Angle of the earth's magnetic field below the horizontal, degrees, for the magnetometer.",
        "magnetic_dip",
        title="Magnetic Dip", unit="°", least=-90, most=90, group="Signals",
    )  # fmt: skip
    field_ut: float = 49.4  # strength of the earth's field, microtesla
    tilt_deg: float = 0.5  # error of the orientation about the horizontal axes
    heading_deg: float = 1.0  # error of the orientation about the vertical
    magnetometer_noise_ut: float = 0.19  # standard deviation of a sample's noise, microtesla
    hard_iron_ut: float = 2.0  # offset of each axis that calibration leaves, microtesla
    # error of each entry of the matrix by which magnetised parts nearby bend the field
    soft_iron: float = 0.02
    altitude_m: float = 0.0  # of the floor above the sea
    pressure_noise_pa: float = 1.0  # standard deviation of a sample's noise
    pressure_offset_pa: float = 50.0  # offset of a sensor
    # standard deviation of the pressure at sea level, the same for all sensors of a clip
    weather_pa: float = 700.0

    def __post_init__(self) -> None:
        for name in (*self.record, *self.features):
            if name not in FURTHER:
                raise ValueError(f"besides acc and gyr there are {', '.join(FURTHER)}, not {name!r}")
        missing = [name for name in self.features if name not in self.record]
        if missing:
            raise ValueError(f"{', '.join(missing)} must be recorded to recognise activities by")
        if not (abs(self.dip_deg) <= 90 and 0 <= self.field_ut <= MOST_UT):
            raise ValueError(
                f"the earth's magnetic field dips by -90 to 90 degrees and has 0 to {MOST_UT:g} microtesla, "
                f"not {self.dip_deg}, {self.field_ut}"
            )

    def of(self, record: set[str], features: set[str], dip_deg: float) -> Self:
        """The same errors with other sensors; if they are the same, they keep their order."""

        def in_order(chosen: set[str], before: tuple[str, ...]) -> tuple[str, ...]:
            return before if chosen == set(before) else tuple(name for name in FURTHER if name in chosen)

        by = in_order(features, self.features)
        return replace(self, record=in_order(record, self.record), features=by, dip_deg=dip_deg)

    @property
    def sample_bytes(self) -> int:
        """Bytes of a sample of one sensor."""
        return 4 * sum(FURTHER[name] for name in self.record)


NOTHING = FurtherSensors()


def further_signals(
    poses: Poses,
    rate: float,
    settings: Synthesis,
    sensor: SensorModel,
    further: FurtherSensors,
    clip: str,
    seed: int,
    sensors: Sequence[int] | None = None,
) -> dict[str, np.ndarray]:
    """Readings of these sensors on moving frames that also carry `sensor`: (samples, N, values), float32.

    Orientation comes as quaternions w, x, y, z from the sensor's frame to the clip's world; the magnetic
    field in the sensor's frame, microtesla; pressure, Pa. They share the mounting, misalignment and losses of
    `sensor`, and the rate and band limit of `settings`. Poses are (T, N, 4, 4), at `rate` frames per second;
    `sensors` are their numbers, if they are a part of a larger set.

    Raises ValueError if the sensor has a rate of its own.
    """
    if not further.record:
        return {}
    if sensor.rate_hz not in (None, settings.rate_hz):
        raise ValueError(f"{', '.join(further.record)} cannot be recorded at a rate of the sensor's own")
    n_frames, n_sensors = poses.shape[:2]
    n_samples = count_resampled(n_frames, rate, settings.rate_hz)
    signals = {name: np.empty((n_samples, n_sensors, FURTHER[name]), np.float32) for name in further.record}
    numbers = range(n_sensors) if sensors is None else sensors
    for part in chunks(n_sensors, CHUNK_SENSORS):
        streams = SensorStreams(seed, clip, numbers[part])
        turned, heights = _placed(poses[:, part], rate, settings, sensor, streams)
        for name, values in signals.items():
            values[:, part] = _READ[name](turned, heights, further, streams, sensor.is_ideal)
        by_sensor = [values[:, part].transpose(1, 2, 0) for values in signals.values()]
        sensor.lose(by_sensor, settings.rate_hz, streams)
    return signals


def north_of(clip: str, seed: int) -> float:
    """Turn about the vertical from y of the clip's world to magnetic north, rad: people face any way."""
    return float(_of_clip(clip, seed, "north").uniform(-np.pi, np.pi))


def _of_clip(clip: str, seed: int, what: str) -> np.random.Generator:
    digest = hashlib.sha256(f"{seed}\0{clip}\0{what}".encode()).digest()
    return np.random.default_rng(np.frombuffer(digest[:16], dtype="<u4"))


def _placed(
    poses: np.ndarray, rate: float, settings: Synthesis, sensor: SensorModel, streams: SensorStreams
) -> tuple[Rotation, np.ndarray]:
    """Turns from sensor to world, sample by sample and sensor by sensor, and heights (samples, n)."""
    first = streams.sensors[0]
    positions, quaternions = decompose(poses, first)
    bridge(positions, quaternions, rate, settings.max_gap_s, first)
    n_samples = count_resampled(poses.shape[0], rate, settings.rate_hz)
    paths = np.concatenate([quaternions, positions[2:]])
    sampled = np.empty((5, n_samples, poses.shape[1]))
    for window in spline_windows(poses.shape[0], rate, settings.rate_hz, settings.band_hz):
        sampled[:, window.samples] = multiply(window.operators[0], paths[:, window.frames].astype(np.float32))
    turned = Rotation.from_quat(sampled[[1, 2, 3, 0]].transpose(1, 2, 0).reshape(-1, 4))
    heights = sampled[4]
    for shifts, turns in sensor.sits(streams):
        if shifts.any():
            heights = heights + turned.apply(np.tile(shifts, (n_samples, 1)))[:, 2].reshape(heights.shape)
        turned = turned * _each_sample(turns, n_samples)
    return turned, heights


def _each_sample(turns: np.ndarray, n_samples: int) -> Rotation:
    return Rotation.from_rotvec(np.tile(turns, (n_samples, 1)))


def _own(streams: SensorStreams, name: str) -> SensorStreams:
    """Separate random streams, so that the draws of acc and gyr stay as they were."""
    return streams.of_clip(f"{streams.clip}\0{name}")


def _orientation(
    turned: Rotation, heights: np.ndarray, further: FurtherSensors, streams: SensorStreams, ideal: bool
) -> np.ndarray:
    if not ideal:
        drawn = _own(streams, ORIENTATION).normal("constants", 3)
        wrong = np.radians([further.tilt_deg, further.tilt_deg, further.heading_deg]) * drawn
        turned = _each_sample(wrong, len(heights)) * turned
    quaternions = turned.as_quat()[:, [3, 0, 1, 2]].reshape(*heights.shape, 4)
    flips = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=2))
    quaternions[1:] *= np.cumprod(np.where(flips < 0, -1, 1), axis=0)[..., None]
    return quaternions


def _magnetometer(
    turned: Rotation, heights: np.ndarray, further: FurtherSensors, streams: SensorStreams, ideal: bool
) -> np.ndarray:
    dip = np.radians(further.dip_deg)
    to_north = further.field_ut * np.array([0, np.cos(dip), -np.sin(dip)])
    field = Rotation.from_rotvec([0, 0, north_of(streams.clip, streams.seed)]).apply(to_north)
    read = turned.inv().apply(field).reshape(*heights.shape, 3)
    if ideal:
        return read
    own = _own(streams, MAGNETOMETER)
    drawn = own.normal("constants", 12)
    iron = np.eye(3) + further.soft_iron * drawn[:, 3:].reshape(-1, 3, 3)
    noise = own.normal("acc noise", 3, len(heights)).transpose(2, 0, 1)
    read = np.einsum("nij,tnj->tni", iron, read) + further.hard_iron_ut * drawn[:, :3]
    return read + further.magnetometer_noise_ut * noise


def _barometer(
    _turned: Rotation, heights: np.ndarray, further: FurtherSensors, streams: SensorStreams, ideal: bool
) -> np.ndarray:
    above_sea = further.altitude_m + heights
    if ideal:
        return pressure_at(above_sea)[..., None]
    weather = further.weather_pa * _of_clip(streams.clip, streams.seed, "weather").normal()
    own = _own(streams, BAROMETER)
    offset = further.pressure_offset_pa * own.normal("constants", 1)[:, 0]
    noise = further.pressure_noise_pa * own.normal("acc noise", len(heights)).T
    return (pressure_at(above_sea, SEA_LEVEL_PA + weather) + offset + noise)[..., None]


def pressure_at(height: np.ndarray, sea_level: float = SEA_LEVEL_PA) -> np.ndarray:
    """Pressure of the standard atmosphere, Pa, at heights above the sea, m."""
    return sea_level * (1 - LAPSE_PER_M * np.asarray(height)) ** PRESSURE_EXPONENT


_READ = {ORIENTATION: _orientation, MAGNETOMETER: _magnetometer, BAROMETER: _barometer}


AS_DEFAULT = Synthesis()
IDEAL = SensorModel.ideal()

SENSORS_AT_ONCE = 256
BYTES_AT_ONCE = 48 * 2**20
"""Sensors, at most, and bytes of the ideal signals that are kept until the sensor model has run."""


def record_motion(
    body: Body,
    patches: PatchSet,
    motion: Motion,
    settings: Synthesis = AS_DEFAULT,
    sensor: SensorModel = IDEAL,
    seed: int = 0,
    further: FurtherSensors = NOTHING,
    chosen: Sequence[int] | None = None,
) -> ImuRecording:
    """Recording of a sensor on every patch, or the `chosen`, in memory bounded by the recording itself.

    The same as `synthesize` on `patch_matrices` and `SensorModel.apply` on the whole, to rounding; named
    after the patches and labelled as the motion. `seed` is that of the sensors' errors.
    """
    numbers = range(len(patches.triangles)) if chosen is None else [int(number) for number in chosen]
    rate = sensor.rate_hz or settings.rate_hz
    n_ideal = count_resampled(motion.n_frames, motion.rate, settings.rate_hz)
    n_samples = count_resampled(n_ideal, settings.rate_hz, rate)
    sizes = {"acc": 3, "gyr": 3} | {name: FURTHER[name] for name in further.record}
    signals: dict[str, Any] = {
        name: np.empty((n_samples, len(numbers), size), np.float32) for name, size in sizes.items()
    }
    transforms = skinning_transforms(body, motion)
    size = max(1, min(SENSORS_AT_ONCE, BYTES_AT_ONCE // (24 * n_ideal)))
    for start in range(0, len(numbers), size):
        part = slice(start, start + size)
        poses = _SkinnedPatches(body, transforms, patches.triangles[list(numbers[part])])
        ideal = replace(synthesize(poses, motion.rate, settings), clip=motion.clip)
        read = sensor.apply(ideal, seed, numbers[part])
        signals["acc"][:, part], signals["gyr"][:, part] = read.acc, read.gyr
        others = further_signals(
            poses, motion.rate, settings, sensor, further, motion.clip, seed, numbers[part]
        )
        for name, values in others.items():
            signals[name][:, part] = values
    names = tuple(patches.names[number] for number in numbers)
    return ImuRecording(rate=rate, **signals).labelled(names, motion.activity, motion.subject, motion.clip)


class _SkinnedPatches:
    """World matrices of patches, made for the patches asked for when they are asked for."""

    def __init__(self, body: Body, transforms: np.ndarray, triangles: np.ndarray) -> None:
        self._body = body
        self._transforms = transforms
        self._triangles = triangles
        self.shape = (len(transforms), len(triangles), 4, 4)

    def __getitem__(self, part: tuple[slice, slice]) -> np.ndarray:
        return posed_patches(self._body, self._triangles[part[1]], self._transforms)


def sensor_at(body: Body, name: str, sample: Callable[[Body], PatchSet]) -> PatchSet:
    """One sensor at a place by its name, or at the patch of a sample that is called so.

    Raises ValueError if neither a place nor a patch is called that.
    """
    try:
        own = patches_at(body, {name: place(name, body)})
        return replace(own, own_names=own.regions)
    except ValueError:
        patches, words = sample(body), plain_words(name)
        called = [patch for patch, own in enumerate(patches.names) if own.lower() == words]
        if not called:
            raise
        return at_patches(patches, called[:1])


def at_patches(patches: PatchSet, chosen: list[int]) -> PatchSet:
    """The patches, of which only the chosen carry sensors."""
    return replace(
        patches,
        vertices=patches.vertices[chosen],
        triangles=patches.triangles[chosen],
        regions=tuple(patches.regions[patch] for patch in chosen),
    )
