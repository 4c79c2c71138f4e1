# SPDX-License-Identifier: GPL-3.0-or-later
"""Nearly exact geodesic distances: Dijkstra's on a mesh's edges and straight lines over its triangles.

Along edges alone the ways zigzag and are 5 % too long on average. The graph also joins vertices
by the straight lines that run over strips of triangles unfolded into the plane. Distances between patches,
and from the mirror images of patches, are `SkinDistances`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import KDTree

from ..body.body import Body

CROSSINGS = 3
"""Edges a straight line of the graph may cross: 3 leave 0.6 % of mean error."""

KEPT = 2
"""Meshes whose graphs are kept."""


@dataclass(frozen=True, eq=False)
class StripGraph:
    """Nearly exact geodesic distances: shortest ways along straight lines over strips of triangles.

    Its distances are lengths of real ways on the surface, hence never below the exact ones.
    """

    graph: csr_matrix  # (V, V), symmetric lengths, metres

    @classmethod
    def of(cls, vertices: np.ndarray, faces: np.ndarray, crossings: int = CROSSINGS) -> StripGraph:
        """Build the graph of a mesh; the last few are kept, since it takes a second."""
        return _graph(np.asarray(vertices, float).tobytes(), np.asarray(faces, np.int64).tobytes(), crossings)

    def distances(
        self, sources: int | np.ndarray, limit: float = np.inf, nearest: bool = False
    ) -> np.ndarray:
        """Distances from one source, shape (V,), or several, shape (S, V); inf beyond `limit`.

        With `nearest`, only the distance to the nearest of the sources, shape (V,).
        """
        return dijkstra(self.graph, indices=sources, limit=limit, min_only=nearest)

    def neighbourhoods(self, centres: np.ndarray, reach: float, count: int) -> Iterator[np.ndarray]:
        """Vertices within `reach` of each centre, nearest first, or the `count` nearest if those are more."""
        for centre, distance in zip(centres, self.distances(centres, limit=reach), strict=True):
            within = int(np.isfinite(distance).sum())
            found = distance
            for wider in (4 * reach, np.inf):
                if np.isfinite(found).sum() < count:
                    found = self.distances(centre, limit=wider)
            near = np.flatnonzero(np.isfinite(found))
            yield near[np.argsort(found[near], kind="stable")][: max(within, count)]

    def nearest(self, centres: np.ndarray) -> np.ndarray:
        """Position in `centres` of the one nearest to each vertex, shape (V,), int32.

        Raises ValueError if a piece of the mesh holds none of them.
        """
        sources = dijkstra(self.graph, indices=centres, min_only=True, return_predecessors=True)[2]
        if (sources < 0).any():
            raise ValueError(f"the body is of {self.n_pieces} separate pieces: each needs a placement")
        position = np.zeros(self.graph.shape[0], dtype=np.int32)
        position[centres] = np.arange(len(centres))
        return position[sources]

    @cached_property
    def n_pieces(self) -> int:
        """Number of separate pieces of the mesh."""
        return int(connected_components(self.graph, directed=False, return_labels=False))


@lru_cache(maxsize=KEPT)
def _graph(vertices: bytes, faces: bytes, crossings: int) -> StripGraph:
    places = np.frombuffer(vertices).reshape(-1, 3)
    return StripGraph(straight_lines(places, np.frombuffer(faces, np.int64).reshape(-1, 3), crossings))


def straight_lines(vertices: np.ndarray, faces: np.ndarray, crossings: int) -> csr_matrix:
    """Edges of a mesh and the straight lines between vertices across unfolded strips of triangles.

    From every vertex, triangles are unfolded into its plane across at most `crossings` edges; the vertex at
    the far end of a strip is joined if the line to it stays inside the strip. Faces are consistently
    oriented; lengths (V, V) are symmetric.
    """
    n_vertices = len(vertices)
    strips = _Strips(vertices, faces)
    lines = [strips.edges(), *(strips.unfold() for _ in range(crossings))]
    source, target, length = (np.concatenate(column) for column in zip(*lines, strict=True))
    source, target, length = np.r_[source, target], np.r_[target, source], np.r_[length, length]
    order = np.lexsort((length, target, source))
    source, target, length = source[order], target[order], length[order]
    shortest = np.r_[True, (source[1:] != source[:-1]) | (target[1:] != target[:-1])]
    entries = (length[shortest], (source[shortest], target[shortest]))
    return coo_matrix(entries, shape=(n_vertices, n_vertices)).tocsr()


class _Strips:
    """All strips of triangles growing from the mesh's corners, unfolded into the plane at once.

    A strip starts at vertex `source` (the plane's origin); `right` -> `left` is the edge it would
    cross next, and the rays `low` and `high` bound what is visible from the source through it.
    """

    def __init__(self, vertices: np.ndarray, faces: np.ndarray) -> None:
        self.vertices = vertices
        sides = np.concatenate([faces, faces[:, [1, 2, 0]], faces[:, [2, 0, 1]]]).astype(np.int64)
        keys = sides[:, 0] * len(vertices) + sides[:, 1]
        order = np.argsort(keys, kind="stable")
        self._keys, self._apexes = keys[order], sides[order, 2]
        right, left, source = sides.T
        to_right, to_left = self._length(source, right), self._length(source, left)
        x = (to_right**2 + to_left**2 - self._length(right, left) ** 2) / (2 * to_right)
        right_at = np.stack([to_right, np.zeros_like(x)], axis=1)
        left_at = np.stack([x, np.sqrt(np.maximum(to_left**2 - x**2, 0))], axis=1)
        self.corners = np.stack([source, right, left])  # (3, S), vertices
        self.places = np.stack([right_at, left_at, right_at, left_at])  # (4, S, 2): right, left, low, high

    def edges(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The mesh's own edges: from, to, length."""
        return self.corners[0], self.corners[1], np.linalg.norm(self.places[0], axis=1)

    def unfold(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Grow every strip by one triangle; the lines to new vertices that are in sight."""
        keys = self.corners[2] * len(self.vertices) + self.corners[1]
        slots = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        apex, inside = self._apexes[slots], self._keys[slots] == keys  # the triangle beyond the edge, if any
        self.corners, self.places, apex = self.corners[:, inside], self.places[:, inside], apex[inside]
        source, right, left = self.corners
        right_at, left_at, low, high = self.places
        at = self._place(apex)
        above, below = _cross(low, at), _cross(at, high)
        # go on across both far edges of the new triangle, as far as they are in sight
        lowered = np.where((below > 0)[:, None], at, high)
        raised = np.where((above > 0)[:, None], at, low)
        to_right, to_left = _cross(low, lowered) > 0, _cross(raised, high) > 0
        ends = np.stack([source, right, apex]), np.stack([source, apex, left])
        rays = np.stack([right_at, at, low, lowered]), np.stack([at, left_at, raised, high])
        self.corners = np.concatenate([ends[0][:, to_right], ends[1][:, to_left]], axis=1)
        self.places = np.concatenate([rays[0][:, to_right], rays[1][:, to_left]], axis=1)
        seen = (above >= 0) & (below >= 0)
        return source[seen], apex[seen], np.linalg.norm(at[seen], axis=1)

    def _place(self, apex: np.ndarray) -> np.ndarray:
        """Place of the apex in the plane, on the far side of the edge."""
        _, right, left = self.corners
        base = self.places[1] - self.places[0]
        length = np.linalg.norm(base, axis=1, keepdims=True)
        along = base / length
        outward = np.stack([along[:, 1], -along[:, 0]], axis=1)
        spoke = self.vertices[apex] - self.vertices[right]
        edge = self.vertices[left] - self.vertices[right]
        foot = np.einsum("ij,ij->i", spoke, edge)[:, None] / length
        height = np.sqrt(np.maximum(np.einsum("ij,ij->i", spoke, spoke)[:, None] - foot**2, 0))
        return self.places[0] + along * foot + outward * height

    def _length(self, first: np.ndarray, second: np.ndarray) -> np.ndarray:
        return np.linalg.norm(self.vertices[first] - self.vertices[second], axis=1)


def _cross(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    return first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]


AT_ONCE = 4
"""Sources from which distances are searched in one go, which lets no other thread work."""


@dataclass(frozen=True, eq=False)
class SkinDistances:
    """Geodesic distances between patches of a body at rest, metres; infinite between pieces of the mesh.

    Those beyond a reach are infinite, too, from places that have a patch within half of it.
    """

    between: np.ndarray  # (N, N)
    to_mirror_image: np.ndarray  # (N, N), from the mirror image of the row's patch to the column's patch

    @classmethod
    def of(cls, body: Body, centres: np.ndarray, reach: float = np.inf) -> SkinDistances:
        """Measure those up to a reach between patches centred at vertices (N,) of a body.

        A body without a mirror map is reflected in its middle plane.
        The last few are kept, since they take seconds.
        """
        if body.mirror is None:
            images = KDTree(body.vertices).query(body.vertices[centres] * [-1, 1, 1])[1]
        else:
            images = body.mirror[centres]
        return _measured(StripGraph.of(body.vertices, body.faces), tuple(centres), tuple(images), reach)


@lru_cache(maxsize=KEPT)
def _measured(
    graph: StripGraph, centres: tuple[int, ...], images: tuple[int, ...], reach: float
) -> SkinDistances:
    distances = []
    for sources in (centres, images):
        # some sources at a time: a window has its turn in between
        starts = range(0, len(sources), AT_ONCE)
        rows = [graph.distances(np.array(sources[at : at + AT_ONCE]), reach)[:, centres] for at in starts]
        distances.append(np.concatenate(rows))
        for row in np.flatnonzero(distances[-1].min(axis=1) > reach / 2):
            distances[-1][row] = graph.distances(sources[row])[list(centres)]
        distances[-1].flags.writeable = False
    return SkinDistances(*distances)
