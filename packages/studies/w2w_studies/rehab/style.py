# SPDX-License-Identifier: GPL-3.0-or-later
"""How one clip differs from the next, and the quiet stance that every exercise starts from."""

from collections.abc import Iterator

import numpy as np

from .curves import pulse, sway
from .pose import PosePlan
from .session import Session, Style
from .skeleton import SIGNS, Figure
from .two_bones import reach


def fidget(session: Session, plan: PosePlan) -> None:
    """Write glances, shifts of weight and movements of the hands into a plan.

    `plan`: changed in place.
    """
    normal = session.rng.standard_normal
    for moment in _moments(session, every=4.0):
        nod, turn = np.radians([5.0, 20.0]) * normal(2)
        plan.head_turn[:, 0] += nod * moment
        plan.head_turn[:, 2] += turn * moment
        plan.chest_turn[:, 2] += 0.2 * turn * moment
    for moment in _moments(session, every=5.0):
        aside, forward = [0.018, 0.008] * normal(2)
        plan.grounded += moment[:, None] * [aside, forward]
        # weight on one leg tips the pelvis to the other side
        plan.pelvis_turn[:, 1] -= 1.2 * aside * moment
        plan.chest_turn[:, 1] += np.radians(1.5) * normal() * moment
    for hand in plan.hand_sway:
        for moment in _moments(session, every=7.0):
            hand += moment[:, None] * (0.04 * normal(3))


def _moments(session: Session, every: float) -> Iterator[np.ndarray]:
    """Pulses at random times, one every so many seconds on average, shape (T,)."""
    time, rng = session.time, session.rng
    for _ in range(rng.poisson(session.style.duration / every)):
        begin = rng.uniform(-1.0, session.style.duration)
        rise, hold, fall = rng.uniform([0.5, 0.2, 0.5], [1.0, 2.0, 1.2])
        yield pulse(time, begin, begin + rise, begin + rise + hold, begin + rise + hold + fall)


SEAT_HEIGHT = 0.45
"""Height of the chair's seat, metres; clips vary it by up to 2.5 cm."""


def seated_pelvis(session: Session) -> tuple[float, float]:
    """y and z of the middle between the hip joints on the chair, with the ankles at y = 0; metres."""
    figure = session.figure
    # the hip joints are about 8 cm above the seat in a person of average size
    height = SEAT_HEIGHT + session.between(-0.025, 0.025) + 0.047 * figure.stature
    shank_lean = session.degrees_between(6.0, 17.0)
    knee_ahead = figure.shank * np.sin(shank_lean)
    knee_height = figure.ankle_height + figure.shank * np.cos(shank_lean)
    return -knee_ahead + float(np.sqrt(figure.thigh**2 - (knee_height - height) ** 2)), height


ARM_FORWARD = np.radians(4.0)
"""How far hanging arms are in front of the vertical, radians."""

SLACK = 0.02
"""How much higher than the legs allow the pelvis is planned in stance, metres, so that the knees decide."""


def fill(session: Session, usual: float, least: int, rest: float) -> np.ndarray:
    """Share the active time out among repetitions of uneven length with pauses between.

    `usual`: seconds one repetition and its pause take at tempo 1.
    `least`: fewest repetitions.
    `rest`: longest pause as a share of a repetition.
    Returns (N, 2): start and end of each repetition, seconds.
    """
    rng, (start, end) = session.rng, session.style.active
    count = max(least, round((end - start) * session.style.tempo / usual))
    moves = np.exp(0.09 * np.clip(rng.standard_normal(count), -2.2, 2.2))
    pauses = rng.uniform(0.0, rest, count) * moves
    pauses[-1] = 0.0
    ends = np.cumsum(moves + pauses)
    scale = (end - start) / ends[-1]
    return start + scale * np.column_stack([ends - moves - pauses, ends - pauses])


def hang(
    session: Session, flexion: np.ndarray | float, abduction: np.ndarray | float, side: int
) -> np.ndarray:
    """Wrist relative to the shoulder of an arm raised by two angles, shape (T, 3), metres.

    `session`: gives the arm and the bend of its elbow.
    `flexion`, `abduction` (T,): forward and sideways, radians; 0 hangs straight down.
    `side`: 0 left, 1 right.
    """
    figure = session.figure
    return reach(figure.upper_arm, figure.forearm, session.style.elbow_bend) * direction(
        flexion, abduction, side
    )


