# SPDX-License-Identifier: GPL-3.0-or-later
"""Five gestures of people at a standing desk, all right-handed: the clips of the demo."""

from collections.abc import Callable

import numpy as np

from .curves import pulse
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .style import elbow_pole, fill, stand_quietly

RIGHT = 1


def nodding(session: Session) -> PosePlan:
    """Nod, some nods in a row, whatever the hands do."""
    plan = _hands_at_anything(session)
    plan.head_turn[:, 0] += _rows_of(session, (8.0, 14.0), (1.1, 1.8))
    return plan


def shaking_the_head(session: Session) -> PosePlan:
    """Shake the head, some turns in a row, whatever the hands do."""
    plan = _hands_at_anything(session)
    plan.head_turn[:, 2] += _rows_of(session, (13.0, 24.0), (1.0, 1.7))
    return plan


def typing(session: Session) -> PosePlan:
    """Type with both hands, looking at them."""
    plan = _at_the_desk(session)
    _look_down(session, plan)
    for start, end in fill(session, usual=2.4, least=1, rest=0.3):
        busy = pulse(session.time, start, start + 0.25, end - 0.25, end)
        for side in (0, 1):
            tapping = _tones(session, (3.5, 6.0), 3)
            plan.hands[side] += busy[:, None] * tapping * [0.003, 0.002, 0.0025]
            plan.pronation[side] += np.radians(2.0) * busy * _tones(session, (2.0, 5.0), 1)[:, 0]
    return plan


def stirring(session: Session) -> PosePlan:
    """Stir a cup that the left hand holds, looking at it."""
    plan = _at_the_desk(session)
    _look_down(session, plan)
    radius, way = session.between(0.020, 0.032), session.rng.choice([-1.0, 1.0])
    plan.hands[:, :, 0] -= SIGNS[:, None] * 0.05
    for start, end in fill(session, usual=3.4, least=1, rest=0.25):
        busy = pulse(session.time, start, start + 0.35, end - 0.35, end)
        turns = 2 * np.pi * session.between(1.2, 2.0) * session.style.tempo * (session.time - start)
        plan.hands[RIGHT, :, 0] += radius * busy * np.cos(turns)
        plan.hands[RIGHT, :, 1] += way * radius * busy * np.sin(turns)
        plan.hands[RIGHT, :, 2] += 0.05 * busy  # a spoon stands higher than keys
    return plan


def drinking(session: Session) -> PosePlan:
    """Lift a cup to the mouth, tip head and cup back, and set it down."""
    plan = _at_the_desk(session)
    figure, desk = session.figure, plan.hands[RIGHT].copy()
    inward = figure.shoulder_half_width - session.between(0.04, 0.07)
    mouth = np.array([-SIGNS[RIGHT] * inward, -session.between(0.19, 0.24), 0.07 * figure.stature])
    for start, end in fill(session, usual=4.6, least=1, rest=0.25):
        span = end - start
        top, down = start + session.between(0.27, 0.36) * span, end - session.between(0.27, 0.36) * span
        lifted = pulse(session.time, start, top, down, end)
        sip = pulse(session.time, start + 0.2 * span, top, down, end - 0.2 * span)
        plan.hands[RIGHT] += lifted[:, None] * (mouth - desk)
        raised = elbow_pole(np.full(len(desk), 1.2), RIGHT, outward=0.6)
        plan.elbows[RIGHT] += lifted[:, None] * (raised - plan.elbows[RIGHT])
        plan.pronation[RIGHT] += sip * session.degrees_between(15.0, 35.0)
        plan.head_turn[:, 0] -= sip * session.degrees_between(12.0, 22.0)
        plan.chest_turn[:, 0] -= sip * session.degrees_between(0.0, 3.0)
    return plan


def _hands_at_anything(session: Session) -> PosePlan:
    """Stand with hanging arms, the hands on the desk, typing or stirring, and look ahead."""
    plan = (stand_quietly, _at_the_desk, typing, stirring)[session.rng.integers(4)](session)
    plan.head_turn[:, 0] += np.radians(5.0) - plan.head_turn[:, 0].mean()
    return plan


def _at_the_desk(session: Session) -> PosePlan:
    """Stand with the hands at elbow height on the desk."""
    plan, figure, n = stand_quietly(session), session.figure, len(session.time)
    plan.arms_follow[:] = 1.0
    ahead, low = session.between(0.95, 1.1) * figure.forearm, session.between(0.88, 0.97) * figure.upper_arm
    for side in (0, 1):
        plan.hands[side] = [-SIGNS[side] * session.between(0.02, 0.07), -ahead, -low]
        plan.elbows[side] = elbow_pole(np.full(n, 0.7), side)
    plan.pronation += session.degrees_between(35.0, 50.0)
    plan.hand_sway *= 0.3  # the desk carries them
    plan.balance[:] = 0.4  # and some of the weight
    return plan


def _look_down(session: Session, plan: PosePlan) -> None:
    """Look at the hands, and up now and then."""
    down = session.degrees_between(10.0, 22.0) * np.ones(len(session.time))
    for start, end in fill(session, usual=3.0, least=1, rest=0.3):
        up = pulse(session.time, start, start + 0.4, start + 0.7, min(start + 1.2, end))
        down -= session.degrees_between(4.0, 10.0) * up
    plan.head_turn[:, 0] += down


def _rows_of(session: Session, degrees: tuple[float, float], hertz: tuple[float, float]) -> np.ndarray:
    """Swings (T,) to and fro, radians: some in a row, then a pause, then again."""
    angle = np.zeros(len(session.time))
    size = session.degrees_between(*degrees) * session.style.amplitude
    for start, end in fill(session, usual=2.8, least=1, rest=0.3):
        busy = pulse(session.time, start, start + 0.35, end - 0.35, end)
        pace = session.between(*hertz) * session.style.tempo
        angle += size * busy * np.sin(2 * np.pi * pace * (session.time - start))
    return angle


def _tones(session: Session, hertz: tuple[float, float], channels: int) -> np.ndarray:
    """Irregular swings (T, channels) of about unit size whose pace lies in a band."""
    rng, tones = session.rng, 5
    pace, phase = rng.uniform(*hertz, (tones, channels)), rng.uniform(0, 2 * np.pi, (tones, channels))
    waves = np.sin(2 * np.pi * pace * session.time[:, None, None] + phase)
    return waves.sum(axis=1) / np.sqrt(tones / 2)


GESTURES: dict[str, Callable[[Session], PosePlan]] = {
    "nod": nodding,
    "shake_head": shaking_the_head,
    "type": typing,
    "stir": stirring,
    "drink": drinking,
}
"""What a designer of a wearable for the office might want to recognise."""
