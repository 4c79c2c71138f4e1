# SPDX-License-Identifier: GPL-3.0-or-later
"""Sit-to-stand: rise from a chair and sit down again."""

from dataclasses import dataclass

import numpy as np

from .curves import stroke
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .style import ARM_FORWARD, SLACK, elbow_pole, fill, hang, seated_pelvis, stand_quietly

_ARMS = ("crossed", "thighs", "forward")


@dataclass
class _Progress:
    """Where the body is between seated, 0, and standing, 1; arrays of shape (T,)."""

    up: np.ndarray
    ahead: np.ndarray
    """Height and advance of the pelvis."""
    free: np.ndarray  # how far the hands have left the thighs
    lean: np.ndarray
    swing: np.ndarray
    """Lean of the trunk and swing of the arms on the way, 0 at both ends."""


def sit_to_stand(session: Session) -> PosePlan:
    """Rise from a chair and sit down, as often as the clip is long.

    The phases are those of Schenkman et al. 1990 (doi:10.1093/ptj/70.10.638): the trunk
    swings forward, at about a third of the rise the seat is left with the trunk bent most,
    then hips and knees extend while the trunk comes upright. Sitting down runs the other
    way round, slower and with less lean at the end. Clips begin seated or standing.
    """
    style = session.style
    plan = stand_quietly(session)
    arms = session.one_of(_ARMS)
    begins_standing = session.rng.random() < 0.4
    transitions = fill(session, usual=2.3, least=2, rest=0.35)
    way = _progress(session.time, transitions, begins_standing, early_hands=arms == "forward")

    seat, standing = seated_pelvis(session), plan.pelvis - [0.0, 0.0, SLACK]
    plan.pelvis[:, 1] = seat[0] + way.ahead * (standing[:, 1] - seat[0])
    plan.pelvis[:, 2] = seat[1] + way.up * (standing[:, 2] - seat[1])
    plan.pelvis[:, 0] += 0.15 * style.asymmetry * way.lean
    plan.balance = (way.up * way.ahead) ** 2
    # one foot is drawn back a little
    plan.balls[style.side, :, 1] += session.between(0.0, 0.05)

    most = session.degrees_between(30.0, 42.0) * style.amplitude
    bend = (1 - way.up) * session.degrees_between(-6.0, 6.0) + way.lean * most
    plan.chest_turn[:, 0] += bend
    plan.chest_turn[:, 1] += np.radians(20.0) * style.asymmetry * way.lean
    plan.pelvis_turn[:, 0] += 0.55 * bend - (1 - way.up) * session.degrees_between(4.0, 12.0)
    plan.head_turn[:, 0] += 0.35 * bend
    if arms == "crossed":
        _cross_arms(session, plan)
    else:
        _use_arms(session, plan, way, np.radians(70.0 if arms == "forward" else 8.0))
    return plan


def _progress(
    time: np.ndarray, transitions: np.ndarray, begins_standing: bool, early_hands: bool
) -> _Progress:
    start = np.full(len(time), float(begins_standing))
    way = _Progress(start.copy(), start.copy(), start.copy(), 0 * start, 0 * start)
    for index, (begin, end) in enumerate(transitions):

        def part(first: float, last: float, begin: float = begin, span: float = end - begin) -> np.ndarray:
            return stroke(time, begin + first * span, begin + last * span)

        if begins_standing == bool(index % 2):
            way.up += part(0.30, 1.00)
            way.ahead += part(0.22, 0.98)
            way.free += part(0.00, 0.55) if early_hands else part(0.15, 0.72)
            way.lean += part(0.00, 0.44) - part(0.38, 0.96)
            way.swing += part(0.05, 0.55) - part(0.50, 1.00)
        else:
            way.up -= part(0.02, 0.76)
            way.ahead -= part(0.00, 0.72)
            way.free -= part(0.45, 1.00) if early_hands else part(0.34, 1.00)
            way.lean += 0.85 * (part(0.00, 0.58) - part(0.56, 1.00))
            way.swing += 0.8 * (part(0.00, 0.50) - part(0.45, 0.95))
    return way


def _cross_arms(session: Session, plan: PosePlan) -> None:
    """Wrists on the other side of the chest, one arm over the other."""
    figure, size = session.figure, session.figure.stature
    plan.arms_follow[:] = 1.0
    for side in (0, 1):
        over = 0.022 if side == session.style.side else 0.0
        inward = -SIGNS[side] * (figure.shoulder_half_width + 0.030 * size)
        plan.hands[side] = [inward, -(0.085 + over) * size, -(0.045 + over) * size]
        plan.elbows[side] = [0.9 * SIGNS[side], -0.2, -1.0]


def _use_arms(session: Session, plan: PosePlan, way: _Progress, swing: float) -> None:
    """Hands on the thighs while seated; on the way they come forward by the angle `swing`."""
    style = session.style
    for side in (0, 1):
        flexion = ARM_FORWARD + style.scales[side] * style.amplitude * swing * way.swing
        plan.hands[side] = hang(session, flexion, style.arm_out, side)
        plan.elbows[side] = elbow_pole(flexion + 0.6 * (1 - way.free), side, outward=0.5)
    plan.on_thighs += 1 - way.free
    plan.pronation += np.radians(40.0) * plan.on_thighs
