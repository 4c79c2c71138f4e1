# SPDX-License-Identifier: GPL-3.0-or-later
"""Points of a body by landmarks: sensors of published methods, and places that are not a region's middle."""

import hashlib
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..rotations import unit
from .body import JOINT_INDEX, Body, template

SMPL_FACES_SHA256 = "9e96e167056f19d9dc0fe3533177ebd5230b203297c219cab15e9e72b313aed1"
"""Digest of SMPL's triangles (see `has_smpl_topology`): the vertices that are joined, not their positions."""


@dataclass(frozen=True)
class SensorSite:
    """A point of the skin by its place between joints, on any body."""

    name: str  # of a published method's virtual sensor, method and place: "TransPose left forearm"
    smpl_vertex: int | None  # vertex of SMPL that the method's code reads
    start: tuple[str, ...]  # joints between which it lies; the middle of several
    end: tuple[str, ...]
    fraction: float  # how far from `start` to `end`
    # from there to the skin, in the axes of the T-pose (left, back, up)
    direction: tuple[float, float, float]

    def vertex(self, body: Body) -> int:
        """Vertex of the site: the published one on SMPL's mesh, the nearest equivalent on others."""
        if self.smpl_vertex is not None and has_smpl_topology(body):
            return self.smpl_vertex
        start, end = (
            body.joints[[JOINT_INDEX[joint] for joint in joints]].mean(axis=0)
            for joints in (self.start, self.end)
        )
        spoke = body.vertices - (start + self.fraction * (end - start))
        direction = unit(np.array(self.direction))
        ahead = spoke @ direction
        aside = np.linalg.norm(spoke - ahead[:, None] * direction, axis=1)
        # where the ray leaves the body: near the ray, ahead of the bone and not beyond another part
        near = (ahead > 0) & (aside < 0.02 * body.height) & (ahead < 0.15 * body.height)
        return int(np.argmin(np.where(near, aside, np.inf)))


def _site(name: str, given: dict[str, Any]) -> SensorSite:
    start, end, direction = (tuple(given[part]) for part in ("start", "end", "direction"))
    return SensorSite(name, given["vertex"], start, end, given["fraction"], direction)


_SITES = template("sensor_sites.json")

SENSOR_SITES = tuple(
    _site(f"{method} {name}", given)
    for group in _SITES["methods"]
    for method in group["sources"]
    for name, given in group["sites"].items()
)
"""Vertices that the published code of some methods reads as sensors; the file names the papers."""

PLACES = tuple(_site(name, given) for name, given in _SITES["places"].items())
"""Where sensors sit in regions whose middle is elsewhere.

A watch lies at the joint, where the skin follows forearm and hand; the instep is the top of the arch, and
the region reaches to the ball of the foot; the sacrum's flat back is some 8 cm above the hip joints, and
the region reaches down between the buttocks.
"""


@lru_cache(maxsize=8)
def has_smpl_topology(body: Body) -> bool:
    """Whether a body's triangles are SMPL's, vertex by vertex, in any order."""
    faces = np.asarray(body.faces, dtype=np.int64)
    if faces.shape != (13776, 3):
        return False
    start = faces.argmin(axis=1)[:, None]
    turned = np.take_along_axis(faces, (start + np.arange(3)) % 3, axis=1)
    listed = turned[np.lexsort(turned.T[::-1])].astype("<i4")
    return hashlib.sha256(listed.tobytes()).hexdigest() == SMPL_FACES_SHA256
