# SPDX-License-Identifier: GPL-3.0-or-later
"""Raw 3D joint positions made into smooth paths of landmarks whose bones keep their lengths."""

from typing import NamedTuple

import numpy as np
from scipy.linalg import solveh_banded

from ..rotations import unit
from .joint_sets import SIDES, JointSet, mirrored

Points = dict[str, np.ndarray]
"""Paths (T, 3) or rest positions (3,) of landmarks by their names."""

LEGS = ("hip", "knee", "ankle", "toe")
ARMS = ("shoulder", "elbow", "wrist", "hand", "thumb side", "little finger side")

SWAP_COST = 1e-4
"""Cost of calling a frame swapped, as part of the squared size of the body: decides ties only."""

KNEES_SAY = 0.04
"""Knees that lie on average this far, in thigh lengths, in front of or behind the line from hip to ankle
show which way the person faces."""


def _undo_swaps(points: Points, size: float) -> Points:
    """Undo frames in which the arms or the legs changed sides.

    Takes, among all ways to call each frame swapped or not, the one along which the joints move least
    (Viterbi's algorithm), separately for arms and legs; the majority of frames is right.

    `points` holds a path (T, 3) a landmark, NaN where not seen; `size` is the trunk's length in their unit.
    """
    points = dict(points)
    for parts in (ARMS, LEGS):
        pairs = [(f"left {part}", f"right {part}") for part in parts]
        pairs = [pair for pair in pairs if all(np.isfinite(points[name]).any() for name in pair)]
        left, right = (np.stack([points[pair[side]] for pair in pairs], axis=1) for side in (0, 1))
        swapped = _smoothest(left, right, SWAP_COST * size**2)[:, None]
        if swapped.mean() > 0.5:
            swapped = ~swapped
        for index, (own, other) in enumerate(pairs):
            points[own] = np.where(swapped, right[:, index], left[:, index])
            points[other] = np.where(swapped, left[:, index], right[:, index])
    return points


def sides_are_exchanged(keypoints: np.ndarray, joint_set: JointSet) -> bool:
    """Whether left and right of joints (T, J, 3) are called the wrong way round throughout."""
    return _sides_are_exchanged(_landmarks(keypoints, joint_set))


def _sides_are_exchanged(points: Points) -> bool:
    """Whether left and right are called the wrong way round throughout, once single frames' swaps are undone.

    Knees bend forwards and toes and noses point there; forward follows from up and the left hip.
    """
    up = middle(points, "shoulder") - middle(points, "hip")
    forward = unit(np.cross(points["left hip"] - points["right hip"], up))
    evidence = []
    for side in SIDES:
        hip, knee, ankle = (points[f"{side} {part}"] for part in LEGS[:3])
        thigh, leg = np.maximum(np.linalg.norm(knee - hip, axis=1), 1e-12), ankle - hip
        along = unit(leg)
        offset = knee - hip - np.einsum("ta,ta->t", knee - hip, along)[:, None] * along
        evidence.append(np.einsum("ta,ta->t", offset, forward) / thigh)
        toe = points[f"{side} toe"]
        if np.isfinite(toe).any():
            evidence.append(np.einsum("ta,ta->t", toe - ankle, forward) / thigh)
    if np.isfinite(points["face"]).any() and np.isfinite(points["head"]).any():
        evidence.append(np.einsum("ta,ta->t", points["face"] - points["head"], forward) / np.nanmedian(thigh))
    seen = np.concatenate([values[np.isfinite(values)] for values in evidence])
    return len(seen) > 0 and float(seen.mean()) < -KNEES_SAY


def _smoothest(left: np.ndarray, right: np.ndarray, swap_cost: float) -> np.ndarray:
    """Frames in which left and right (T, L, 3) are to be exchanged; shape (T,), bool."""
    left, right = (_held(values) for values in (left, right))
    step = lambda a, b: ((b[1:] - a[:-1]) ** 2).sum(axis=(1, 2))  # noqa: E731
    stay = step(left, left) + step(right, right)
    change = step(left, right) + step(right, left)
    costs = np.array([0.0, swap_cost])
    came_from = np.zeros((len(left), 2), dtype=np.int8)
    for frame in range(1, len(left)):
        same, other = costs + stay[frame - 1], costs[::-1] + change[frame - 1]
        came_from[frame] = np.where(same <= other, (0, 1), (1, 0))
        costs = np.minimum(same, other) + (0, swap_cost)
    states = np.empty(len(left), dtype=bool)
    state = int(np.argmin(costs))
    for frame in range(len(left) - 1, -1, -1):
        states[frame] = state
        state = came_from[frame, state]
    return states


