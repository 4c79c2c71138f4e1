# SPDX-License-Identifier: GPL-3.0-or-later
"""A study's parameters."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from functools import reduce
from numbers import Real
from typing import Any, Self

import numpy as np

from ..imu.presets import DEFAULT_SENSOR, preset
from ..imu.sensor import SensorModel
from ..imu.synthesis import Synthesis
from ..imu.virtual import NOTHING, FurtherSensors
from ..parameters import parameter, parameters_of, read_record
from ..patches.body_parts import HABIT, product_called
from ..patches.patches import DEFAULT_PATCHES
from ..ranking.utility import inputs_of
from ..selection.constraints import Constraints
from ..windows.windows import WindowSpec

SIGNALS, RANKING, FILES = "Signals", "Ranking", "Bodies and files"
WISHES = "Design constraints"
"""Headings of the options that few people need."""


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
        title="Patches", least=2, most=6890, usual=(None, 1024), stage="", web=True, panel="patches",
    )  # fmt: skip
    placements: tuple[tuple[str, int | str | tuple[float, ...]], ...] = parameter(
        (),
        "Spots of your own in addition: csv with columns name and vertex, spot, or x, y, z (metres "
        "on the body at rest, z up, soles at z = 0).",
        group=FILES,
        stage="",
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
        title="Sensor", stage="", web=True,
    )  # fmt: skip
    own_sensor: SensorModel | None = None  # counts where `sensor` is its name
    root_band_hz: float | None = parameter(
        None,
        "Band limit of the root's path, Hz: about 3 for inertial suits.",
        "root_band",
        title="Root Band", unit="Hz", least=0.1, most=1000, usual=(None, 20), group=SIGNALS, panel="bands",
    )  # fmt: skip
    further: FurtherSensors = NOTHING
    windows: WindowSpec = field(default_factory=WindowSpec)
    classifier: str = parameter(
        "ridge",
        "Classifier for each patch: ridge (seconds), and with W2W from pip trees (minutes) and multi3net "
        "(needs PyTorch).",
        title="Classifier", stage="ranking", panel="ranking",
    )  # fmt: skip
    folds: int = parameter(
        5,
        "Cross-validation folds; a clip is never split between them.",
        title="Folds", least=2, most=1000, usual=(None, 20), group=RANKING, stage="ranking", panel="ranking",
    )  # fmt: skip
    by_subject: bool = parameter(
        False,
        "Leave one subject out at a time instead of folds: test on people that were not trained on. "
        "Every clip needs its subject's name.",
        title="By Subject", stage="ranking", web=True, panel="ranking",
    )  # fmt: skip
    background: tuple[str, ...] = parameter(
        (),
        "Activities to train against but not to count in the mean, comma-separated: 'walking,sitting'.",
        group=WISHES, stage="choice", web=True,
    )  # fmt: skip
    weights: tuple[tuple[str, float], ...] = parameter(
        (),
        "csv with columns activity, weight: what activities count in the mean (1 for the others).",
        group=WISHES, stage="choice",
    )  # fmt: skip
    target: float = parameter(
        0.90,
        "F1 that the set of sensors should reach: expected on other clips of those worn together.",
        title="Target F1", least=0.01, most=1, stage="choice", web=True, panel="choice",
    )  # fmt: skip
    every_activity: float = parameter(
        0.0,
        "Expected F1 that sensors worn together should reach for every activity, besides the mean; 0 asks "
        "for none.",
        title="Every Activity", least=0, most=1, group=WISHES, stage="choice", web=True, panel="choice",
    )  # fmt: skip
    max_places: int | None = parameter(
        None, "Maximum number of sensors.", title="At Most", least=1, stage="choice", web=True, panel="choice"
    )
    constraints: Constraints = field(default_factory=Constraints)
    habit: str = parameter(
        HABIT,
        "Product that people wear anyway: the answer keeps it unless another does better.",
        title="Habit", stage="choice", web=True, panel="choice",
    )  # fmt: skip
    seed: int = parameter(
        0,
        "Random seed: every random draw comes from it.",
        title="Noise Seed", least=0, web=True, panel="signals",
    )  # fmt: skip
    title: str = parameter("", "Project name for the report.", stage="", web=True)

    def __post_init__(self) -> None:
        for declared in parameters_of(type(self)).values():
            declared.check(self)
        for name, weight in self.weights:
            if not (isinstance(weight, Real) and np.isfinite(weight) and weight >= 0):
                raise ValueError(f"the weight of {name!r} must be 0 or more, not {weight}")
        object.__setattr__(self, "habit", product_called(self.habit).name)
        if self.further.features and inputs_of(self.classifier) == "windows":
            names = ", ".join(self.further.features)
            raise ValueError(f"{self.classifier} learns from acc and gyr alone, not from {names}")
        if not self.on_skin and self.further != NOTHING:
            raise ValueError("a garment's sensors are accelerometer and gyroscope alone: leave others out")
        self.sensor_model()

    @property
    def on_skin(self) -> bool:
        """Whether nothing covers the skin that sensors sit on."""
        return not self.garments

    def sensor_model(self) -> SensorModel:
        """The sensor model that `sensor` names."""
        if self.own_sensor is not None and self.own_sensor.name == self.sensor:
            return self.own_sensor
        return preset(self.sensor)

    def signal_parameters(self) -> dict[str, Any]:
        """The parameters that signals and features depend on besides the body and its patches.

        A new one counts unless it is declared to be of another stage.
        """
        values = self.as_dict()
        del values["own_sensor"]  # the model says it
        for each in parameters_of(type(self)).values():
            if each.stage != "signals":
                *records, name = each.path
                reduce(lambda inside, record: inside.get(record, {}), records, values).pop(name, None)
        return {name: value for name, value in values.items() if value != {}}

    def as_dict(self) -> dict[str, Any]:
        """Every parameter as plain values, the sensor's own ones spelled out."""
        values = {**plain(self), "sensor_model": plain(self.sensor_model())}
        if self.further == NOTHING:
            del values["further"]
        return values

    @classmethod
    def from_dict(cls, parameters: Mapping[str, Any]) -> Self:
        """The config that `as_dict` gave; missing values take their default.

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
