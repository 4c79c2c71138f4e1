# SPDX-License-Identifier: GPL-3.0-or-later
"""Who does an exercise and how: a style for life, and what one clip adds to it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .skeleton import Figure


@dataclass(frozen=True)
class Style:
    """What varies from clip to clip in every exercise, from the same distribution for all."""

    duration: float
    lead_in: float
    lead_out: float
    """Seconds; the first and last are spent standing or sitting still."""
    tempo: float
    amplitude: float
    sway: float
    """Multiples of what is usual."""
    asymmetry: float  # how much more the left side does than the right, as a share of the movement
    lag: float  # seconds by which the right hand follows the left
    side: int  # the favoured side: 0 left, 1 right
    stance: float  # half the distance between the feet, as a multiple of half the hips' width
    toe_out: float
    knee_bend: float
    elbow_bend: float
    arm_out: float
    """Habitual posture, radians."""
    pelvis: tuple[float, float, float]
    trunk: tuple[float, float, float]
    gaze: tuple[float, float, float]
    """Habitual (pitch forward, list to the left, yaw to the left) of pelvis, chest and head, radians."""

    @property
    def active(self) -> tuple[float, float]:
        """Start and end of the exercise itself, seconds."""
        return self.lead_in, self.duration - self.lead_out

    @property
    def scales(self) -> tuple[float, float]:
        """What to multiply the movement of the left and the right side with."""
        return 1.0 + self.asymmetry / 2, 1.0 - self.asymmetry / 2


@dataclass(frozen=True)
class Session:
    """Everything an exercise is made from."""

    figure: Figure  # who moves
    style: Style  # how
    time: np.ndarray  # (T,): seconds of the frames
    rng: np.random.Generator  # for all that is particular to the exercise

    def between(self, low: float, high: float) -> float:
        """A number between two at random."""
        return self.rng.uniform(low, high)

    def degrees_between(self, low: float, high: float) -> float:
        """An angle between two at random: given in degrees, returned in radians."""
        return np.radians(self.rng.uniform(low, high))

    def one_of(self, choices: Sequence[str]) -> str:
        """One of some names at random."""
        return choices[self.rng.integers(len(choices))]


def draw_style(rng: np.random.Generator) -> Style:
    """A style at random: clips of 5 to 9.5 s with 0.4 to 1.3 s of rest at each end."""
    normal = np.clip(rng.standard_normal(15), -2.2, 2.2)
    return Style(
        duration=rng.uniform(5.0, 9.5),
        lead_in=rng.uniform(0.4, 1.3),
        lead_out=rng.uniform(0.4, 1.3),
        tempo=np.exp(0.12 * normal[0]),
        amplitude=np.clip(np.exp(0.18 * normal[1]), 0.65, 1.2),
        sway=np.exp(0.30 * normal[2]),
        asymmetry=0.08 * normal[3],
        lag=0.04 * normal[4],
        side=int(rng.integers(2)),
        stance=rng.uniform(0.85, 1.35),
        toe_out=np.radians(rng.uniform(3.0, 14.0)),
        knee_bend=np.radians(rng.uniform(6.5, 12.0)),
        elbow_bend=np.radians(23.0 + 4.0 * normal[5]),
        arm_out=np.radians(rng.uniform(6.5, 12.0)),
        pelvis=_posture(normal[6:9], (0.0, 4.0), 1.8, 2.0),
        trunk=_posture(normal[9:12], (2.0, 3.0), 1.8, 3.0),
        gaze=_posture(normal[12:15], (3.0, 4.0), 2.0, 5.0),
    )


def _posture(
    normal: np.ndarray, pitch: tuple[float, float], list_spread: float, yaw_spread: float
) -> tuple[float, float, float]:
    """Habitual turn from normal deviates and their spreads; the pitch also has a mean. Degrees to radians."""
    mean, spread = pitch
    return tuple(np.radians([mean, 0.0, 0.0] + normal * [spread, list_spread, yaw_spread]).tolist())
