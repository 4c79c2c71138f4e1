# SPDX-License-Identifier: GPL-3.0-or-later
"""Stair climbing, foot over foot or both feet on every tread; and the same on the level."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from .curves import glide, pulse, stroke, through
from .pose import PosePlan
from .session import Session
from .skeleton import SIGNS
from .style import ARM_FORWARD, SLACK, elbow_pole, hang, stand_quietly

RISE, RUN = 0.17, 0.28
"""Height and depth of a step, metres."""


@dataclass(frozen=True)
class Way:
    """What is walked on, and how people go there."""

    rise: float = RISE
    run: float = RUN
    """Height and depth of a step, metres."""
    step_s: float = 0.90  # seconds a step takes, foot over foot
    over: float = 0.75  # share of people who go foot over foot; the others bring both feet to every step
    clearance: tuple[float, float] = (0.045, 0.075)
    sink: tuple[float, float] = (0.010, 0.025)
    """How far a foot is lifted over the edge, and how far the pelvis sinks: least and most, metres."""
    heel: tuple[float, float] = (26.0, 38.0)
    lean: tuple[float, float] = (8.0, 17.0)
    gaze: tuple[float, float] = (2.0, 16.0)
    """Heel rise, lean of the trunk and downward look: least and most, degrees."""


UPSTAIRS = Way()
LEVEL = Way(0.0, 0.29, 0.60, 1.0, (0.02, 0.035), (0.015, 0.03), (24.0, 34.0), (0.0, 5.0), (0.0, 8.0))

ONE_SIDED = 0.5
"""Asymmetry beyond which one leg always leads."""

_SWING = 0.80
"""Share of a step's time its foot is in the air; the rest of it both feet stand."""


@dataclass(frozen=True)
class _Step:
    """One foot's way from tread to tread; `side` 0 left, 1 right; seconds; the floor is tread 0."""

    side: int
    leaves: float
    lands: float
    from_tread: int
    to_tread: int

    @property
    def span(self) -> float:
        return self.lands - self.leaves

    @property
    def middle(self) -> float:
        return (self.leaves + self.lands) / 2


def stair_climbing(session: Session) -> PosePlan:
    """Walk up a flight of stairs, from standing before it to standing on it."""
    return walk(session, UPSTAIRS)


def walk(session: Session, way: Way) -> PosePlan:
    """Walk from standing to standing.

    The pelvis rises while the foot that has just landed takes the weight, the trunk leans
    forward, the arms swing against the legs (kinematics as in Riener et al. 2002,
    doi:10.1016/S0966-6362(01)00009-X).
    """
    plan = stand_quietly(session)
    steps = _footfalls(session, way)
    first, last = steps[0], steps[-1]
    climbing = pulse(session.time, first.leaves - 0.3, steps[1].leaves, last.lands - 0.2, last.lands + 0.45)
    for step in steps:
        _move_foot(session, plan, step, way, push_off=0.5 if step is first else 1.0)
    _move_pelvis(session, plan, steps, way)
    _shift_weight(session, plan, steps)
    _swing_arms(session, plan, steps, climbing)
    lean = session.degrees_between(*way.lean) * session.style.amplitude
    plan.chest_turn[:, 0] += lean * climbing
    plan.pelvis_turn[:, 0] += 0.4 * lean * climbing
    plan.pelvis[:, 2] -= (SLACK + session.between(*way.sink)) * climbing
    # people watch where they step
    plan.head_turn[:, 0] += session.degrees_between(*way.gaze) * climbing
    return plan


def _footfalls(session: Session, way: Way) -> list[_Step]:
    style, rng = session.style, session.rng
    # the weight shifts before the first foot leaves, the arms come to rest after the last has landed
    start, end = style.active[0] + 0.25, style.active[1] - 0.25
    foot_over_foot = rng.random() < way.over and abs(style.asymmetry) < ONE_SIDED
    count = max(
        4, round((end - start) * style.tempo / (way.step_s * (1.0 if foot_over_foot else 1.05 / 0.90)))
    )
    if not foot_over_foot:
        count += count % 2
    spans = np.exp(0.06 * np.clip(rng.standard_normal(count), -2.2, 2.2))
    spans[[0, -1]] *= 1.15
    times = start + (end - start) * np.concatenate([[0.0], np.cumsum(spans)]) / spans.sum()
    at, steps = [0, 0], []
    for index, (leaves, until) in enumerate(pairwise(times)):
        side = (style.side + index) % 2
        tread = min(index + 1, count - 1) if foot_over_foot else index // 2 + 1
        steps.append(_Step(side, leaves, leaves + _SWING * (until - leaves), at[side], tread))
        at[side] = tread
    return steps


