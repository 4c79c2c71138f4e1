# SPDX-License-Identifier: GPL-3.0-or-later
"""What people do besides their exercise: look around, shift their weight, move a hand.

None of it belongs to one exercise more than to another, so none of it tells them apart.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .rehab_curves import pulse
from .rehab_pose import PosePlan
from .rehab_session import Session


def fidget(session: Session, plan: PosePlan) -> None:
    """Write glances, shifts of weight and movements of the hands into a plan.

    Parameters
    ----------
    session : Session
    plan : PosePlan
        Changed in place.
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
