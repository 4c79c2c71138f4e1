# SPDX-License-Identifier: GPL-3.0-or-later
"""A garment through a clip, frame by frame: where its sensors are, and whether its cloth holds together."""

from __future__ import annotations

import bpy
import numpy as np

from ...core.garments.caught import RestLengths
from ...core.garments.cover import Cover
from ..body import matrix, rest_vertices
from ..evaluated import EvaluatedVertices

FARTHEST = 3.0
"""Metres between a sensor and the middle of all beyond which cloth has flown apart."""


class Followed:
    """Corners of the triangles that carry a garment's sensors, and how often its cloth had caught.

    Parameters
    ----------
    item : Object
        The garment.
    own : Cover
    n_frames : int
        Of the clip.

    Attributes
    ----------
    corners : ndarray, shape (n_frames, K, 3, 3)
    caught : int
        Frames in which it had; what is not simulated never does.
    """

    def __init__(self, item: bpy.types.Object, own: Cover, n_frames: int) -> None:
        self.corners = np.empty((n_frames, *own.triangles.shape, 3))
        self.caught = 0
        self._item, self._own = item, own
        self._vertices = EvaluatedVertices(item, own.triangles)
        self._lengths = _rest_lengths(item) if simulated(item) else None

    def take(self, number: int) -> None:
        """Take the scene's frame as this one of the clip.

        Raises
        ------
        ValueError
            If the cloth has flown apart.
        """
        if self._lengths is None:
            self.corners[number] = self._vertices.positions()
        else:
            points = self._vertices.everywhere()
            self.corners[number] = points[self._own.triangles]
            self.caught += self._lengths.caught(points)
        _refuse_flown(self._item, self.corners[number])


def simulated(item: bpy.types.Object) -> list[bpy.types.Modifier]:
    """Modifiers that simulate from frame to frame."""
    return [modifier for modifier in item.modifiers if getattr(modifier, "point_cache", None) is not None]


def _rest_lengths(item: bpy.types.Object) -> RestLengths:
    """Of its edges, metres."""
    edges = np.empty((len(item.data.edges), 2), dtype=np.int32)
    item.data.edges.foreach_get("vertices", edges.ravel())
    return RestLengths(rest_vertices(item) @ matrix(item.matrix_world)[:3, :3].T, edges)


def _refuse_flown(item: bpy.types.Object, corners: np.ndarray) -> None:
    points = corners.reshape(-1, 3)
    if not len(points):
        return
    if not np.isfinite(points).all() or np.abs(points - np.median(points, axis=0)).max() > FARTHEST:
        raise ValueError(
            f"the cloth of '{item.name}' flew apart in this clip: raise the quality steps of its "
            "cloth, or take it off"
        )
