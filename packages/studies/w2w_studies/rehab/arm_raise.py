# SPDX-License-Identifier: GPL-3.0-or-later
"""Arm raises with a resistance band: to the front, overhead or to the sides."""

import numpy as np

from .curves import pulse
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .style import elbow_pole, fill, hang, seated_pelvis, stand_quietly
from .two_bones import reach

_WAYS = {  # where the arms start, where they do when seated, and where they end: degrees from hanging
    "front": (16.0, 42.0, 92.0),
    "overhead": (18.0, 42.0, 132.0),
    "lateral": (13.0, 20.0, 84.0),
}


def arm_raise_band(session: Session) -> PosePlan:
    """Raise one or both arms against a band, standing or seated, as often as the clip is long.

    To the front and overhead the hands keep the band taut between them; to the sides each
    hand pulls an end of a band that the feet stand on. Lifting is quicker than giving way,
    and the trunk leans back a little against the load.
    """
    plan = stand_quietly(session)
    way = session.one_of(tuple(_WAYS))
    seated, one_arm = session.rng.random(2) < [0.3, 0.3]
    repetitions = fill(session, usual=3.3 if way == "overhead" else 2.7, least=1, rest=0.2)
    raised = _lifts(session, repetitions)
    if one_arm:
        raised[1 - session.style.side] = 0.0
    if seated:
        _sit(session, plan)
    standing_start, seated_start, peak = np.radians(_WAYS[way])
    start = seated_start if seated else standing_start
    angle = start + (peak - start) * raised
    if way == "lateral":
        _to_the_sides(session, plan, angle)
    else:
        _along_the_band(session, plan, angle)
    _lean_back(session, plan, raised, looks_up=way == "overhead")
    return plan


def _lifts(session: Session, repetitions: np.ndarray) -> np.ndarray:
    """How far the left and the right arm are raised, 0 to about 1, shape (2, T)."""
    style = session.style
    raised = np.zeros((2, len(session.time)))
    for start, end in repetitions:
        span = end - start
        top = start + session.between(0.36, 0.46) * span
        fall = top + session.between(0.02, 0.14) * span
        heights = style.amplitude * np.array(style.scales) * (1 + 0.05 * session.rng.standard_normal())
        for side, lag in enumerate((0.0, style.lag)):
            raised[side] += heights[side] * pulse(session.time - lag, start, top, fall, end)
    return raised


def _sit(session: Session, plan: PosePlan) -> None:
    y, z = seated_pelvis(session)
    plan.pelvis[:, 1:] = y, z
    plan.balance[:] = 0.0
    plan.chest_turn[:, 0] += session.degrees_between(-6.0, 6.0)
    plan.pelvis_turn[:, 0] -= session.degrees_between(4.0, 12.0)


def _to_the_sides(session: Session, plan: PosePlan, angle: np.ndarray) -> None:
    """Somewhat in front of the frontal plane, where the shoulder blade lies."""
    in_front = session.degrees_between(12.0, 32.0)
    for side in (0, 1):
        plan.hands[side] = hang(session, in_front * np.sin(angle[side]), angle[side], side)
        plan.elbows[side] = elbow_pole(0.3 * angle[side], side, outward=0.15)


def _along_the_band(session: Session, plan: PosePlan, angle: np.ndarray) -> None:
    """Forward and up, the hands staying as far apart as the taut band is long."""
    figure = session.figure
    length = reach(figure.upper_arm, figure.forearm, session.style.elbow_bend)
    outward = (session.between(0.95, 1.35) - 1.0) * figure.shoulder_half_width
    ahead = np.sqrt(length**2 - outward**2)
    for side in (0, 1):
        plan.hands[side, :, 0] = SIGNS[side] * outward
        plan.hands[side, :, 1] = -ahead * np.sin(angle[side])
        plan.hands[side, :, 2] = -ahead * np.cos(angle[side])
        plan.elbows[side] = elbow_pole(angle[side], side, outward=0.7)
    plan.pronation += np.radians(35.0)


def _lean_back(session: Session, plan: PosePlan, raised: np.ndarray, looks_up: bool) -> None:
    effort = raised.mean(axis=0)
    plan.arms_follow += 0.8 * effort / (0.2 + effort)
    plan.chest_turn[:, 0] -= session.degrees_between(0.0, 6.0) * effort
    plan.pelvis_turn[:, 0] -= session.degrees_between(0.0, 2.0) * effort
    plan.chest_turn[:, 1] += np.radians(5.0) * (raised[1] - raised[0])
    plan.head_turn[:, 0] -= session.degrees_between(0.0, 10.0 if looks_up else 4.0) * effort
