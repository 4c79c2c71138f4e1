# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's parameters and the order of its steps, from a motion to a recommendation."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, is_dataclass, replace
from numbers import Real
from typing import Any, Self

import numpy as np

from .body.body import Body
from .garments.on_cloth import ClothSensors
from .imu.further import NOTHING, FurtherSensors, further_signals
from .imu.presets import DEFAULT_SENSOR, preset
from .imu.recording import ImuRecording
from .imu.sensor import SensorModel
from .imu.synthesis import Synthesis, synthesize
from .imu.virtual import record_motion
from .motion.motion import Motion, low_passed, smoothed_root
from .parameters import parameter, parameters_of, read_record
from .patches.own_placements import with_placements
from .patches.patches import DEFAULT_PATCHES, PatchSet, sample_patches
from .ranking.utility import inputs_of
from .selection.constraints import Constraints
from .windows.features import further_features, window_features
from .windows.windows import WindowSpec, cut_windows

SIGNALS, RANKING, FILES = "Signals", "Ranking", "Bodies and files"
WISHES = "Design constraints"
"""Headings of the options that few people need."""

NOT_IN_SIGNALS = ("classifier", "folds", "by_subject", "background", "weights", "target", "every_activity")
NOT_IN_SIGNALS += ("max_places", "constraints", "title")  # what only ranks, chooses and tells
NOT_IN_SIGNALS += ("patches", "placements", "sensor", "own_sensor")  # said by the patches, and by the model


@dataclass(frozen=True)
class StudyConfig:
    """Every parameter of a study; the same config and clips give the same bytes.

    Each parameter's meaning, unit, range and option stand in its declaration.

    Raises
    ------
    ValueError
        If a value is out of range; the message names it.
    """

    patches: int = parameter(
        DEFAULT_PATCHES,
        "Number of patches on the body that are compared.",
        title="Patches", least=2, most=6890, usual=(None, 1024),
    )  # fmt: skip
    placements: tuple[tuple[str, int | str | tuple[float, ...]], ...] = parameter(
        (),
        "Spots of your own beside them: csv with columns name and vertex, spot, or x, y, z (metres "
        "on the body at rest, z up, soles at z = 0).",
        group=FILES,
    )
    garments: tuple[str, ...] = parameter(
        (),
        "Experimental. What is worn: tshirt, trousers, or FILE.blend:OBJECT, one of yours that follows "
        "W2W's body there; several comma-separated, the outer first. Patches that it covers are then on "
        "the cloth, which Blender simulates: minutes a clip.",
        "garment",
    )
    synthesis: Synthesis = field(default_factory=Synthesis)
    sensor: str = parameter(
        DEFAULT_SENSOR,
        "Sensor preset (see `w2w sensors`), 'ideal' for no errors, or a JSON file of your own part.",
        title="Sensor",
    )
    own_sensor: SensorModel | None = None  # counts where `sensor` is its name
    root_band_hz: float | None = parameter(
        None,
        "Band limit of the root's path, Hz: about 3 for inertial suits.",
        "root_band",
        title="Root Band", unit="Hz", least=0.1, most=1000, usual=(None, 20), group=SIGNALS,
    )  # fmt: skip
    further: FurtherSensors = NOTHING
    windows: WindowSpec = field(default_factory=WindowSpec)
    classifier: str = parameter(
        "ridge",
        "Classifier for each patch: ridge (seconds), and with W2W from pip trees (minutes) and multi3net "
        "(needs PyTorch).",
        title="Classifier",
    )
    folds: int = parameter(
        5,
        "Cross-validation folds; a clip is never split between them.",
        title="Folds", least=2, most=1000, usual=(None, 20), group=RANKING,
    )  # fmt: skip
    by_subject: bool = parameter(
        False,
        "Leave one subject out at a time instead of folds: test on people that were not trained on. "
        "Every clip needs its subject's name.",
        title="By Subject",
    )
    background: tuple[str, ...] = parameter(
        (),
        "Activities to train against but not to count in the mean, comma-separated: 'walking,sitting'.",
        group=WISHES,
    )
    weights: tuple[tuple[str, float], ...] = parameter(
        (),
        "csv with columns activity, weight: what activities count in the mean (1 for the others).",
        group=WISHES,
    )
    target: float = parameter(
        0.90,
        "F1 that the set of sensors should reach: expected on other clips of those worn together.",
        title="Target F1", least=0.01, most=1,
    )  # fmt: skip
    every_activity: float = parameter(
        0.0,
        "Expected F1 that sensors worn together should reach for every activity, beside the mean; 0 asks "
        "for none.",
        title="Every Activity", least=0, most=1, group=WISHES,
    )  # fmt: skip
    max_places: int | None = parameter(None, "Maximum number of sensors.", title="At Most", least=1)
    constraints: Constraints = field(default_factory=Constraints)
    seed: int = parameter(0, "Random seed: every random draw comes from it.", title="Noise Seed", least=0)
    title: str = parameter("", "Project name for the report.")

    def __post_init__(self) -> None:
        for declared in parameters_of(type(self)).values():
            declared.check(self)
        for name, weight in self.weights:
            if not (isinstance(weight, Real) and np.isfinite(weight) and weight >= 0):
                raise ValueError(f"the weight of {name!r} must be 0 or more, not {weight}")
        if self.further.features and inputs_of(self.classifier) == "windows":
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
        """The parameters that signals and features depend on beside the body and its patches.

        A new field counts unless `NOT_IN_SIGNALS` names it.
        """
        return {name: value for name, value in self.as_dict().items() if name not in NOT_IN_SIGNALS}

    def as_dict(self) -> dict[str, Any]:
        """Every parameter as plain values, the sensor's own ones spelled out."""
        values = {**plain(self), "sensor_model": plain(self.sensor_model())}
        if self.further == NOTHING:
            del values["further"]
        return values

    @classmethod
    def from_dict(cls, parameters: Mapping[str, Any]) -> Self:
        """The config that `as_dict` gave; what is not given takes its default.

        Raises
        ------
        ValueError
            If a key is unknown, or a value of the wrong kind or out of range; the message says which.
        """
        known = {name: value for name, value in parameters.items() if name != "sensor_model"}  # derived
        return read_record(cls, known)


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
    body: Body,
    patches: PatchSet,
    motion: Motion,
    config: StudyConfig,
    on_cloth: ClothSensors | None = None,
    chosen: Sequence[int] | None = None,
) -> ImuRecording:
    """Recording of sensors on all patches, or the `chosen`, through one motion.

    `on_cloth` says how all those on garments move. ValueError if the motion is too short for the synthesis.
    """
    motion, sensor = measured(motion, config), config.sensor_model()
    if on_cloth is None:
        return record_motion(
            body, patches, motion, config.synthesis, sensor, config.seed, config.further, chosen
        )
    ideal = record_motion(body, patches, motion, config.synthesis)
    return sensor.apply(on_cloth.over(ideal, config.synthesis), seed=config.seed)