def direction(flexion: np.ndarray, abduction: np.ndarray, side: int) -> np.ndarray:
    """Unit vectors (T, 3) of an arm raised forward and sideways by two angles."""
    flexion, abduction = np.broadcast_arrays(flexion, abduction)
    return np.stack(
        [
            SIGNS[side] * np.sin(abduction),
            -np.sin(flexion) * np.cos(abduction),
            -np.cos(flexion) * np.cos(abduction),
        ],
        axis=-1,
    )


def elbow_pole(flexion: np.ndarray, side: int, outward: float = 0.35) -> np.ndarray:
    """Where the elbow of such an arm points: backward when it hangs, down when it is held out in front."""
    flexion = np.asarray(flexion, dtype=float)
    return np.stack([0 * flexion + SIGNS[side] * outward, np.cos(flexion), -np.sin(flexion)], axis=-1)


def stand_quietly(session: Session) -> PosePlan:
    """Upright stance with hanging arms, and the sway and fidgets of a living person.

    The exercise may change it.
    """
    figure, style, n = session.figure, session.style, len(session.time)
    noise = style.sway * sway(session.time, session.rng, 21)
    tilt, lean, look = (np.radians(size) * noise[:, k : k + 3] for size, k in ((0.35, 2), (0.7, 5), (1.0, 8)))
    balls, height = feet_together(figure, style, n)
    bends = style.knee_bend + np.radians(0.8) * noise[:, 17:19].T
    flexion = np.full(n, ARM_FORWARD)
    hands = np.stack([hang(session, flexion, style.arm_out, side) for side in (0, 1)])
    plan = PosePlan(
        pelvis=np.tile([0.0, -0.01 * figure.stature, height + SLACK], (n, 1)),
        pelvis_turn=tilt + style.pelvis,
        chest_turn=tilt + lean + style.trunk,
        head_turn=tilt + 0.3 * lean + look + style.gaze,
        balls=balls,
        heel_rise=np.zeros((2, n)),
        toe_dip=np.zeros((2, n)),
        foot_yaw=SIGNS * style.toe_out,
        knee_bend=bends,
        lifted=np.zeros((2, n)),
        hip_flexion=np.zeros((2, n)),
        knee_flexion=np.zeros((2, n)),
        hands=hands,
        hand_sway=0.007 * noise[:, 11:17].reshape(n, 2, 3).transpose(1, 0, 2),
        elbow_sway=np.radians(1.2) * noise[:, 19:].T,
        elbows=np.stack([elbow_pole(flexion, side) for side in (0, 1)]),
        arms_follow=np.full(n, 0.2),
        on_thighs=np.zeros((2, n)),
        pronation=np.full((2, n), np.radians(25.0)),
        grounded=[0.0, over_feet(figure)] + noise[:, :2] * [0.003, 0.005],
        balance=np.ones(n),
    )
    fidget(session, plan)
    return plan


def over_feet(figure: Figure) -> float:
    """y of the centre of mass of a person standing with the ankles at y = 0: some 4 cm ahead of them."""
    return -0.026 * figure.stature


def feet_together(figure: Figure, style: Style, n: int) -> tuple[np.ndarray, float]:
    """Balls of both feet, (2, n, 3), the ankles side by side at y = 0, and the height of the pelvis."""
    half = style.stance * figure.hip_half_width
    ahead = figure.ball_ahead * np.array([np.sin(style.toe_out), -np.cos(style.toe_out)])
    balls = np.empty((2, n, 3))
    balls[:, :, 0] = (SIGNS * (half + ahead[0]))[:, None]
    balls[:, :, 1] = ahead[1]
    balls[:, :, 2] = figure.ball_height
    leg = reach(figure.thigh, figure.shank, style.knee_bend)
    across = half - figure.hip_half_width
    return balls, figure.ankle_height + float(np.sqrt(leg**2 - across**2))