def _held(values: np.ndarray) -> np.ndarray:
    """Paths (T, L, 3) with each gap filled by the point before it, or at the start the first seen."""
    seen = np.isfinite(values).all(axis=2)
    latest = np.maximum.accumulate(np.where(seen, np.arange(len(values))[:, None], -1), axis=0)
    latest = np.where(latest < 0, seen.argmax(axis=0), latest)
    return np.take_along_axis(values, latest[:, :, None], axis=0)


LANDMARKS: tuple[str, ...] = (
    *(f"{side} {part}" for side in SIDES for part in (*LEGS, *ARMS)), "spine", "neck", "head", "face",
)  # fmt: skip

BONES: tuple[tuple[str, str], ...] = tuple(
    (f"{side} {start}", f"{side} {end}")
    for side in SIDES
    for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
)
"""Segments whose lengths are calibrated and kept."""

REQUIRED = tuple(f"{side} {part}" for side in SIDES for part in ("hip", "shoulder"))
LEAST_SEEN = 0.2
"""Hips and shoulders must be seen in at least this share of the frames."""

FILLED_WEIGHT = 0.02
"""Weight of a frame in which a joint is not seen, against 1: it is carried along with the hips."""

OUTLIER_FLOOR = 0.1
"""A joint this near to its smooth path, in trunk lengths, is no outlier."""

LENGTH_ROUNDS = 10


class Paths(NamedTuple):
    """Landmarks of one clip."""

    points: Points  # landmark -> smooth path (T, 3); landmarks never seen are not there
    lengths: dict[tuple[str, str], float]  # bone -> its length in the positions' unit, equal left and right
    trunk: float  # from between the hips to between the shoulders
    exchanged: bool  # whether left and right were called the wrong way round throughout


def landmark_paths(keypoints: np.ndarray, joint_set: JointSet, rate: float, cutoff_hz: float) -> Paths:
    """Clean and smooth the joints of a clip.

    Positions (T, J, 3) are in right-handed axes and any unit, NaN where a joint was not seen; at `cutoff_hz`
    the gain is a half. Raises ValueError if shapes disagree or the hips or shoulders are hardly ever seen.
    """
    points = _landmarks(keypoints, joint_set)
    hidden = [name for name in REQUIRED if np.isfinite(points[name]).all(axis=1).mean() < LEAST_SEEN]
    if hidden:
        raise ValueError(f"the {', '.join(hidden)} can hardly ever be seen: there is no body to fit")
    trunk = float(np.nanmedian(np.linalg.norm(middle(points, "shoulder") - middle(points, "hip"), axis=1)))
    if not trunk > 0:
        raise ValueError("the hips and the shoulders are at the same place: there is no body to fit")
    points = _undo_swaps(points, trunk)
    exchanged = _sides_are_exchanged(points)
    if exchanged:
        points = {name: points[mirrored(name)] for name in points}
    points = {name: path for name, path in points.items() if np.isfinite(path).any()}
    lengths = _bone_lengths(points)
    hips = _filled(middle(points, "hip"), 0.0)
    for name, path in points.items():
        weights = np.where(np.isfinite(path).all(axis=1), 1.0, FILLED_WEIGHT)
        points[name] = smooth_robustly(_filled(path, hips), weights, rate, cutoff_hz, OUTLIER_FLOOR * trunk)
    _keep_lengths(points, lengths)
    return Paths(points, lengths, trunk, exchanged)


def _landmarks(keypoints: np.ndarray, joint_set: JointSet) -> Points:
    keypoints = np.asarray(keypoints, dtype=np.float64)
    if keypoints.ndim != 3 or keypoints.shape[1:] != (len(joint_set.joints), 3) or len(keypoints) < 2:
        raise ValueError(
            f"joints of {joint_set.name} must have shape (T, {len(joint_set.joints)}, 3) with two frames or "
            f"more, not {keypoints.shape}"
        )
    keypoints = np.where(np.isfinite(keypoints).all(axis=2, keepdims=True), keypoints, np.nan)
    nowhere = np.full((len(keypoints), 3), np.nan)
    return {
        name: keypoints[:, list(members)].mean(axis=1) if (members := joint_set.members(name)) else nowhere
        for name in LANDMARKS
    }


