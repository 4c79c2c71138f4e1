# SPDX-License-Identifier: GPL-3.0-or-later
"""How far patches lie apart over the skin, and from each other's mirror images."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.spatial import KDTree

from ..body.body import Body
from .patches import PatchSet
from .strip_graph import KEPT, StripGraph

FLIP = np.array([-1.0, 1.0, 1.0])
"""Left and right lie along x."""

AT_ONCE = 4
"""Sources from which distances are searched in one go, which lets no other thread work."""


@dataclass(frozen=True, eq=False)
class SkinDistances:
    """Geodesic distances between patches of a body at rest, metres; infinite between pieces of the mesh."""

    between: np.ndarray  # (N, N)
    to_mirror_image: np.ndarray  # (N, N), from the mirror image of the row's patch to the column's patch

    @classmethod
    def of(cls, body: Body, patches: PatchSet) -> SkinDistances:
        """Measure them; a body without a mirror map is reflected in its middle plane.

        The last few are kept, since they take seconds.
        """
        centres = np.asarray(patches.vertices)
        if body.mirror is None:
            images = KDTree(body.vertices).query(body.vertices[centres] * FLIP)[1]
        else:
            images = np.asarray(body.mirror)[centres]
        return _measured(StripGraph.of(body.vertices, body.faces), tuple(centres), tuple(images))


@lru_cache(maxsize=KEPT)
def _measured(graph: StripGraph, centres: tuple[int, ...], images: tuple[int, ...]) -> SkinDistances:
    ends = np.array(centres)
    distances = [_to(ends, graph, np.array(sources)) for sources in (centres, images)]
    for one in distances:
        one.flags.writeable = False
    return SkinDistances(*distances)


def _to(centres: np.ndarray, graph: StripGraph, sources: np.ndarray) -> np.ndarray:
    """Distances of centres from sources, some at a time: a window has its turn in between."""
    starts = range(0, len(sources), AT_ONCE)
    return np.concatenate([graph.distances(sources[at : at + AT_ONCE])[:, centres] for at in starts])
