# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches: where on a body a virtual sensor may sit, sampled evenly over its surface."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Integral
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix, hstack

from ..body.body import TEMPLATES, Body
from ..body.regions import regions_of
from ..body.shapes import bundled_targets
from ..files import load_arrays, write_npz
from .carriers import carrier_triangles
from .strip_graph import StripGraph

DEFAULT_PATCHES = 512
"""How many patches the paper samples."""

KEPT = ("vertices", "triangles", "labels", "regions", "seed")
SPARSE_PARTS = ("data", "indices", "indptr")

PATCH_ORDER = TEMPLATES / "patch_order.npy"
"""All vertices of the bundled body in the order of an exact geodesic farthest-point sampling by seed 0."""


@dataclass(frozen=True, eq=False)
class PatchSet:
    """Places on a body where a virtual sensor may sit.

    Parameters
    ----------
    vertices : ndarray, shape (N,), int32
        Centre vertex of each patch, in picking order.
    triangles : ndarray, shape (N, 3), int32
        Vertices v1, v2, v3 of each patch's carrier triangle, in the order of Blender's
        three-vertex parent: x along v2 - v1, z outward.
    labels : ndarray, shape (V,), int32
        Patch that each vertex belongs to (geodesic Voronoi cell).
    regions : tuple of str
        Name of the region each patch's centre lies in, e.g. "left wrist dorsal".
    seed : int
        Seed of the random first pick.
    interpolation : csr_matrix, shape (V, N), float32
        Share of each patch in the value at each vertex; rows sum to 1.
    own_names : tuple of str
        Where they were given, as by `patches_at`; else patches are named by region.

    Examples
    --------
    >>> patches = w2w.sample_patches(w2w.Body.bundled(), 24)
    >>> patches.names[:2]
    ('right palm', 'left toes')
    """

    vertices: np.ndarray
    triangles: np.ndarray
    labels: np.ndarray
    regions: tuple[str, ...]
    seed: int
    interpolation: csr_matrix
    own_names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        return f"<PatchSet: {len(self)} patches in {len(set(self.regions))} regions>"

    def __len__(self) -> int:
        return len(self.vertices)

    @cached_property
    def names(self) -> tuple[str, ...]:
        """A unique name of each patch: its own, else its region, numbered if that has several."""
        if self.own_names:
            return self.own_names
        total, seen = Counter(self.regions), Counter[str]()
        names = []
        for region in self.regions:
            seen[region] += 1
            names.append(region if total[region] == 1 else f"{region} {seen[region]:02d}")
        return tuple(names)

    def to_vertices(self, scores: np.ndarray) -> np.ndarray:
        """Spread scores of patches smoothly over the vertices.

        Parameters
        ----------
        scores : ndarray, shape (N,) or (N, K)
            NaN where a patch has none.

        Returns
        -------
        ndarray, shape (V,) or (V, K)
            Never outside the range of the scores; NaN on the ground of patches without one, which
            do not touch the values around them.

        Raises
        ------
        ValueError
            If there is not one row per patch or a score is infinite.
        """
        scores = np.asarray(scores, dtype=np.float64)
        if scores.ndim not in (1, 2) or len(scores) != len(self):
            raise ValueError(f"scores must have one row a patch ({len(self)}), not shape {scores.shape}")
        if np.isinf(scores).any():
            raise ValueError("scores must be finite, or NaN where a patch has none")
        known = ~np.isnan(scores)
        spread = self.interpolation @ np.where(known, scores, 0.0)
        if not known.all():
            share = self.interpolation @ known.astype(np.float64)
            spread = np.divide(spread, share, out=np.full_like(spread, np.nan), where=known[self.labels])
        # rows sum to 1 up to rounding only
        low, high = (np.where(known, scores, end) for end in (np.inf, -np.inf))
        return np.clip(spread, low.min(axis=0), np.maximum(high.max(axis=0), low.min(axis=0)))

    def best_of_regions(self, scores: np.ndarray, allowed: np.ndarray | None = None) -> list[int]:
        """The patch of the highest score in each region, best first; of equals that of the lower number.

        Only `allowed` patches (N,), bool, count; by default all.
        """
        order = np.argsort(-scores, kind="stable")
        best: dict[str, int] = {}
        for patch in (order if allowed is None else order[allowed[order]]).tolist():
            best.setdefault(self.regions[patch], patch)
        return list(best.values())

    def save(self, path: str | Path) -> None:
        """Write the patches to an npz file, whole or not at all."""
        arrays = {name: np.array(getattr(self, name)) for name in KEPT}
        arrays |= {f"interpolation_{part}": getattr(self.interpolation, part) for part in SPARSE_PARTS}
        if self.own_names:
            arrays["own_names"] = np.array(self.own_names)
        write_npz(path, arrays)

    @classmethod
    def load(cls, path: str | Path) -> PatchSet:
        """Read patches that `save` wrote.

        Raises
        ------
        ValueError
            If the file does not hold patches.
        """
        sparse_parts = [f"interpolation_{part}" for part in SPARSE_PARTS]
        data = load_arrays(path, (*KEPT, *sparse_parts), "does not hold W2W patches", ("own_names",))
        shape = (len(data["labels"]), len(data["vertices"]))
        kept: dict[str, Any] = {name: data[name] for name in KEPT}
        kept |= {"regions": tuple(map(str, data["regions"])), "seed": int(data["seed"])}
        spread = csr_matrix(tuple(data[part] for part in sparse_parts), shape=shape)
        return cls(**kept, interpolation=spread, own_names=tuple(map(str, data.get("own_names", ()))))


