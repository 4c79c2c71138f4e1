# SPDX-License-Identifier: GPL-3.0-or-later
"""Which bones of a chain without telling names are shoulder, elbow and wrist, or hip, knee and ankle.

Lengths are held against those of people, and turns against how limbs turn: a collar less than a shoulder, an
elbow not much more. Bones that stay in line between two joints are there for the twist.
"""

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import numpy as np

MOST_COST = 40.0
"""Squared deviations from a person's build and movement, of both arms and legs, above which none is meant."""

CLEARLY = 5.0
"""Joints are refused if others that make another limb cost only this much more."""

IN_LINE = 0.01
"""How far off a line the bones for the twist may be, of its length, as one standard deviation."""

TWIST_COST = 1.5
"""What each bone for the twist costs: most limbs have none."""

UNKNOWN_COST = 1.0
"""What the length of a hand or foot costs whose bones do not say it; a strange one costs nine at most."""

STIFF = 5.0
"""Degrees below which bones hardly turn."""

USUALLY, SPREAD = np.array([-0.6, 0.5, 0.3]), np.array([0.8, 0.6, 0.6])
"""Logarithm of how much more a collar turns than the shoulder, an elbow, and a wrist than the elbow."""

Likely = tuple[float, float]
"""The likeliest value of a ratio, and the standard deviation of its logarithm."""


class Build(NamedTuple):
    """Ratios of a limb's lengths: of the 249 different skeletons with names at hand, rounded."""

    length: Likely  # both segments, against a length of the rest of the body
    upper: Likely  # against the lower one
    end: Likely  # from the last joint to the next bone, against the lower segment
    aside: Likely  # half of the distance between both limbs, against the body's length
    reach: float  # standard deviation of the way from the trunk to the first joint, of both segments


ARM_BUILD = Build((0.6, 0.25), (1.08, 0.16), (0.38, 0.5), (0.17, 0.4), np.inf)
LEG_BUILD = Build((1.6, 0.35), (1.0, 0.12), (0.33, 0.5), (0.17, 0.6), 0.25)
"""An arm against the leg's length, and a leg against the trunk's."""

Joints = tuple[int, int, int]


class Limb(NamedTuple):
    """Bones of a limb, after the one that it hangs on."""

    heads: np.ndarray  # (T, n + 1, 3)
    turns: np.ndarray  # (n + 1,), farthest that each turns against its parent, degrees


def limb_joints(both: Sequence[Limb], build: Build, size: float) -> tuple[Joints, float, bool]:
    """Places in two chains of equal length of a limb's joints, their cost, and whether they are clear.

    `size` is the length that the build's ratios are against. The last joint is not held to be unclear: bones
    that stay in line with the lower segment turn as it does.
    """
    n_bones = both[0].heads.shape[1] - 1
    places = np.array(list(combinations(range(1, n_bones + 1), 3)))
    aside = np.linalg.norm(both[0].heads - both[1].heads, axis=-1)
    costs = _deviation(np.median(aside, axis=0)[places[:, 0]] / 2 / size, build.aside)
    costs += np.mean([_costs(limb, places, build, size) for limb in both], axis=0)
    best = int(costs.argmin())
    others = costs[(places[:, :2] != places[best, :2]).any(axis=1)]
    first, second, third = (places[best] - 1).tolist()
    return (first, second, third), float(costs[best]), bool((others > costs[best] + CLEARLY).all())


def _deviation(ratios: np.ndarray, likely: Likely) -> np.ndarray:
    """Squared standard deviations between ratios and the likeliest one."""
    return (np.log(np.maximum(ratios, 1e-9) / likely[0]) / likely[1]) ** 2


def _costs(limb: Limb, places: np.ndarray, build: Build, size: float) -> np.ndarray:
    """Cost of each choice of three joints, shape (N,)."""
    first, second, third = places.T
    far = np.linalg.norm(limb.heads[:, :, None] - limb.heads[:, None], axis=-1)
    far = np.maximum(np.median(far, axis=0), 1e-9 * size)
    upper, lower = far[first, second], far[second, third]
    end = np.append(np.diagonal(far, 1), 0.0)[third]
    costs = _deviation((upper + lower) / size, build.length) + _deviation(upper / lower, build.upper)
    costs += np.where(end > 0, np.minimum(_deviation(end / lower, build.end), 9), UNKNOWN_COST)
    costs += (far[0, first] / (upper + lower) / build.reach) ** 2 + TWIST_COST * (third - first - 2)
    off = np.array([[_off_line(limb.heads, a, b) for b in range(len(far))] for a in range(len(far))])
    costs += off[first, second] + off[second, third]
    return costs + _movement(limb.turns, first, second, third)


def _off_line(heads: np.ndarray, start: int, end: int) -> float:
    """Cost of bones between two joints that are off the line from one to the other in any frame."""
    if end - start < 2:
        return 0.0
    line = heads[:, end] - heads[:, start]
    length = np.maximum(np.linalg.norm(line, axis=-1), 1e-12)
    aside = np.cross(heads[:, start + 1 : end] - heads[:, start, None], line[:, None])
    off = np.linalg.norm(aside, axis=-1) / length[:, None] ** 2
    return float((off.max() / IN_LINE) ** 2)


def _movement(turns: np.ndarray, first: np.ndarray, second: np.ndarray, third: np.ndarray) -> np.ndarray:
    """Costs (N,) of joints that turn less than what comes before them or after them, as no person's do."""
    from_each = np.where(np.tri(len(turns), dtype=bool).T, turns, 0.0)
    widest = np.maximum.accumulate(from_each, axis=1)  # of the bones from one to another
    upper, middle, lower = turns[first], widest[first + 1, second], widest[second + 1, third]
    more = np.log(np.stack([widest[1, first - 1], middle, lower]) + STIFF)
    more -= np.log(np.stack([upper, upper, middle]) + STIFF)
    costs = np.maximum((more.T - USUALLY) / SPREAD, 0) ** 2
    costs[:, 0] *= first > 1  # else nothing is before
    return costs.sum(axis=1)
