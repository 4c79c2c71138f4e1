# SPDX-License-Identifier: GPL-3.0-or-later
"""Segments of a body between landmarks that can be felt, and per cents along and around them.

After the proposal of Shirazi et al. (2024, arXiv:2412.21159): its landmarks and segments, but around a limb
as a tape runs, not across a box. Per cents along run from the proximal landmark, 0, to the distal one, 100,
by projection on the segment's axis; less than 0 and more than 100 lie beyond. Per cents around are of the
circumference (of the convex outline, as a tape's), from the front over the outer side; on the head, neck and
trunk over the left side. The front of forearm and hand is the palm's side, and that of the foot its top.

Unlike the proposal, a hand ends at the fingertips, a head begins at the chin, and the trunk below the navel
is a segment of its own, the pelvis.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import ConvexHull, QhullError

from ..body.body import JOINT_INDEX, Body, edges_of, template
from ..body.landmarks import SensorSite
from ..body.regions import regions_of
from ..body.shapes import bundled_targets
from ..rotations import frame_of
from .body_parts import PARTS, SIDES, great_part, side_of

_DATA: dict[str, Any] = template("tape_segments.json")
SEGMENTS: dict[str, dict[str, Any]] = _DATA["segments"]
"""Segments by name, head to foot; the file says what their fields mean."""

MIDDLE = ("head", "neck", "chest", "abdomen", "pelvis")
"""Segments that have no left and right."""

SEGMENT_NAMES = (*MIDDLE, *(f"{side} {name}" for side in SIDES for name in SEGMENTS if name not in MIDDLE))
"""All 17: the proposal's 16 and the pelvis."""

LEVELS, TURNS = 48, 240
"""Sections along a segment, and directions around it, at which circumferences are measured."""

MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True, eq=False)
class Segment:
    """One segment of one body: its axis and its outlines."""

    vertices: np.ndarray  # (K,), of the body, that belong to it
    origin: np.ndarray  # (3,), a point of the axis
    axes: np.ndarray  # (3, 3): rows towards the distal end, the front and the outer side, unit vectors
    start: float  # the proximal landmark on the axis, metres from the origin
    length: float  # between the landmarks, metres
    edges: np.ndarray  # (E, 2, 3), ends of the edges of its skin, in its axes from the origin
    levels: np.ndarray  # (L,), sections, in metres along the axis from the origin

    @cached_property
    def _outlines(self) -> tuple[np.ndarray, np.ndarray]:
        """Circumference of each section (L,), metres, and share of it up to each direction (L, TURNS + 1).

        They are found when a place on the segment is measured: all 17 segments' take half a second.
        """
        found = {row: outline for row, at in enumerate(self.levels) if (outline := _outline(self.edges, at))}
        usable = np.array(list(found))
        nearest = [found[usable[np.abs(usable - row).argmin()]] for row in range(LEVELS)]
        return np.array([girth for girth, _ in nearest]), np.array([share for _, share in nearest])

    def coordinates(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Per cents along and around of points (P, 3)."""
        ahead, front, outer = self.axes @ (points - self.origin).T
        level = np.interp(ahead, self.levels, np.arange(len(self.levels)))
        turn = np.arctan2(outer, front) / (2 * np.pi) % 1 * TURNS
        share = map_coordinates(self._outlines[1], [level, turn], order=1)
        return 100 * (ahead - self.start) / self.length, 100 * share

    def girth(self, along: float) -> float:
        """Circumference at a per cent along, metres."""
        return float(np.interp(self.start + along / 100 * self.length, self.levels, self._outlines[0]))


@lru_cache(maxsize=4)
def segments_of(body: Body) -> dict[str, Segment]:
    """All segments of a body by name; the last few bodies' are kept.

    Raises ValueError if a segment, or a region in which a landmark lies, is not found on the body.
    """
    # on shapes of the bundled body they are the same vertices as on the bundled body
    landmarks = _bundled_landmarks() if bundled_targets().fit(body) else _landmarks(body)
    marks = {name: body.vertices[vertex] for name, vertex in landmarks.items()}
    owner = _owners(body, marks)
    return {name: _segment(body, name, marks, np.flatnonzero(owner == name)) for name in SEGMENT_NAMES}


@lru_cache(maxsize=1)
def _bundled_landmarks() -> dict[str, int]:
    return _landmarks(Body.bundled())


def _landmarks(body: Body) -> dict[str, int]:
    """Vertex of each landmark, those of the limbs on the left and on the right."""
    vertex_of = {}
    for name, given in _DATA["landmarks"].items():
        for side in SIDES:
            vertex_of[f"{side} {name}"] = _landmark(body, given, side)
    return vertex_of


def _landmark(body: Body, given: dict[str, Any], side: str) -> int:
    direction = np.array(given["direction"]) * (MIRROR if side == "right" else 1)
    if "region" in given:
        codes, names = regions_of(body)
        region = given["region"].replace("left", side)
        if region not in names:
            raise ValueError(f"this body has no {region}, so its tape measures cannot be found")
        members = np.flatnonzero(codes == names.index(region))
        return int(members[np.argmax(body.vertices[members] @ direction)])
    start, end = (tuple(joint.replace("left", side) for joint in given[key]) for key in ("start", "end"))
    return SensorSite("", None, start, end, given["fraction"], tuple(direction)).vertex(body)


def _frame(body: Body, name: str, middle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Origin, and axes as `Segment` has them; `middle` is that of the segment's vertices."""
    side, rest = side_of(name)
    given = SEGMENTS[rest]
    flip = MIRROR if side == "right" else np.ones(3)
    if "bone" in given:
        ends = [JOINT_INDEX[joint.replace("left", side)] for joint in given["bone"]]
        middle, axis = body.joints[ends[0]], np.subtract(*body.joints[ends[::-1]])
    else:
        axis = np.array(given["axis"], dtype=float)
    front, outer, axis = frame_of(given["front"] * flip, axis).T
    return middle, np.stack([axis, front, outer * np.sign(outer @ (given["outer"] * flip))])


def _scale(
    name: str, origin: np.ndarray, axes: np.ndarray, marks: dict[str, np.ndarray]
) -> tuple[float, float]:
    """Place of the proximal landmark on the axis, and metres from there to the distal one."""
    side, rest = side_of(name)
    start, end = (
        float((marks[f"{side or 'left'} {SEGMENTS[rest][key]}"] - origin) @ axes[0]) for key in ("from", "to")
    )
    return start, end - start


def _owners(body: Body, marks: dict[str, np.ndarray]) -> np.ndarray:
    """Name of the segment that each vertex belongs to, shape (V,)."""
    codes, names = regions_of(body)
    parts = np.array([great_part(name) for name in names])[codes]
    top = np.array([side_of(name)[1] == "shoulder top" for name in names])[codes]
    foot = np.array([side_of(name)[1] in PARTS["foot"] for name in names])[codes]

    def along(name: str) -> np.ndarray:
        origin, axes = _frame(body, name, np.zeros(3))
        start, length = _scale(name, origin, axes, marks)
        return ((body.vertices - origin) @ axes[0] - start) / length

    owner = np.where(np.isin(parts, ["head", "neck"]), parts, "x" * 16)
    for side in SIDES:
        arm, leg = parts == f"{side} arm", parts == f"{side} leg"
        forearm = along(f"{side} forearm")
        owner[arm] = f"{side} forearm"
        owner[arm & (forearm < 0)] = f"{side} upper arm"
        owner[arm & (forearm > 1)] = f"{side} hand"
        # between neck and shoulder tip it is the chest's, as in the proposal
        parts[arm & top & (along(f"{side} upper arm") < 0)] = "torso"
        owner[leg] = np.where(along(f"{side} lower leg")[leg] < 0, f"{side} thigh", f"{side} lower leg")
        owner[leg & foot] = f"{side} foot"
    below = np.where(along("pelvis") > 0, "pelvis", np.where(along("chest") < 1, "chest", "abdomen"))
    return np.where(parts == "torso", below, owner)


def _segment(body: Body, name: str, marks: dict[str, np.ndarray], members: np.ndarray) -> Segment:
    if len(members) == 0:
        raise ValueError(f"this body has no {name}, so its tape measures cannot be found")
    points = body.vertices[members]
    origin, axes = _frame(body, name, (points.min(axis=0) + points.max(axis=0)) / 2)
    edges = edges_of(body.faces)
    ends = (body.vertices[edges[np.isin(edges, members).any(axis=1)]] - origin) @ axes.T
    reach = (points - origin) @ axes[0]
    levels = np.linspace(reach.min(), reach.max(), LEVELS)
    return Segment(members, origin, axes, *_scale(name, origin, axes, marks), ends, levels)


def _outline(ends: np.ndarray, level: float) -> tuple[float, np.ndarray] | None:
    """Circumference of the convex outline of a section, and the share of it up to each direction.

    None if the axis does not run through it. `ends` (E, 2, 3) are those of edges, in the segment's axes.
    """
    before, after = ends[:, 0, 0] - level, ends[:, 1, 0] - level
    crossing = before * after < 0
    part = before[crossing] / (before - after)[crossing]
    points = ends[crossing, 0, 1:] + part[:, None] * (ends[crossing, 1, 1:] - ends[crossing, 0, 1:])
    try:
        sides = ConvexHull(points).equations if len(points) > 2 else np.ones((1, 3))
    except QhullError:
        return None
    if sides[:, 2].max() > -1e-3:  # metres that the axis is inside of each side
        return None
    angles = np.linspace(0, 2 * np.pi, TURNS + 1)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    facing = rays @ sides[:, :2].T
    reach = np.where(facing > 1e-9, -sides[:, 2] / np.maximum(facing, 1e-9), np.inf).min(axis=1)
    steps = np.linalg.norm(np.diff(rays * reach[:, None], axis=0), axis=1)
    return float(steps.sum()), np.concatenate([[0], steps.cumsum() / steps.sum()])
