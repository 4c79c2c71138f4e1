# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's parameters and the order of its steps, from a motion to a recommendation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from numbers import Integral, Real
from typing import Any

import numpy as np

from .body.body import Body
from .imu.augmentation import Augmentation
from .imu.copies import record_copies
from .imu.further import NOTHING, FurtherSensors, further_signals
from .imu.presets import DEFAULT_SENSOR, preset
from .imu.recording import ImuRecording
from .imu.sensor import SensorModel
from .imu.sensor_file import sensor_of_plain
from .imu.synthesis import Synthesis, synthesize
from .imu.virtual import record_motion
from .imu.worn import Worn
from .motion.duplicates import POSES, mirrored_signatures, move_alike
from .motion.motion import Motion
from .motion.variants import low_passed, smoothed_root
from .patches.own_placements import with_placements
from .patches.patches import DEFAULT_PATCHES, PatchSet, sample_patches
from .ranking.features import window_features
from .ranking.further_features import further_features
from .ranking.same_motion import same_motion_groups
from .ranking.utility import inputs_of
from .ranking.windows import WindowSpec, cut_windows
from .selection.constraints import Constraints

SAME_MOTION = 0.1
"""Signatures nearer than this may show one motion: real downloads at other rates, or in place, are."""


@dataclass(frozen=True)
class StudyConfig:
    """Every parameter of a study; the same config and clips give the same bytes.

    Parameters
    ----------
    patches : int
        Patches on the body.
    placements : tuple of (str, int or tuple of 3 floats)
        Placements of one's own beside the sampled patches, as for `with_placements`.
    garments : tuple of str
        What is worn, the outer first: sensors of the patches that it covers are on it, not on the skin.
    synthesis : Synthesis
        How ideal signals are made; its `rate_hz` is the sensor's rate.
    sensor : str
        Name of a sensor preset (`presets.preset`), "ideal", or the name of `own_sensor`.
    own_sensor : SensorModel or None
        A sensor of one's own (`sensor_file.read_sensor`); counts where `sensor` is its name.
    root_band_hz : float or None
        Band limit of the root's path, Hz, for motions whose suit did not measure it (`smoothed_root`).
    further : FurtherSensors
        What is recorded beside acc and gyr, and recognised by; nothing by default.
    windows : WindowSpec
    augmentation : Augmentation or None
        Copies of every clip to train on.
    classifier : str
        Name in `utility.CLASSIFIERS`.
    folds : int
        Folds of the cross-validation by clip.
    by_subject : bool
        Leave one subject out at a time instead.
    background : tuple of str
        Activities that are trained against and count in no mean.
    weights : tuple of (str, float)
        What activities count in the mean; 1 for the others.
    target : float
        Expected F1 that the patches worn together shall reach.
    every_activity : float
        Expected F1 that the sensors worn together shall reach for each activity that counts; 0 for none.
    max_places : int or None
        Most patches in that set.
    constraints : Constraints
        Where sensors may and must go, and what they cost there.
    seed : int
        Every random draw comes from it.
    title : str
        The project's name, for people.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.
    """

    patches: int = DEFAULT_PATCHES
    placements: tuple[tuple[str, int | tuple[float, ...]], ...] = ()
    garments: tuple[str, ...] = ()
    synthesis: Synthesis = field(default_factory=Synthesis)
    sensor: str = DEFAULT_SENSOR
    own_sensor: SensorModel | None = None
    root_band_hz: float | None = None
    further: FurtherSensors = NOTHING
    windows: WindowSpec = field(default_factory=WindowSpec)
    augmentation: Augmentation | None = None
    classifier: str = "ridge"
    folds: int = 5
    by_subject: bool = False
    background: tuple[str, ...] = ()
    weights: tuple[tuple[str, float], ...] = ()
    target: float = 0.90
    every_activity: float = 0.0
    max_places: int | None = None
    constraints: Constraints = field(default_factory=Constraints)
    seed: int = 0
    title: str = ""

    def __post_init__(self) -> None:
        if not 0 < self.target <= 1:
            raise ValueError(f"target must be an F1 above 0 and at most 1, not {self.target}")
        if not 0 <= self.every_activity <= 1:
            raise ValueError(f"every_activity must be an F1 from 0 to 1, not {self.every_activity}")
        for name, weight in self.weights:
            if not (isinstance(weight, Real) and np.isfinite(weight) and weight >= 0):
                raise ValueError(f"the weight of {name!r} must be 0 or more, not {weight}")
        if not (isinstance(self.folds, Integral) and self.folds >= 2):
            raise ValueError(f"folds must be a whole number from 2 on, not {self.folds!r}")
        if self.max_places is not None and not (
            isinstance(self.max_places, Integral) and self.max_places > 0
        ):
            raise ValueError(f"the most sensors must be a whole number from 1 on, not {self.max_places!r}")
        inputs = inputs_of(self.classifier)
        if self.root_band_hz is not None and not self.root_band_hz > 0:
            raise ValueError(f"root_band_hz must be positive, or None for none, not {self.root_band_hz}")
        if self.further.features and inputs == "windows":
            names = ", ".join(self.further.features)
            raise ValueError(f"{self.classifier} learns from acc and gyr alone, not from {names}")
        if self.garments and self.further != NOTHING:
            raise ValueError("a garment's sensors are accelerometer and gyroscope alone: leave others out")
        self.sensor_model()

    def sensor_model(self) -> SensorModel:
        """The sensor model that `sensor` names."""
        if self.own_sensor is not None and self.own_sensor.name == self.sensor:
            return self.own_sensor
        return preset(self.sensor)

    def signal_parameters(self) -> dict[str, Any]:
        """The parameters that signals and features depend on; the others only rank and choose."""
        names = ("patches", "synthesis", "root_band_hz", "windows", "seed")
        chosen = {name: plain(getattr(self, name)) for name in names}
        chosen |= {"sensor_model": plain(self.sensor_model())}
        for name in ("placements", "garments"):
            if getattr(self, name):
                chosen |= {name: plain(getattr(self, name))}
        if self.further != NOTHING:
            chosen |= {"further": plain(self.further)}
        if self.augmentation is not None:
            chosen |= {"augmentation": plain(self.augmentation), "keep_copies": self.keeps_copies()}
        return chosen

    def keeps_copies(self) -> bool:
        """Whether the recordings of augmented copies are needed beside their features."""
        return self.augmentation is not None and inputs_of(self.classifier) == "windows"

    def as_dict(self) -> dict[str, Any]:
        """Every parameter as plain values, the sensor's own ones spelled out."""
        values = {**plain(self), "sensor_model": plain(self.sensor_model())}
        if self.further == NOTHING:
            del values["further"]
        return values

    @classmethod
    def from_dict(cls, parameters: Mapping[str, Any]) -> StudyConfig:
        """The config that `as_dict` gave; what an earlier version did not know takes its default."""
        given = {**plain(cls()), **parameters}
        given = {item.name: given[item.name] for item in fields(cls)}
        given["synthesis"] = Synthesis(
            **given["synthesis"] | {"gravity": tuple(given["synthesis"]["gravity"])}
        )
        given["windows"] = WindowSpec(**given["windows"])
        names = {name: tuple(given["further"][name]) for name in ("record", "features")}
        given["further"] = FurtherSensors(**given["further"] | names)
        wishes = {name: tuple(given["constraints"][name]) for name in ("only", "forbid", "must")}
        costs = tuple((words, cost) for words, cost in given["constraints"]["costs"])
        given["constraints"] = Constraints(**wishes, costs=costs)
        given["background"] = tuple(given["background"])
        given["garments"] = tuple(given["garments"])
        given["weights"] = tuple((name, weight) for name, weight in given["weights"])
        given["placements"] = tuple(
            (name, tuple(where) if isinstance(where, list) else where) for name, where in given["placements"]
        )
        if given["own_sensor"] is not None:
            given["own_sensor"] = sensor_of_plain(given["own_sensor"])
        if given["augmentation"] is not None:
            given["augmentation"] = Augmentation(**given["augmentation"])
        return cls(**given)