def measured(motion: Motion, config: StudyConfig) -> Motion:
    """The motion with its root's path band-limited, where the config asks for it and the frames hold more."""
    if config.root_band_hz is None or config.root_band_hz >= motion.rate / 2:
        return motion
    return smoothed_root(motion, config.root_band_hz)


def record_baked(
    matrices: np.ndarray,
    rate: float,
    patches: PatchSet,
    labels: tuple[str, str, str],
    config: StudyConfig,
    root: np.ndarray | None = None,
    on_cloth: ClothSensors | None = None,
    first_sensor: int = 0,
) -> ImuRecording:
    """Recording of sensors on all patches of a surface that Blender has moved.

    `matrices`, shape (T, N, 4, 4), are the patches' in the world, `labels` activity, subject and clip.
    `first_sensor` is the number of the first where the patches are the last of a larger set. `root`, shape
    (T, 3), is the path of the body's root in the world. ValueError if it is to be band-limited and not known,
    or if the motion is too short for the synthesis.
    """
    if config.root_band_hz is not None and config.root_band_hz < rate / 2:
        if root is None or on_cloth is not None:
            raise ValueError("its root cannot be told from its surface: set the root band to 0")
        matrices = matrices.copy()
        matrices[..., :3, 3] += (low_passed(root, rate, config.root_band_hz) - root)[:, None]
    ideal = synthesize(matrices, rate, config.synthesis)
    if on_cloth is not None:
        ideal = on_cloth.over(ideal, config.synthesis)
    named = ImuRecording(ideal.acc, ideal.gyr, ideal.rate, patches.names, *labels)
    sensor = config.sensor_model()
    others = further_signals(
        matrices, rate, config.synthesis, sensor, config.further, named.clip, config.seed, first_sensor
    )
    further: dict[str, Any] = {**others}
    return replace(sensor.apply(named, config.seed, first_sensor), **further)


def describe(recording: ImuRecording, config: StudyConfig) -> tuple[np.ndarray, np.ndarray]:
    """Windows of a recording as features, shape (W, N, D), float32, and which may be tested on, shape (W,).

    Windows to test on do not overlap. TooShortError if the recording does not fill one window.
    """
    windows = cut_windows(recording, config.windows)
    features = window_features(windows.signals, recording.rate)
    if config.further.features:
        others = further_features(recording, config.windows, config.further.features)
        features = np.concatenate([features, others], axis=2)
    return features, windows.is_test
