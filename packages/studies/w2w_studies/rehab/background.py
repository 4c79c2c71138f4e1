# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do between exercises, and a sensor must not take for one: stand, sit, reach, walk."""

from collections.abc import Callable

import numpy as np

from .curves import pulse
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .stairs import LEVEL, walk
from .style import ARM_FORWARD, elbow_pole, fidget, fill, hang, seated_pelvis, stand_quietly


def standing(session: Session) -> PosePlan:
    """Stand about, shifting the weight and looking round."""
    plan = stand_quietly(session)
    fidget(session, plan)
    return plan


def sitting(session: Session) -> PosePlan:
    """Sit on a chair with the hands on the thighs or in the lap."""
    plan = stand_quietly(session)
    _sit_down(session, plan)
    fidget(session, plan)
    return plan


def reaching(session: Session) -> PosePlan:
    """Reach for things with one hand after the other, standing or seated."""
    plan = stand_quietly(session)
    seated = session.rng.random() < 0.5
    if seated:
        _sit_down(session, plan)
    flexion = np.full((2, len(session.time)), ARM_FORWARD)
    abduction = np.full((2, len(session.time)), session.style.arm_out)
    for start, end in fill(session, usual=2.2, least=1, rest=0.5):
        _reach_once(session, plan, (flexion, abduction), start, end)
    for side in (0, 1):
        plan.hands[side] = hang(session, flexion[side], abduction[side], side)
        plan.elbows[side] = elbow_pole(flexion[side], side)
    return plan


def walking(session: Session) -> PosePlan:
    """Walk some steps on the level."""
    return walk(session, LEVEL)


def _reach_once(
    session: Session, plan: PosePlan, arms: tuple[np.ndarray, np.ndarray], start: float, end: float
) -> None:
    """One hand goes out and comes back, the trunk turning and leaning after it."""
    span, side = end - start, int(session.rng.integers(2))
    top = start + session.between(0.3, 0.45) * span
    moment = pulse(session.time, start, top, top + session.between(0.05, 0.2) * span, end)
    flexion, abduction = arms
    flexion[side] += session.degrees_between(35.0, 105.0) * moment
    abduction[side] += session.degrees_between(-5.0, 35.0) * moment
    plan.on_thighs[side] *= 1 - moment
    plan.chest_turn[:, 0] += session.degrees_between(0.0, 18.0) * moment
    plan.chest_turn[:, 2] -= SIGNS[side] * session.degrees_between(0.0, 15.0) * moment
    plan.head_turn[:, 2] += SIGNS[side] * session.degrees_between(0.0, 15.0) * moment


def _sit_down(session: Session, plan: PosePlan) -> None:
    y, z = seated_pelvis(session)
    plan.pelvis[:, 1:] = y, z
    plan.balance[:] = 0.0
    plan.chest_turn[:, 0] += session.degrees_between(-6.0, 8.0)
    plan.pelvis_turn[:, 0] -= session.degrees_between(4.0, 12.0)
    plan.on_thighs[:] = 1.0
    plan.pronation += np.radians(40.0)
    for side in (0, 1):
        plan.elbows[side] = elbow_pole(np.full(len(session.time), ARM_FORWARD + 0.6), side, outward=0.5)


BACKGROUND: dict[str, Callable[[Session], PosePlan]] = {
    "standing": standing,
    "sitting": sitting,
    "reaching": reaching,
    "walking": walking,
}
"""Trained against and not counted."""
