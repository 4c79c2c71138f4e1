# SPDX-License-Identifier: GPL-3.0-or-later
"""A run-up in which no limb sinks into the body: nobody recorded it, so cloth must not catch in it.

It reaches back from a clip's first pose at that pose's speed, up to a radian a joint: legs that swing past
each other may be through each other there, and arms in the trunk.
"""

from __future__ import annotations

from ...core.body.body import Body
from ...core.garments.run_up import reached_back
from ...core.motion.motion import Motion
from .overlap import ARM, LEG, closed, inside, limb, moved_by, pushed_out, trunk

REACHES = (1.0, 0.5, 0.25, 0.125)
"""How far a run-up may reach back, of its whole length: from the calmest to the shortest."""

AS_CLEAR = 0.01
"""Share of the vertices looked at by which more may be sunk than in the clip's first pose."""


def clear_reach(body: Body, motion: Motion) -> float:
    """The longest of `REACHES` with hardly more overlap than the clip's first pose has; else the shortest.

    Parameters
    ----------
    body : Body
    motion : Motion
        As the body is to move.
    """
    bearable = None
    for reach in REACHES:
        poses = reached_back(motion, reach)
        sunk, of = _sunk(body, poses)
        if bearable is None:
            bearable = sunk[-1] + AS_CLEAR * of
        if max(sunk) <= bearable:
            return reach
    return REACHES[-1]


def _sunk(body: Body, poses: Motion) -> tuple[list[int], int]:
    """Vertices sunk in each pose, of how many: arms in the rest of the body, one leg in the other."""
    sunk, of = [0] * poses.n_frames, 0
    trunks, left_legs = (closed(body, part, poses) for part in (trunk(body), moved_by(body, "left", LEG)))
    for trees, side, joints in ((trunks, "left", ARM), (trunks, "right", ARM), (left_legs, "right", LEG)):
        vertices = limb(body, side, joints)
        of += len(vertices)
        points = pushed_out(body, vertices, poses)
        for number, (tree, own) in enumerate(zip(trees, points, strict=True)):
            sunk[number] += inside(tree, own)
    return sunk, of