def plain(value: Any) -> Any:
    """Dataclasses, tuples and numpy numbers as what JSON knows."""
    if is_dataclass(value):
        return {item.name: plain(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, list | tuple | np.ndarray):
        return [plain(item) for item in value]
    return value


def place_patches(body: Body, config: StudyConfig) -> PatchSet:
    """The study's patches on its body, and its own placements after them.

    Raises
    ------
    ValueError
        If a placement cannot be: the message says why.
    """
    patches = sample_patches(body, config.patches, config.seed)
    return with_placements(body, patches, dict(config.placements)) if config.placements else patches


def record(
    body: Body, patches: PatchSet, motion: Motion, config: StudyConfig, worn: Worn | None = None
) -> ImuRecording:
    """What sensors on all patches would record of one motion; of those that garments carry, as they moved.

    Raises
    ------
    ValueError
        If the motion is too short for the synthesis.
    """
    motion = measured(motion, config)
    if worn is None:
        return record_motion(
            body, patches, motion, config.synthesis, config.sensor_model(), config.seed, config.further
        )
    ideal = record_motion(body, patches, motion, config.synthesis)
    return config.sensor_model().apply(worn.over(ideal, config.synthesis), seed=config.seed)


def measured(motion: Motion, config: StudyConfig) -> Motion:
    """The motion with its root's path band-limited, where the config asks for it and the frames hold more."""
    if config.root_band_hz is None or config.root_band_hz >= motion.rate / 2:
        return motion
    return smoothed_root(motion, config.root_band_hz)


def copies_of(body: Body, patches: PatchSet, motion: Motion, config: StudyConfig) -> Iterator[ImuRecording]:
    """Recordings of the augmented copies of a motion that the config asks for: none, or as many as it says.

    Raises
    ------
    ValueError
        If copies on other bodies are asked for and the body is not W2W's own.
    """
    if config.augmentation is not None:
        motion = measured(motion, config)
        yield from record_copies(
            body, patches, motion, config.augmentation, config.synthesis, config.sensor_model(), config.seed,
            config.further,
        )  # fmt: skip


def record_baked(
    matrices: np.ndarray,
    rate: float,
    patches: PatchSet,
    labels: tuple[str, str, str],
    config: StudyConfig,
    root: np.ndarray | None = None,
    worn: Worn | None = None,
) -> ImuRecording:
    """What sensors on all patches would record of a surface that Blender has moved.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 4, 4)
        World matrices of the patches.
    rate : float
        Frames per second.
    patches : PatchSet
    labels : tuple of str
        Activity, subject and clip.
    config : StudyConfig
    root : ndarray, shape (T, 3), optional
        Path of the body's root in the world, without which it cannot be band-limited.
    worn : Worn, optional
        The sensors that garments carry.

    Raises
    ------
    ValueError
        If the motion is too short for the synthesis, or the root's path is to be band-limited and not known.
    """
    if config.root_band_hz is not None and config.root_band_hz < rate / 2:
        if root is None or worn is not None:
            raise ValueError("its root cannot be told from its surface: set the root band to 0")
        matrices = matrices.copy()
        matrices[..., :3, 3] += (low_passed(root, rate, config.root_band_hz) - root)[:, None]
    ideal = synthesize(matrices, rate, config.synthesis)
    if worn is not None:
        ideal = worn.over(ideal, config.synthesis)
    named = ImuRecording(ideal.acc, ideal.gyr, ideal.rate, patches.names, *labels)
    sensor = config.sensor_model()
    others = further_signals(
        matrices, rate, config.synthesis, sensor, config.further, named.clip, config.seed
    )
    return replace(sensor.apply(named, seed=config.seed), **others)


def describe(recording: ImuRecording, config: StudyConfig) -> tuple[np.ndarray, np.ndarray]:
    """Windows of a recording as features.

    Returns
    -------
    features : ndarray, shape (W, N, D), float32
    is_test : ndarray, shape (W,), bool
        Windows that do not overlap and may be tested on.

    Raises
    ------
    TooShortError
        If the recording is too short to give one window.
    """
    windows = cut_windows(recording, config.windows)
    features = window_features(windows.signals, recording.rate)
    if config.further.features:
        others = further_features(recording, config.windows, config.further.features)
        features = np.concatenate([features, others], axis=2)
    return features, windows.is_test


def same_clips(names: Sequence[str], keys: Sequence[str], signatures: Sequence[np.ndarray]) -> np.ndarray:
    """Which clips show one motion, by their keys or moving alike, mirrored or not; shape (C,), int."""
    return same_motion_groups(names, keys, signatures, SAME_MOTION, mirrored_signatures, move_alike, POSES)