def _move_foot(session: Session, plan: PosePlan, step: _Step, way: Way, push_off: float) -> None:
    """Heel off, swing up and over the edge, down on the tread with the forefoot leading a little."""
    phase = (session.time - step.leaves) / step.span
    treads = step.to_tread - step.from_tread
    clearance = session.between(*way.clearance) * session.style.amplitude
    ball = plan.balls[step.side]
    ball[:, 2] += (treads * way.rise + clearance) * stroke(phase, 0.0, 0.66) - clearance * stroke(
        phase, 0.62, 1.0
    )
    ball[:, 1] -= treads * way.run * stroke(phase, 0.26, 1.0)
    heel = push_off * session.degrees_between(*way.heel) * pulse(phase, -0.40, 0.24, 0.24, 0.78)
    heel -= np.radians(3.5) * pulse(phase, 0.5, 0.75, 0.75, 1.0)
    plan.heel_rise[step.side] += heel
    plan.toe_dip[step.side] += 0.6 * heel * pulse(phase, 0.0, 0.45, 0.8, 1.0)


def _move_pelvis(session: Session, plan: PosePlan, steps: list[_Step], way: Way) -> None:
    """Forward evenly, upward in waves as each foot that has landed takes the weight."""
    first, last = steps[0], steps[-1]
    treads, knots, ahead = [0, 0], [first.leaves - 0.30], [0.0]
    for step in steps:
        risen = step.to_tread - max(treads)
        treads[step.side] = step.to_tread
        knots.append(step.lands)
        ahead.append((min(treads) + 0.32 * (max(treads) - min(treads))) * way.run)
        if risen:
            start, end = step.lands - 0.06 * step.span, step.lands + 1.2 * step.span
            plan.pelvis[:, 2] += way.rise * stroke(session.time, start, end)
    knots.append(last.lands + 0.35)
    ahead.append(last.to_tread * way.run)
    forward = glide(session.time, np.array(knots), np.array(ahead), 0.13)
    plan.pelvis[:, 1] -= forward
    plan.grounded[:, 1] -= forward
    walks = pulse(session.time, first.leaves - 0.35, first.leaves, last.lands, last.lands + 0.4)
    plan.balance = 1.0 - walks


def _shift_weight(session: Session, plan: PosePlan, steps: list[_Step]) -> None:
    """Over the standing foot, with the pelvis turning and listing in the rhythm of the steps."""
    time, amplitude = session.time, session.style.amplitude
    first, last = steps[0], steps[-1]
    onto = [-SIGNS[step.side] for step in steps]
    middles = [step.middle for step in steps]
    over_foot = through(time, [first.middle - 0.65, *middles, last.lands + 0.1], [0.0, *onto, 0.0])
    half = session.style.stance * session.figure.hip_half_width
    plan.pelvis[:, 0] += plan.grounded[:, 0] + session.between(0.40, 0.60) * half * over_foot
    plan.pelvis_turn[:, 1] += session.degrees_between(1.0, 4.0) * amplitude * over_foot
    plan.chest_turn[:, 1] += session.degrees_between(0.5, 3.0) * amplitude * over_foot
    landings = [first.leaves - 0.1, *(step.lands for step in steps), last.lands + 0.5]
    foot_ahead = through(time, landings, [0.0, *onto, 0.0])
    plan.pelvis_turn[:, 2] += session.degrees_between(3.0, 7.0) * amplitude * foot_ahead
    plan.chest_turn[:, 2] -= session.degrees_between(1.5, 5.0) * amplitude * foot_ahead
    bob = np.sum([pulse(time, middle - 0.3, middle, middle, middle + 0.3) for middle in middles], axis=0)
    plan.chest_turn[:, 0] += session.degrees_between(0.5, 2.5) * bob


def _swing_arms(session: Session, plan: PosePlan, steps: list[_Step], climbing: np.ndarray) -> None:
    """Each arm goes forward with the other leg, its elbow bending more in front."""
    style = session.style
    knots = [steps[0].leaves, *(step.lands for step in steps), steps[-1].lands + 0.6]
    swings = through(session.time, knots, [0.0, *(SIGNS[step.side] for step in steps), 0.0])
    size = session.degrees_between(11.0, 22.0) * style.amplitude
    bend = session.degrees_between(12.0, 38.0)
    for side in (0, 1):
        forward = -SIGNS[side] * swings
        flexion = ARM_FORWARD + size * style.scales[side] * forward + 0.35 * bend * climbing
        shorter = 1.0 - 0.14 * bend * climbing * (1.0 + 0.5 * forward)
        plan.hands[side] = hang(session, flexion, style.arm_out, side) * shorter[:, None]
        plan.elbows[side] = elbow_pole(flexion, side)
