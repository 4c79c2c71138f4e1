# SPDX-License-Identifier: GPL-3.0-or-later
"""Close the mouth, the eye sockets and the nostrils of MakeHuman's base mesh.

Each opening is a closed edge loop of the quad mesh, named by one of its edges; MakeHuman's
topology (hm08) never changes. The faces behind the loop are dropped and its two lips are
zipped together with quads, so no vertex is added and every shape target still applies.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

OPENINGS: dict[str, tuple[int, int]] = {
    "mouth": (416, 417),
    "left eye": (6784, 6785),
    "left nostril": (7082, 7087),
}
"""One edge of the loop where each cavity is closed; those on the right are the mirror images."""

Edge = frozenset[int]


def close_cavities(quads: np.ndarray, vertices: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Quads of the body without its cavities.

    Parameters
    ----------
    quads : ndarray, shape (F, 4)
        A closed quad mesh.
    vertices : ndarray, shape (V, 3)
        Positions, to choose how the two sides of a loop are paired.
    mirror : ndarray, shape (V,)
        Mirror image of every vertex.

    Returns
    -------
    ndarray, shape (F', 4)
    """
    topology = _Topology(quads)
    dropped, added = np.zeros(len(quads), dtype=bool), []
    for name, edge in OPENINGS.items():
        loop = topology.edge_loop(*edge)
        inside = topology.faces_behind(loop)
        zipped = _zip_loop(loop, vertices)
        dropped[inside] = True
        added.append(_turn_like(zipped, quads[inside]))
        if name.startswith("left"):
            dropped[topology.mirrored_faces(inside, mirror)] = True
            added.append(mirror[added[-1]][:, ::-1])
    return np.concatenate([quads[~dropped], *added])


class _Topology:
    """Edges, faces and neighbours of a quad mesh."""

    def __init__(self, quads: np.ndarray) -> None:
        self.quads = quads
        self.edge_faces: dict[Edge, list[int]] = defaultdict(list)
        self.neighbours: dict[int, set[int]] = defaultdict(set)
        for face, quad in enumerate(quads.tolist()):
            for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
                self.edge_faces[Edge((a, b))].append(face)
                self.neighbours[a].add(b)
                self.neighbours[b].add(a)

    def edge_loop(self, first: int, second: int) -> list[int]:
        """Vertices met by going straight on from an edge until it closes."""
        loop = [first, second]
        while True:
            before, here = loop[-2:]
            beside = set(self.edge_faces[Edge((before, here))])
            ahead = [
                vertex
                for vertex in self.neighbours[here]
                if vertex != before and not beside & set(self.edge_faces[Edge((here, vertex))])
            ]
            if len(self.neighbours[here]) != 4 or len(ahead) != 1:
                raise ValueError(f"edge {first}-{second} does not lie on a regular loop of this mesh")
            if ahead[0] == first:
                return loop
            loop.append(ahead[0])

    def faces_behind(self, loop: list[int]) -> list[int]:
        """The smaller of the two parts into which a loop cuts the mesh."""
        cut = {Edge(pair) for pair in zip(loop, loop[1:] + loop[:1], strict=True)}
        sides = [self._flood(face, cut) for face in self.edge_faces[Edge(loop[:2])]]
        return sorted(min(sides, key=len))

    def _flood(self, start: int, cut: set[Edge]) -> set[int]:
        reached, queue = {start}, [start]
        while queue:
            quad = self.quads[queue.pop()].tolist()
            for pair in zip(quad, quad[1:] + quad[:1], strict=True):
                if Edge(pair) not in cut:
                    new = set(self.edge_faces[Edge(pair)]) - reached
                    reached |= new
                    queue.extend(new)
        return reached

    def mirrored_faces(self, faces: list[int], mirror: np.ndarray) -> list[int]:
        index = {Edge(quad): face for face, quad in enumerate(self.quads.tolist())}
        return [index[Edge(mirror[self.quads[face]].tolist())] for face in faces]


def _zip_loop(loop: list[int], vertices: np.ndarray) -> np.ndarray:
    """Quads between the two sides of a loop, paired from the corners that make the shortest rungs."""
    half, ring = len(loop) // 2, np.array(loop)

    def sides(corner: int) -> tuple[np.ndarray, np.ndarray]:
        return np.roll(ring, -corner)[: half + 1], np.roll(ring[::-1], corner + 1)[: half + 1]

    def rungs(corner: int) -> float:
        one, other = sides(corner)
        return np.linalg.norm(vertices[one] - vertices[other], axis=1).sum()

    upper, lower = sides(min(range(half), key=rungs))
    return np.stack([upper[:-1], upper[1:], lower[1:], lower[:-1]], axis=1)


def _turn_like(zipped: np.ndarray, replaced: np.ndarray) -> np.ndarray:
    """Give the new quads the winding of those that they replace."""
    directed = {pair for quad in replaced.tolist() for pair in zip(quad, quad[1:] + quad[:1], strict=True)}
    first, second = zipped[len(zipped) // 2, :2]
    return zipped if (first, second) in directed else zipped[:, ::-1]
