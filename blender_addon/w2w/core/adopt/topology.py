# SPDX-License-Identifier: GPL-3.0-or-later
"""Recognition of SMPL's mesh by how it is joined, in any pose, shape and vertex order.

A walk over the faces from a well-defined first edge numbers the vertices the same way on every copy
of a mesh. A digest of the walk tells whether the mesh is SMPL's; one number per vertex then gives
SMPL's own order back. Neither holds a position or a list of faces.
"""

import hashlib
from collections import Counter, deque
from dataclasses import dataclass

import numpy as np

from ..body.body import TEMPLATES
from ..body.shapes import volume
from ..files import load_arrays

N_VERTICES, N_TRIANGLES = 6890, 13776
N_QUADS, N_LONE_TRIANGLES = 6876, 24
"""Sizes of SMPL's mesh, and the polygons of the same mesh before its quads were cut."""

NUMBERING = TEMPLATES / "smpl_numbering.npz"
"""SMPL's number of every vertex in walking order, and which way each quad is cut; made by
`tools/make_smpl_numbering.py` from the meshes of SMPL-Body (Max Planck Institute for Intelligent Systems,
CC BY 4.0). The Blender extension lacks it: its platform takes no material under that licence."""

TRIANGLES_SHA256 = "c8c3c29bde967a6c8d3624257581620b59737dfcd7ff6f77fbbf35a6035c491a"
QUADS_SHA256 = "252fced9b788233ae088f05e5bec2e7307040b237d9409a2c114762c47f3feb1"
"""Digests of the walks over SMPL's triangles and over its quads."""

COLOUR_ROUNDS = 6
"""Rounds of neighbours that distinguish vertices when the first edge is chosen."""


@dataclass(frozen=True, eq=False)
class SmplMesh:
    """A mesh found to be SMPL's."""

    order: np.ndarray  # (6890,), for each of SMPL's vertices its index in the file
    faces: np.ndarray  # (13776, 3), in SMPL's numbering, counter-clockwise seen from outside
    # (6890,), for each of SMPL's vertices the one on the other side that is joined like it
    mirror: np.ndarray


def recognise(polygons: np.ndarray, vertices: np.ndarray) -> SmplMesh | None:
    """The SMPL mesh that polygons form; None if they are joined in another way, or `NUMBERING` is not there.

    SMPL's mesh is joined symmetrically, so only its outside distinguishes left from right: faces listed
    clockwise are turned over first.

    Polygons (F, 3) or (F, 4), -1 in the fourth column of a triangle, are either all cut into triangles as
    SMPL is, or mostly quads as SMPL-Body publishes it. Vertices (V, 3) show which side is out.
    """
    faces = [tuple(face[face >= 0].tolist()) for face in np.asarray(polygons)]
    sizes = Counter(map(len, faces))
    fits = sizes in (Counter({3: N_TRIANGLES}), Counter({4: N_QUADS, 3: N_LONE_TRIANGLES}))
    if not (fits and len(vertices) == N_VERTICES and NUMBERING.is_file()):
        return None
    # of a mesh listed clockwise, the first three corners of every face enclose a negative volume
    if volume(vertices - vertices.mean(axis=0), polygons[:, :3]) < 0:
        faces = [face[::-1] for face in faces]
    walk = canonical_walk(faces, N_VERTICES)
    if walk is None or walk_digest(walk, N_VERTICES) != (QUADS_SHA256 if sizes[4] else TRIANGLES_SHA256):
        return None
    if sizes[4]:
        faces = _cut(walk)
        walk = _walked(faces)
    order, number = np.empty(N_VERTICES, dtype=np.intp), np.empty(N_VERTICES, dtype=np.int32)
    order[_numbering("smpl_vertex")] = walk.vertices
    number[order] = np.arange(N_VERTICES)
    # seen from inside, left and right change places: the same walk meets each vertex's mirror image
    reflected = _walked([face[::-1] for face in faces])
    mirror = np.empty(N_VERTICES, dtype=np.int32)
    mirror[number[walk.vertices]] = number[reflected.vertices]
    return SmplMesh(order, number[np.array(faces)], mirror)


def _numbering(name: str) -> np.ndarray:
    return load_arrays(NUMBERING, (name,), "does not hold SMPL's vertex numbers")[name]


@dataclass(frozen=True, eq=False)
class Walk:
    """A walk over all faces of a mesh that depends on nothing but how they are joined."""

    vertices: np.ndarray  # (V,), in the order they were met
    # for each face in the order it was met, its vertices from the one it was entered at
    corners: tuple[tuple[int, ...], ...]


