# SPDX-License-Identifier: GPL-3.0-or-later
"""Standing on one leg: shift the weight, lift the other foot, hold, put it down."""

from dataclasses import dataclass

import numpy as np

from .curves import pulse, sway
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .style import ARM_FORWARD, elbow_pole, hang, over_feet, stand_quietly

_LIFTS = {  # hip flexion, knee flexion, how far the heel is above the toes, degrees
    "front": (62.0, 78.0, 12.0),
    "low": (32.0, 58.0, 12.0),
    "lowest": (26.0, 46.0, 4.0),
    "back": (4.0, 78.0, 62.0),
}
_ARMS = {"hang": (0.0, 20.0), "hips": (0.0, 0.0), "out": (20.0, 70.0)}
"""How far the arms come out from the sides, degrees: least and most."""


@dataclass(frozen=True)
class _Stand:
    """When one stand on leg `side` begins and ends, and when the other foot goes up and down; seconds."""

    side: int
    begin: float
    shifted: float
    lift: float
    lifted: float
    lower: float
    lowered: float
    unshift: float
    end: float


def one_leg_stand(session: Session) -> PosePlan:
    """Stand on one leg, once or first on the one and then on the other.

    The centre of mass moves over the foot that will carry it before the other one leaves
    the ground, and is kept there with more sway than on two feet.
    """
    plan = stand_quietly(session)
    way, arms = session.one_of(tuple(_LIFTS)), session.one_of(tuple(_ARMS))
    # some stand like a rock, some fight for balance
    unsteady = session.between(0.2, 1.2) * session.style.sway * sway(session.time, session.rng, 11)
    held = np.zeros_like(session.time)
    for stand in _stands(session):
        held += _stand_on(session, plan, stand, way)
    plan.grounded += held[:, None] * unsteady[:, :2] * [0.007, 0.006]
    plan.chest_turn += held[:, None] * np.radians([1.2, 1.8, 1.2]) * unsteady[:, 2:5]
    plan.pelvis_turn += held[:, None] * np.radians([0.6, 1.0, 0.8]) * unsteady[:, 2:5]
    plan.hip_flexion += np.radians(1.5) * unsteady[:, 5:7].T
    plan.knee_flexion += np.radians(2.5) * unsteady[:, 7:9].T
    _hold_arms(session, plan, arms, held, unsteady[:, 9:].T)
    return plan


def _stands(session: Session) -> list[_Stand]:
    """One stand on the favoured leg or, where there is time, one on each."""
    style = session.style
    start, end = style.active
    if (end - start) * style.tempo > 6.0 and session.rng.random() < 0.6:
        middle = start + (end - start) * session.between(0.47, 0.53)
        spans = [(start, middle), (middle, end)]
    else:
        spans = [(start, end)]
    return [_stand(session, (style.side + index) % 2, *span) for index, span in enumerate(spans)]


def _stand(session: Session, side: int, begin: float, end: float) -> _Stand:
    shift, raise_time = 0.85 * np.exp(0.15 * session.rng.standard_normal(2)) / session.style.tempo
    # both must leave time to hold the foot up
    shift, raise_time = min(shift, 0.25 * (end - begin)), min(raise_time, 0.25 * (end - begin))
    lift, lowered = begin + 0.6 * shift, end - 0.6 * shift
    return _Stand(
        side,
        begin,
        begin + shift,
        lift,
        lift + raise_time,
        lowered - 0.9 * raise_time,
        lowered,
        end - shift,
        end,
    )


def _stand_on(session: Session, plan: PosePlan, stand: _Stand, way: str) -> np.ndarray:
    """Write one stand into the plan; returns how far the other foot is lifted, 0 to 1."""
    figure, style, time = session.figure, session.style, session.time
    carried = pulse(time, stand.begin, stand.shifted, stand.unshift, stand.end)
    lifted = pulse(time, stand.lift, stand.lifted, stand.lower, stand.lowered)
    toe_out = plan.foot_yaw[stand.side]
    # on one foot nobody shifts the weight for comfort
    plan.grounded[:, 0] *= 1 - carried
    plan.grounded[:, 0] += carried * (
        plan.balls[stand.side, 0, 0] - (figure.ball_ahead + over_feet(figure)) * np.sin(toe_out)
    )

    free, sign = 1 - stand.side, SIGNS[stand.side]
    share = style.amplitude * style.scales[free]
    hip, knee, heel = np.radians(_LIFTS[way]) * np.array([share, share, 1.0])
    plan.lifted[free] += lifted
    plan.hip_flexion[free] += hip
    plan.knee_flexion[free] += knee
    # the heel leaves the ground before the toes do, and comes down after them
    halfway_up, halfway_down = (stand.lift + stand.lifted) / 2, (stand.lower + stand.lowered) / 2
    tiptoe = pulse(time, stand.begin, halfway_up, halfway_up, stand.lifted)
    tiptoe += pulse(time, stand.lower, halfway_down, halfway_down, stand.end)
    plan.heel_rise[free] += heel * lifted + np.radians(14.0) * tiptoe
    plan.toe_dip[free] += 0.8 * heel * lifted**3
    # the pelvis hikes on the free side, the trunk leans over the standing leg
    plan.pelvis_turn[:, 1] += sign * session.degrees_between(-3.0, 4.0) * lifted
    plan.chest_turn[:, 1] += sign * session.degrees_between(-1.0, 5.0) * (0.5 * carried + 0.5 * lifted)
    plan.pelvis_turn[:, 0] -= np.radians(6.0) * hip * lifted
    plan.chest_turn[:, 0] += session.degrees_between(-2.0, 4.0) * lifted
    return lifted


def _hold_arms(session: Session, plan: PosePlan, arms: str, held: np.ndarray, unsteady: np.ndarray) -> None:
    if arms == "hips":
        plan.arms_follow[:] = 1.0
        plan.pronation += session.degrees_between(20.0, 50.0)
    out = session.degrees_between(*_ARMS[arms])
    for side in (0, 1):
        if arms == "hips":
            _hand_on_hip(session, plan, side)
            continue
        correction = np.radians(4.0) * held * unsteady[side]
        abduction = session.style.arm_out + session.style.scales[side] * out * held + correction
        flexion = ARM_FORWARD + 0.3 * out * held
        plan.hands[side] = hang(session, flexion, abduction, side)
        plan.elbows[side] = elbow_pole(flexion, side)


def _hand_on_hip(session: Session, plan: PosePlan, side: int) -> None:
    sign, figure = SIGNS[side], session.figure
    crest = 0.082 * figure.breadth * figure.stature
    inward = sign * (crest - figure.shoulder_half_width)
    plan.hands[side] = [inward, -0.015 * figure.stature, -0.222 * figure.stature]
    plan.elbows[side] = [sign, 0.55, 0.0]