def sample_patches(body: Body, n: int = DEFAULT_PATCHES, seed: int = 0) -> PatchSet:
    """Sample patches evenly over a body by geodesic farthest-point sampling.

    The bundled body has, for seed 0, one fixed order of patches, in which every number of patches is a
    beginning; all its shapes share it. Elsewhere distances are those of a `StripGraph`.

    Parameters
    ----------
    body : Body
    n : int
        How many patches.
    seed : int
        Chooses the random vertex that sampling starts at, as in the paper.

    Returns
    -------
    PatchSet
        `n` patches, each evenly far from the others.

    Raises
    ------
    ValueError
        If `n` is more than the number of vertices or less than that of the mesh's separate
        pieces, or a vertex belongs to no face.

    Examples
    --------
    >>> w2w.sample_patches(w2w.Body.bundled(), 24)
    <PatchSet: 24 patches in 24 regions>
    """
    _check(body, n)
    graph = StripGraph.of(body.vertices, body.faces)
    if n < graph.n_pieces:
        raise ValueError(f"n must reach every one of the mesh's {graph.n_pieces} separate pieces, not {n}")
    if seed == 0 and bundled_targets().fit(body):
        picks = np.load(PATCH_ORDER)[:n]
    else:
        start = np.random.default_rng(seed).integers(len(body.vertices))
        picks = farthest_points(graph, n, int(start))
    return patch_set(body, picks, (), seed)


def unplaced(names: Sequence[str]) -> PatchSet:
    """Places by their names alone, on no body: they have neither vertices nor regions."""
    count = len(names)
    nowhere, spread = np.full((count, 3), -1, np.int32), csr_matrix((0, count), dtype=np.float32)
    return PatchSet(nowhere[:, 0], nowhere, np.empty(0, np.int32), tuple(names), 0, spread, tuple(names))


def patch_set(body: Body, centres: np.ndarray, own_names: tuple[str, ...], seed: int) -> PatchSet:
    """Patches centred at vertices, with their own names or none."""
    graph = StripGraph.of(body.vertices, body.faces)
    labels = graph.nearest(centres)  # refuses what is of several pieces
    codes, region_names = regions_of(body)
    return PatchSet(
        vertices=centres.astype(np.int32),
        triangles=carrier_triangles(body, graph, centres),
        labels=labels,
        regions=tuple(region_names[code] for code in codes[centres]),
        seed=seed,
        interpolation=interpolation_weights(graph, centres),
        own_names=own_names,
    )


def _check(body: Body, n: int) -> None:
    if not isinstance(body, Body):
        raise ValueError(f"patches are sampled on a Body, not on {body!r}")
    n_vertices = len(body.vertices)
    if not (isinstance(n, Integral) and 1 <= n <= n_vertices):
        raise ValueError(
            f"n must be a whole number between 1 and the body's {n_vertices} vertices, not {n!r}"
        )
    loose = np.setdiff1d(np.arange(n_vertices), body.faces)
    if len(loose):
        raise ValueError(f"{len(loose)} vertices of the body belong to no face, the first is {loose[0]}")


REACH = 2.2
"""Support of a patch's kernel, in units of the largest distance of a vertex from its patch."""

SHARPNESS = 0.3
"""Distance, in the same unit, within which a patch's own score shows almost alone."""

CHUNK = 256


def interpolation_weights(graph: StripGraph, centres: np.ndarray) -> csr_matrix:
    """Share of each patch in the value shown at each vertex: (V, N), float32, non-negative, rows sum to 1.

    Inverse squared distance to the patch centres under a compact kernel (after Franke and Nielson 1980,
    doi:10.1002/nme.1620151110; Wendland's C2, 1995, doi:10.1007/BF02123482), normalised at every vertex: at
    its centre a patch shows its own score, so that no peak is dulled. Distance runs along the surface, so
    nothing bleeds from a wrist to the hip next to it.
    """
    cover = graph.distances(centres, nearest=True)
    reach = REACH * float(cover[np.isfinite(cover)].max())
    blocks = []
    for begin in range(0, len(centres), CHUNK):
        distance = graph.distances(centres[begin : begin + CHUNK], limit=reach)
        column, row = np.nonzero(distance < reach)
        scaled = distance[column, row] / reach
        near = (REACH * scaled) ** 2 + SHARPNESS**2
        values = (1 - scaled) ** 4 * (4 * scaled + 1) / near
        blocks.append(csr_matrix((values, (row, column)), shape=distance.T.shape))
    weights = hstack(blocks, format="csr")
    return weights.multiply(1 / np.asarray(weights.sum(axis=1))).tocsr().astype(np.float32)


TIE = 1e-9
"""Distances closer than this (metres) count as equal: of these the lowest vertex is picked."""


def farthest_points(graph: StripGraph, n: int, start: int) -> np.ndarray:
    """Pick `n` vertices, each the farthest from all earlier ones, beginning at `start`.

    Gonzalez (1985, doi:10.1016/0304-3975(85)90224-5); for images, Eldar et al. (1997,
    doi:10.1109/83.623193).
    """
    picks, distance = [start], graph.distances(start)
    while len(picks) < n:
        picks.append(int(np.argmax(distance >= distance.max() - TIE)))
        distance = np.minimum(distance, graph.distances(picks[-1], limit=distance.max()))
    return np.array(picks)