def canonical_walk(faces: list[tuple[int, ...]], n_vertices: int) -> Walk | None:
    """Walk over a closed, connected, consistently wound mesh in an order that relabelling cannot change.

    None if the mesh is open, has an edge of more than two faces, or falls into parts.
    """
    beyond = {(face[k - 1], face[k]): index for index, face in enumerate(faces) for k in range(len(face))}
    if len(beyond) != sum(map(len, faces)) or any((end, start) not in beyond for start, end in beyond):
        return None
    walks = [_walk(faces, beyond, edge) for edge in _first_edges(np.array(list(beyond)), n_vertices)]
    walk = min(walks, key=lambda walk: _code(walk, n_vertices).tobytes())
    return walk if len(walk.vertices) == n_vertices and len(walk.corners) == len(faces) else None


def _walked(faces: list[tuple[int, ...]]) -> Walk:
    """The walk over the faces of a mesh that has been recognised."""
    walk = canonical_walk(faces, N_VERTICES)
    assert walk is not None
    return walk


def walk_digest(walk: Walk, n_vertices: int) -> str:
    """SHA-256 of a walk's faces, written in the numbers the walk gave their vertices."""
    return hashlib.sha256(_code(walk, n_vertices).tobytes()).hexdigest()


def _cut(walk: Walk) -> list[tuple[int, ...]]:
    """Triangles of a mesh of quads, each cut the way SMPL has it."""
    from_first = iter(np.unpackbits(_numbering("cut"), count=N_QUADS).tolist())
    triangles: list[tuple[int, ...]] = []
    for face in walk.corners:
        if len(face) == 3:
            triangles.append(face)
        else:
            a, b, c, d = face if next(from_first) else face[1:] + face[:1]
            triangles += [(a, b, c), (a, c, d)]
    return triangles


def _first_edges(edges: np.ndarray, n_vertices: int) -> list[tuple[int, int]]:
    """All edges out of the vertex whose surroundings are rarest."""
    colours = _colours(edges, n_vertices)
    values, inverse, uses = np.unique(colours, return_inverse=True, return_counts=True)
    rarest = np.lexsort([values, uses])[0]
    starts = np.flatnonzero(inverse == rarest)
    return [tuple(edge) for edge in edges[np.isin(edges[:, 0], starts)].tolist()]


def _colours(edges: np.ndarray, n_vertices: int) -> np.ndarray:
    """Numbers of vertices by colour refinement (Weisfeiler and Leman 1968), equal for equal surroundings."""
    colours = np.bincount(edges[:, 0], minlength=n_vertices).astype(np.uint64)
    for _ in range(COLOUR_ROUNDS):
        around = np.zeros(n_vertices, dtype=np.uint64)
        np.add.at(around, edges[:, 0], _mixed(colours[edges[:, 1]]))
        colours = _mixed(colours) + around
    return colours


def _mixed(values: np.ndarray) -> np.ndarray:
    """The splitmix64 finaliser (Steele, Lea and Flood 2014): spreads close numbers over 64 bits."""
    values = values + np.uint64(0x9E3779B97F4A7C15)
    values = (values ^ (values >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    values = (values ^ (values >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return values ^ (values >> np.uint64(31))


def _walk(faces: list[tuple[int, ...]], left: dict[tuple[int, int], int], first: tuple[int, int]) -> Walk:
    """Breadth first over the faces, each entered over the edge it was first reached by."""
    met: dict[int, None] = {}
    corners: dict[int, tuple[int, ...]] = {}
    waiting = deque([first])
    while waiting:
        start, end = waiting.popleft()
        face = left[start, end]
        if face in corners:
            continue
        entered = faces[face].index(start)
        turned = faces[face][entered:] + faces[face][:entered]
        corners[face] = turned
        met.update(dict.fromkeys(turned))
        waiting.extend((turned[k], turned[k - 1]) for k in range(len(turned)))
    return Walk(np.fromiter(met, dtype=np.intp), tuple(corners.values()))


def _code(walk: Walk, n_vertices: int) -> np.ndarray:
    """A walk's faces in the numbers it gave their vertices, -1 behind each face."""
    number = np.full(n_vertices + 1, -1, dtype="<i4")
    number[walk.vertices] = np.arange(len(walk.vertices))
    flat = [corner for face in walk.corners for corner in (*face, -1)]
    return number[flat]
