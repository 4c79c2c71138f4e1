# SPDX-License-Identifier: GPL-3.0-or-later
"""Exercises done badly, in ways that a clinician wants to recognise, and by people of other ages.

Half the range, slowly, one-sidedly: another style. A compensating trunk or a tremor: written over the plan.
"""

from dataclasses import replace

import numpy as np

from .pose import PosePlan
from .session import Session, Style

WELL = "well"

FAULTS: dict[str, tuple[str, ...]] = {
    "sit_to_stand": ("trunk", "half_range", "slow", "shaky", "one_sided"),
    "stair_climbing": ("trunk", "slow", "shaky", "one_sided"),
    "arm_raise_band": ("trunk", "half_range", "slow", "shaky", "one_sided"),
    "one_leg_stand": ("trunk", "half_range", "shaky"),
}
"""What each exercise is done wrong by: a flight of stairs has no half, and nobody stands slowly."""

TREMOR_BAND = (3.5, 6.5)
"""Hz: where most tremors of patients lie (Deuschl, Bain and Brin 1998, doi:10.1002/mds.870131303)."""

_TONES = 8
_MIDDLE_AGE, _AGES = 45.0, 40.0


def restyled(style: Style, fault: str, rng: np.random.Generator) -> Style:
    """The style of somebody who does it so."""
    if fault == "slow":
        return replace(style, tempo=0.5 * style.tempo, duration=1.35 * style.duration)
    if fault == "half_range":
        return replace(style, amplitude=rng.uniform(0.5, 0.62) * style.amplitude)
    if fault == "one_sided":
        sign = 1.0 if style.side == 0 else -1.0
        return replace(style, asymmetry=sign * rng.uniform(0.6, 0.9))
    return style


def aged(style: Style, age: float) -> Style:
    """The style at an age, years: older people are slower, sway more, stoop and move less far."""
    old = (age - _MIDDLE_AGE) / _AGES
    pitch, aside, yaw = style.trunk
    return replace(
        style,
        tempo=style.tempo * np.exp(-0.18 * old),
        sway=style.sway * np.exp(0.35 * old),
        amplitude=style.amplitude * np.exp(-0.06 * old),
        trunk=(pitch + np.radians(6.0) * old, aside, yaw),
    )


def spoil(session: Session, plan: PosePlan, activity: str, fault: str) -> None:
    """Write what a style cannot say of a fault over the plan of an exercise.

    `plan`: changed in place.
    """
    if fault == "trunk":
        _compensate(session, plan)
    elif fault == "shaky":
        _shake(session, plan)
    elif fault == "half_range" and activity == "sit_to_stand":
        _stay_low(session, plan)


def _compensate(session: Session, plan: PosePlan) -> None:
    """The trunk does part of the work: more of every lean, back against the arms, over the standing leg."""
    leans = plan.chest_turn - plan.chest_turn[0]
    plan.chest_turn += session.between(0.5, 0.9) * leans
    plan.pelvis_turn += 0.2 * leans
    raised = np.linalg.norm(plan.hands - plan.hands[:, :1], axis=2).mean(axis=0)
    effort = raised**2 / (raised**2 + 0.25**2) * (1 - plan.on_thighs.max(axis=0))
    aside = session.degrees_between(7.0, 13.0) * (1.0 if session.style.side else -1.0)
    plan.chest_turn[:, 0] -= session.degrees_between(6.0, 11.0) * effort
    plan.chest_turn[:, 1] += aside * effort
    lifted = plan.lifted[1] - plan.lifted[0]
    plan.chest_turn[:, 1] += session.degrees_between(9.0, 15.0) * lifted
    plan.pelvis_turn[:, 1] -= session.degrees_between(3.0, 6.0) * lifted


def _shake(session: Session, plan: PosePlan) -> None:
    """A tremor of hands, trunk and a lifted leg throughout."""
    size = session.between(0.25, 0.6)
    noise = size * tremor(session.time, session.rng, 18)
    plan.hand_sway += 0.008 * noise[:, :6].reshape(-1, 2, 3).transpose(1, 0, 2)
    plan.elbow_sway += np.radians(1.5) * noise[:, 6:8].T
    plan.chest_turn += np.radians(0.8) * noise[:, 8:11]
    plan.pelvis_turn += np.radians(0.4) * noise[:, 11:14]
    plan.hip_flexion += np.radians(1.5) * noise[:, 14:16].T
    plan.knee_flexion += np.radians(1.5) * noise[:, 16:18].T


def _stay_low(session: Session, plan: PosePlan) -> None:
    """The pelvis stays between chair and standing, the trunk bent: nobody comes upright."""
    height = plan.pelvis[:, 2]
    low, high = height.min(), height.max()
    share = session.between(0.45, 0.6)
    risen = (height - low) / max(high - low, 1e-6)
    plan.pelvis[:, 2] = low + share * (height - low)
    plan.chest_turn[:, 0] += session.degrees_between(14.0, 22.0) * risen
    plan.pelvis_turn[:, 0] += session.degrees_between(6.0, 12.0) * risen


def tremor(time: np.ndarray, rng: np.random.Generator, channels: int) -> np.ndarray:
    """Curves (T, channels) of unit variance within `TREMOR_BAND`, as a sum of tones."""
    low, high = TREMOR_BAND
    tones = low + (high - low) * rng.random((channels, _TONES))
    phases = rng.uniform(0.0, 2.0 * np.pi, tones.shape)
    waves = np.sin(2 * np.pi * tones * time[:, None, None] + phases)
    return np.sqrt(2.0 / _TONES) * waves.sum(axis=2)