def middle(points: Points, part: str) -> np.ndarray:
    """Halfway between left and right, shape (T, 3)."""
    return (points[f"left {part}"] + points[f"right {part}"]) / 2


def _bone_lengths(points: Points) -> dict[tuple[str, str], float]:
    """Median length of each bone over all frames and both sides."""
    lengths = {}
    for start, end in BONES:
        pairs = ((start, end), (mirrored(start), mirrored(end)))
        values = [np.linalg.norm(points[b] - points[a], axis=1) for a, b in pairs if {a, b} <= points.keys()]
        if np.isfinite(values).any():
            lengths[start, end] = float(np.nanmedian(values))
    return lengths


def _filled(path: np.ndarray, carrier: np.ndarray | float) -> np.ndarray:
    """A path whose gaps are bridged by straight lines relative to what carries the joint along."""
    offset = path - carrier
    seen = np.isfinite(offset).all(axis=1)
    frames = np.arange(len(path))
    return carrier + np.stack([np.interp(frames, frames[seen], offset[seen, axis]) for axis in range(3)], 1)


def _keep_lengths(points: Points, lengths: dict[tuple[str, str], float]) -> None:
    """Move both ends of each bone, in place, until it has its length in every frame."""
    for _ in range(LENGTH_ROUNDS):
        for (start, end), length in lengths.items():
            if not {start, end} <= set(points):
                continue
            bone = points[end] - points[start]
            now = np.linalg.norm(bone, axis=1, keepdims=True)
            share = 0.5 * (1 - length / np.maximum(now, 1e-9 * length))
            points[start] = points[start] + share * bone
            points[end] = points[end] - share * bone


OUTLIER_SIGMAS = 6.0
"""Residuals beyond this many robust standard deviations weigh nothing (Tukey's biweight)."""

ROBUST_ROUNDS = 3


def smooth(
    values: np.ndarray, weights: np.ndarray, rate: float, cutoff_hz: float, order: int = 3
) -> np.ndarray:
    """Penalised least squares along the first axis (T, ...), with a weight (T,) for each sample.

    Minimises sum w |s - y|^2 + (rate / 2 pi f0)^(2 k) sum |D^k s|^2 for differences of order k (Whittaker
    1923; Eilers 2003, doi:10.1021/ac034173t), with f0 = `cutoff_hz`. If all weights are 1 the gain is 1 /
    (1 + (f / f0)^(2 k)). There are two samples or more; values are finite, also where the weight is 0; at
    least k weights are positive.
    """
    n = len(values)
    order = min(order, n - 1)
    penalty = (rate / (2 * np.pi * cutoff_hz)) ** (2 * order)
    bands = penalty * _difference_bands(n, order)
    bands[0] += weights
    right = (weights[:, None] * values.reshape(n, -1)).astype(np.float64)
    return solveh_banded(bands, right, lower=True).reshape(values.shape)


def smooth_robustly(
    values: np.ndarray, weights: np.ndarray, rate: float, cutoff_hz: float, floor: float
) -> np.ndarray:
    """`smooth`, without regard for points (T, D) far off the path.

    No residual up to `floor`, in the unit of `values`, counts as far off.
    """
    path = smooth(values, weights, rate, cutoff_hz)
    trusted = weights
    for _ in range(ROBUST_ROUNDS):
        residual = np.linalg.norm(values - path, axis=1)
        spread = 1.4826 * np.median(residual[weights > 0])
        limit = max(OUTLIER_SIGMAS * spread, floor)
        renewed = weights * np.clip(1 - (residual / limit) ** 2, 0, 1) ** 2
        if (renewed > 0).sum() < 4 or np.allclose(renewed, trusted, atol=1e-3):
            break
        trusted = renewed
        path = smooth(values, trusted, rate, cutoff_hz)
    return path


def _difference_bands(n: int, order: int) -> np.ndarray:
    """Lower bands (order + 1, n) of D^T D for differences of an order over n samples."""
    stencil = np.array([1.0])
    for _ in range(order):
        stencil = np.convolve(stencil, [1, -1])
    bands = np.zeros((order + 1, n))
    for start in range(order + 1):
        for offset in range(order + 1 - start):
            bands[offset, start : n - order + start] += stencil[start] * stencil[start + offset]
    return bands
