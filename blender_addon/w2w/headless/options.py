# SPDX-License-Identifier: GPL-3.0-or-later
"""Parsing of options: bodies, wishes for sensors, the sensor and its signals, windows, poses from video."""

import inspect
import math
import os
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial, wraps
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ..api.loading import adopted
from ..core.body.body import Body
from ..core.body.shapes import MORPHOLOGIES, shaped
from ..core.files import load_arrays, reserved
from ..core.imu.presets import PRESETS, preset, read_sensor
from ..core.imu.sensor import SensorModel
from ..core.imu.synthesis import CONVENTIONS, Synthesis
from ..core.imu.virtual import FurtherSensors
from ..core.keypoints.facts import UNITS, PoseFacts, facts_of
from ..core.keypoints.joint_sets import JOINT_SETS
from ..core.motion.sight import UPS
from ..core.motion.source import UnusableMotion
from ..core.reading.reader import Reader
from ..core.windows.windows import WindowSpec
from ..core.wording import restated
from .blender import needs_blender

GENDERS = {"neutral": 0.0, "female": -1.0, "male": 1.0}
SHAPE_PARAMETERS = ("height", "weight", "muscle", "age", "arms", "legs")

BETAS = re.compile(r"(?P<file>.*\S)\s+betas=(?P<betas>\S+)")

EXAMPLE = "'female', 'male height=1.9 weight=95' or the path of an SMPL file"

CORES = os.cpu_count() or 1


def option(about: str, *names: str, **other: Any) -> Any:
    """An option with its help, names other than its parameter's, and more for Typer."""
    return typer.Option(*names, help=about, **other)


def argument(name: str, about: str) -> Any:
    """An argument with its name on the screen and its help."""
    return typer.Argument(metavar=name, help=about)


pose_option = partial(option, rich_help_panel="What motion files do not say")

AsJson = Annotated[bool, option("Print what was found as JSON instead, for programs.", "--json")]


@dataclass(frozen=True)
class PoseOptions:
    """The options that say what motion files do not."""

    pose_rate: Annotated[
        float | None,
        pose_option(
            "Frames per second of all files, whatever they say (for amc files 120 by default).",
            min=1,
            max=2000,
        ),
    ] = None
    pose_unit: Annotated[str, pose_option(f"Unit of joint positions: {', '.join(UNITS)}.")] = ""
    pose_up: Annotated[
        str,
        pose_option(
            f"Axis of the files that points up: {', '.join(UPS)}.  "
            "[default: by format, or all files together]"
        ),
    ] = ""
    pose_joints: Annotated[str, pose_option(f"Joint set of joint positions: {', '.join(JOINT_SETS)}.")] = ""
    person: Annotated[
        int | None, pose_option("Which of several people in a result of video; 1 is seen longest.", min=1)
    ] = None

    def pose(self) -> PoseFacts:
        """The facts about the files; a ValueError says which is unknown."""
        given = {"rate": self.pose_rate, "unit": self.pose_unit, "up": self.pose_up}
        return replace(facts_of(given | {"joint_set": self.pose_joints}), person=self.person)


