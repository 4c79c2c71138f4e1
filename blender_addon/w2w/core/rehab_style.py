# SPDX-License-Identifier: GPL-3.0-or-later
"""How one clip differs from the next, and the quiet stance that every exercise starts from."""

from __future__ import annotations

import numpy as np

from .rehab_curves import sway
from .rehab_fidgets import fidget
from .rehab_pose import PosePlan, reach
from .rehab_session import Session, Style
from .rehab_skeleton import SIGNS, Figure

ARM_FORWARD = np.radians(4.0)
"""How far hanging arms are in front of the vertical, radians."""

SLACK = 0.02
"""How much higher than the legs allow the pelvis is planned in stance, metres, so that the knees decide."""


def fill(session: Session, usual: float, least: int, rest: float) -> np.ndarray:
    """Share the active time out among repetitions of uneven length with pauses between.

    Parameters
    ----------
    session : Session
    usual : float
        Seconds one repetition and its pause take at tempo 1.
    least : int
        Fewest repetitions.
    rest : float
        Longest pause as a share of a repetition.

    Returns
    -------
    ndarray, shape (N, 2)
        Start and end of each repetition, seconds.
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

    Parameters
    ----------
    session : Session
        Gives the arm and the bend of its elbow.
    flexion, abduction : float or ndarray, shape (T,)
        Forward and sideways, radians; 0 hangs straight down.
    side : int
        0 left, 1 right.
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

    Parameters
    ----------
    session : Session

    Returns
    -------
    PosePlan
        To be changed by the exercise.
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
