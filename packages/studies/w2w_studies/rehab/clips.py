# SPDX-License-Identifier: GPL-3.0-or-later
"""Rehabilitation exercises from parameters, done well or badly, what people do between them, and gestures."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from .arm_raise import arm_raise_band
from .background import BACKGROUND
from .executions import FAULTS, WELL, aged, restyled, spoil
from .gestures import GESTURES
from .one_leg import one_leg_stand
from .pose import PosePlan, pose
from .session import Session, Style, draw_style
from .sit_to_stand import sit_to_stand
from .skeleton import Figure, draw_figure, forward_kinematics
from .stairs import stair_climbing

EXERCISES: dict[str, Callable[[Session], PosePlan]] = {
    "sit_to_stand": sit_to_stand,
    "stair_climbing": stair_climbing,
    "arm_raise_band": arm_raise_band,
    "one_leg_stand": one_leg_stand,
}
"""The paper's rehabilitation activities."""

RATE = 30.0
"""Frames per second, as Mixamo's."""


@dataclass(frozen=True, eq=False)
class RehabClip:
    """A generated clip on the skeleton of `rehab_skeleton`."""

    activity: str  # one of `EXERCISES`, `BACKGROUND` or `GESTURES`
    number: int  # which clip of the activity, from 0; the same number is the same person in every activity
    figure: Figure
    style: Style
    rotations: np.ndarray
    """(T, 27, 3, 3): of each bone relative to its parent, in the axes of the T-pose (z up, facing -y)."""
    hips: np.ndarray  # (T, 3): world position of the hips, metres
    rate: float = RATE  # frames per second
    execution: str = WELL  # "well", or what is wrong: one of `FAULTS`

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.hips)

    @property
    def subject(self) -> str:
        """Name of the person, ``S01`` and so on."""
        return f"S{self.number + 1:02d}"

    def joints(self) -> np.ndarray:
        """World positions of the 27 bones' heads, shape (T, 27, 3), metres."""
        return forward_kinematics(self.figure.rest(), self.rotations, self.hips)[1]


def generate_clip(
    activity: str,
    number: int,
    seed: int = 0,
    rate: float = RATE,
    execution: str = WELL,
    ages: tuple[float, float] | None = None,
) -> RehabClip:
    """Make one clip.

    `activity`: one of `EXERCISES`, `BACKGROUND` or `GESTURES`.
    `number`: which clip, from 0. Person and manner follow from it and the seed alone, so a clip does not
    depend on how many others are made.
    `seed`: not negative.
    `rate`: frames per second.
    `execution`: "well", or one of the exercise's `FAULTS`.
    `ages`: years between which the person's age is drawn; by default nobody has one.
    Raises ValueError if there is no such activity, or a number is out of range.
    """
    every = {**EXERCISES, **BACKGROUND, **GESTURES}
    if activity not in every:
        raise ValueError(f"there is no exercise {activity!r}; there are {', '.join(every)}")
    ways = (WELL, *FAULTS.get(activity, ()))
    if execution not in ways:
        raise ValueError(f"{activity} cannot be done {execution!r}; there are {', '.join(ways)}")
    if number < 0 or seed < 0:
        raise ValueError(f"clip number and seed must not be negative, not {number} and {seed}")
    if not rate > 0:
        raise ValueError(f"the frame rate must be positive, not {rate}")
    figure = draw_figure(np.random.default_rng([seed, number]))
    again = [] if execution == WELL else [ways.index(execution)]
    rng = np.random.default_rng([seed, number, 1 + list(every).index(activity), *again])
    style = restyled(draw_style(rng), execution, rng)
    if ages is not None:
        style = aged(style, np.random.default_rng([seed, number, 0]).uniform(*ages))
    time = np.arange(round(style.duration * rate) + 1) / rate
    session = Session(figure, style, time, rng)
    plan = every[activity](session)
    spoil(session, plan, activity, execution)
    rotations, hips = pose(figure, plan)
    return RehabClip(activity, number, figure, style, rotations, hips, rate, execution)