def with_options(group: type) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command every option of a dataclass in the place of its parameter `asked`."""
    shared = inspect.signature(group).parameters

    def extended(command: Callable[..., None]) -> Callable[..., None]:
        own = inspect.signature(command, eval_str=True).parameters
        both = (each for name in own for each in (shared.values() if name == "asked" else (own[name],)))
        parameters = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in both]

        @wraps(command)
        def wrapped(**given: Any) -> None:
            asked = group(**{name: given.pop(name) for name in shared})
            command(**given, asked=asked)

        del wrapped.__wrapped__  # its signature is another
        vars(wrapped)["__signature__"] = inspect.Signature(parameters)
        wrapped.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
        return wrapped

    return extended


def words(text: str) -> tuple[str, ...]:
    """The items of a comma-separated list."""
    return tuple(part.strip() for part in text.split(",") if part.strip())


def parse_bodies(text: str) -> list[tuple[str, Body]]:
    """Read comma-separated descriptions or files of bodies; each body gets a name that can be a folder's.

    Such as ``neutral, female height=1.55, male`` or ``SMPL_NEUTRAL.npz betas=walking.npz``. A ValueError says
    which is not understood, or cannot be reached.
    """
    if not (parts := words(text)):
        raise ValueError(f"give at least one body, such as {EXAMPLE}")
    bodies = []
    for part in parts:
        with_betas = BETAS.fullmatch(part)
        file, betas = with_betas.group("file", "betas") if with_betas else (part, "")
        bodies.append((_folder_name(file, betas), _body(part, file, betas)))
    if len({name.lower() for name, _ in bodies}) < len(bodies):
        raise ValueError(f"two of the bodies are the same: {text}")
    return bodies


def _folder_name(file: str, betas: str = "") -> str:
    more = f" betas {Path(betas).name}" if betas else ""
    name = re.sub(r"[^0-9A-Za-z.]+", "_", Path(file).name + more).rstrip(".")
    return f"body_{name}" if reserved(name) or not name else name


def _body(text: str, file: str, betas: str) -> Body:
    gender, *shape = text.split()
    if text in MORPHOLOGIES:
        return shaped(Body.bundled(), **MORPHOLOGIES[text]) if MORPHOLOGIES[text] else Body.bundled()
    if gender in GENDERS:
        return shaped(Body.bundled(), gender=GENDERS[gender], **dict(map(_shape_parameter, shape)))
    if Path(file).suffix:
        with Reader() as reader, needs_blender(), restated(f"{file}:", UnusableMotion):
            return reader.read(Path(file), partial(adopted, Path(file), _betas(betas) if betas else None))
    raise ValueError(
        f"'{text}' is no body that W2W knows: write {EXAMPLE}, or one of {', '.join(MORPHOLOGIES)}"
    )


def _shape_parameter(word: str) -> tuple[str, float]:
    name, _, text = word.partition("=")
    with restated(f"'{word}' is not understood: write a shape as {EXAMPLE}", ValueError):
        value = float(text)
    if name not in SHAPE_PARAMETERS:
        raise ValueError(f"'{name}' is no shape parameter; there are {', '.join(SHAPE_PARAMETERS)}")
    return name, value


def _betas(text: str) -> np.ndarray:
    """Shape coefficients, from numbers joined by colons or from the npz of a motion."""
    hint = "write numbers such as betas=1.2:0:-0.5, or an npz that holds 'betas'"
    with restated(lambda error: f"betas={text}: {error}; {hint}", (OSError, KeyError, ValueError)):
        if text.lower().endswith(".npz"):
            betas = load_arrays(text, ("betas",), "gives no betas")["betas"]
            return np.atleast_1d(betas.squeeze()).astype(np.float64)
        return np.array([float(number) for number in text.split(":")])


def further_sensors(record: str, features: str, magnetic_dip: float) -> FurtherSensors:
    """`--record`, `--recognise-by` and `--magnetic-dip` as `FurtherSensors`; a ValueError names them."""
    recorded, recognised = (tuple(dict.fromkeys(words(text.lower()))) for text in (record, features))
    with restated("--record, --recognise-by, --magnetic-dip:", ValueError):
        return FurtherSensors(recorded, recognised, magnetic_dip)


def read_or_preset(text: str) -> SensorModel:
    """The sensor of a file, or the preset of that name; a ValueError says why there is none."""
    of_file = text.lower().endswith(".json") or Path(text).is_file()
    try:
        return read_sensor(text) if of_file else preset(text)
    except OSError as error:
        raise ValueError(f"{text} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise ValueError(f"{error}{'' if of_file else ', or a JSON file of your own part'}") from error


def chosen_sensor(text: str) -> SensorModel:
    """The sensor that `--sensor` names; a ValueError says why there is none."""
    with restated("--sensor:", ValueError):
        return read_or_preset(text)


def sensor_settings(text: str) -> dict[str, Any]:
    """`--sensor` as fields of a `StudyConfig`."""
    model = chosen_sensor(text)
    own = {} if PRESETS.get(model.name) == model else {"own_sensor": model}
    return {"sensor": model.name, **own}


def synthesis_settings(rate: float, band: float, convention: str) -> Synthesis:
    """`--rate`, `--band` and `--convention` as a `Synthesis`; a ValueError says which is wrong."""
    if convention not in CONVENTIONS:
        raise ValueError(f"--convention must be {' or '.join(CONVENTIONS)}, not {convention}")
    if not (math.isfinite(rate) and math.isfinite(band)):
        raise ValueError("--rate and --band must be numbers of Hz")
    return Synthesis(rate_hz=rate, cutoff_hz=band or None, convention=convention)


def window_spec(window: float, stride: float | None) -> WindowSpec:
    """`--window` and `--stride` as a `WindowSpec`; a ValueError says which is wrong."""
    if not math.isfinite(window):
        raise ValueError(f"--window must be a number of seconds, not {window:g}")
    if stride is not None and not 0 < stride <= window:
        longest = f"the window's length (--window {window:g})"
        raise ValueError(f"--stride must be at most {longest}, not {stride:g}")
    return WindowSpec.of_length(window, stride)
