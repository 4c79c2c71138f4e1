# SPDX-License-Identifier: GPL-3.0-or-later
"""What patches sit on: the skin, or what covers it (garments), and what their sensors feel on cloth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.spatial import KDTree

from ..body.body import Body, vertex_normals
from ..files import load_arrays, write_npz
from ..given import inside
from ..library.library import WORK_FOLDER
from ..motion.skinning import triangle_frames
from ..patches.carriers import carrier_triangles
from ..patches.patches import PatchSet
from ..patches.strip_graph import StripGraph
from ..wording import NAMED, count
from .recording import ImuRecording
from .synthesis import Synthesis, synthesize

FITTED = f"{WORK_FOLDER}/garments.npz"
"""File of a study with the patches on each cover, and how they sit on it."""

REACH = 0.12
"""A cover this far from the skin still covers it, metres."""

BELOW = 0.01
"""How far below the skin a cover may be drawn, metres: a tight one often is."""

ASIDE = 0.02
"""Farthest distance of a patch from the cover's nearest vertex, metres; an edge on coarse meshes."""

FACING = 0.3
"""Least cosine between the normals of a cover and of the skin that it covers."""

CANDIDATES, SKIN_NEAR = 64, 4

PARTS = ("patches", "triangles", "mounts")
"""Arrays of a `Cover`, also in its file."""


@dataclass(frozen=True, eq=False)
class Cover:
    """The patches (K,) that a mesh covers, and the vertices of the mesh (K, 3) that carry each sensor.

    `mounts` (K, 3, 3) turn each sensor against its triangle's frame: in the rest pose it is turned as on
    the skin.
    """

    patches: np.ndarray
    triangles: np.ndarray
    mounts: np.ndarray

    def __len__(self) -> int:
        return len(self.patches)

    def matrices(self, corners: np.ndarray) -> np.ndarray:
        """World matrices of the sensors, shape (T, K, 4, 4), from their triangles' corners (T, K, 3, 3)."""
        frames = triangle_frames(corners)
        frames[..., :3, :3] = frames[..., :3, :3] @ self.mounts
        return frames


def cover(vertices: np.ndarray, faces: np.ndarray, body: Body, patches: PatchSet) -> Cover:
    """The patches of a body that a mesh around it covers, vertices (V, 3) in the body's rest pose, metres.

    A patch is covered if the mesh passes over it, facing the same way as the skin; its sensor sits on
    the nearest such vertex, on a triangle of vertices around that.
    """
    nothing = Cover(np.empty(0, dtype=np.int64), np.empty((0, 3), dtype=np.int64), np.empty((0, 3, 3)))
    used, numbers = np.unique(faces, return_inverse=True)
    if len(used) < 3:
        return nothing
    cloth = skinned_as(vertices[used], numbers.reshape(-1, 3), body)
    places, normals = body.vertices[patches.vertices], body.vertex_normals[patches.vertices]
    centre = _over(cloth, places, normals)
    covered = np.flatnonzero(centre >= 0)
    if not len(covered):
        return nothing
    graph = StripGraph.of(cloth.vertices, cloth.faces)
    triangles = carrier_triangles(cloth, graph, centre[covered])
    on_cloth = triangle_frames(cloth.vertices[triangles])[:, :3, :3]
    on_skin = triangle_frames(body.vertices[patches.triangles[covered]])[:, :3, :3]
    return Cover(covered, used[triangles], np.swapaxes(on_cloth, 1, 2) @ on_skin)


def skinned_as(vertices: np.ndarray, faces: np.ndarray, body: Body) -> Body:
    """A mesh around a body, facing outward and skinned as the nearest skin."""
    distance, near = KDTree(body.vertices).query(vertices, k=SKIN_NEAR)
    share = 1 / np.maximum(distance, 1e-6)
    weights = np.einsum("vk,vkj->vj", share / share.sum(axis=1, keepdims=True), body.weights[near])
    along = np.einsum("va,va->v", vertex_normals(vertices, faces), body.vertex_normals[near[:, 0]])
    faces = faces if along.sum() >= 0 else faces[:, ::-1]
    return Body(vertices, faces, body.joints, weights / weights.sum(axis=1, keepdims=True), name="garment")


def _over(cloth: Body, places: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Vertex of a cover over each place on the skin, -1 without one."""
    count = min(CANDIDATES, len(cloth.vertices))
    near = KDTree(cloth.vertices).query(places, k=count)[1].reshape(len(places), count)
    gap = cloth.vertices[near] - places[:, None]
    height = np.einsum("nka,na->nk", gap, normals)
    aside = np.linalg.norm(gap - height[..., None] * normals[:, None], axis=2)
    facing = np.einsum("nka,na->nk", cloth.vertex_normals[near], normals)
    corners = cloth.vertices[cloth.faces]
    edge = float(np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)))
    over = (height > -BELOW) & (height < REACH) & (aside < max(ASIDE, edge)) & (facing > FACING)
    cost = np.where(over, aside + height / 4, np.inf)
    best = cost.argmin(axis=1)
    rows = np.arange(len(places))
    return np.where(np.isfinite(cost[rows, best]), near[rows, best], -1)


def save_covers(path: str | Path, covers: Mapping[str, Cover], sources: Sequence[str]) -> None:
    """Write covers, by their names, to an npz file; `sources` are hashes of their files."""
    whole = list(covers.values())
    arrays = {
        "names": np.array(list(covers)),
        "sources": np.array(sources),
        "owners": np.repeat(np.arange(len(whole)), [len(own) for own in whole]),
        **{part: np.concatenate([getattr(own, part) for own in whole]) for part in PARTS},
    }
    write_npz(path, arrays)


def load_covers(path: str | Path) -> dict[str, Cover]:
    """Read what `save_covers` wrote; ValueError if the file does not hold it."""
    data = load_arrays(path, ("names", "owners", *PARTS), "does not say what garments cover")
    covers = {}
    for number, name in enumerate(data["names"]):
        own = data["owners"] == number
        covers[str(name)] = Cover(**{part: data[part][own] for part in PARTS})
    return covers


def without_overlap(covers: Sequence[Cover]) -> list[Cover]:
    """Covers over each other, the outer first: each without the patches of the ones before it."""
    taken = np.empty(0, dtype=np.int64)
    distinct = []
    for own in covers:
        kept = ~np.isin(own.patches, taken)
        distinct.append(Cover(own.patches[kept], own.triangles[kept], own.mounts[kept]))
        taken = np.concatenate([taken, own.patches])
    return distinct


def cover_content(out: Path, patches: PatchSet) -> dict[str, Any]:
    """The patches on each cover of a study in a folder, and the regions that these lie in."""
    covers = load_covers(inside(out, FITTED))
    return {
        "garments": {
            name: {
                "patches": own.patches.tolist(),
                "regions": sorted({patches.regions[patch] for patch in own.patches}),
            }
            for name, own in covers.items()
        }
    }


def covered(summary: Mapping[str, Any]) -> dict[str, list[int]]:
    """The patches on each cover, by its name, from a study's summary."""
    return {name: own["patches"] for name, own in summary.get("garments", {}).items()}


def cover_sentence(summary: Mapping[str, Any], n_patches: int) -> str:
    """A sentence on how many sensors sit on cloth and how many on the skin; "" if all sit on the skin."""
    if not (on := covered(summary)):
        return ""
    parts = [f"{len(patches)} on {name}" for name, patches in on.items()]
    on_skin = n_patches - sum(map(len, on.values()))
    return (
        f"Of {n_patches} patches {', '.join(parts)} and {on_skin} on the skin. Experimental: the cloth "
        "is simulated by Blender and has not yet been checked against worn garments"
    )


CAUGHT = 2.0
"""An edge of a cloth has caught when it is longer than this many times its rest length."""

HAS_CAUGHT = "cloth caught on the body"
"""How the sentence about it begins."""


@dataclass(frozen=True, eq=False)
class ClothSensors:
    """Poses of the sensors on cloth during a clip.

    Parameters
    ----------
    patches : ndarray of int, shape (K,)
        Patches whose sensors sit on cloth.
    matrices : ndarray, shape (T, K, 4, 4), float64
        World matrices of those sensors, metres, without scale.
    rate : float
        Frames per second; need not be the clip's.
    caught : mapping of str to int
        Frames in which each piece of cloth, by its name, had caught on the body; empty if not counted.
    """

    patches: np.ndarray
    matrices: np.ndarray
    rate: float
    caught: Mapping[str, int] = field(default_factory=dict)

    def carried(self, there: np.ndarray, here: np.ndarray) -> Self:
        """The sensors on a body in another pose: each keeps its place relative to its patch.

        `there` and `here` (T, K, 4, 4) are world matrices of the patches on the skin, in the simulated
        pose and in the wanted one.
        """
        return replace(self, matrices=here @ np.linalg.inv(there) @ self.matrices)

    def over(self, skin: ImuRecording, settings: Synthesis) -> ImuRecording:
        """The ideal recording of the skin with the signals of the sensors on cloth in place of the skin's.

        Raises `ValueError` if the cloth's frames end before the recording does.
        """
        if not len(self.patches):
            return skin
        cloth = synthesize(self.matrices, self.rate, settings)
        if cloth.n_samples < skin.n_samples:
            raise ValueError(
                f"the cloth was followed for {cloth.n_samples} samples of {skin.n_samples}: "
                "its frames end before the clip does"
            )
        acc, gyr = skin.acc.copy(), skin.gyr.copy()
        acc[:, self.patches] = cloth.acc[: skin.n_samples]
        gyr[:, self.patches] = cloth.gyr[: skin.n_samples]
        return replace(skin, acc=acc, gyr=gyr)

    def facts(self) -> dict[str, Any]:
        """What caught, for a clip's record; {} if nothing did."""
        caught = {name: count for name, count in self.caught.items() if count}
        return {"cloth_caught": caught, "cloth_frames": len(self.matrices)} if caught else {}


class RestLengths:
    """Rest lengths of the edges (E, 2) of a cloth, from its vertices (V, 3) at rest."""

    def __init__(self, vertices: np.ndarray, edges: np.ndarray) -> None:
        lengths = _lengths(vertices, edges)
        self.edges, self.lengths = edges[lengths > 0], lengths[lengths > 0]

    def caught(self, vertices: np.ndarray) -> bool:
        """Whether any edge is too long; an edge of a vertex that a modifier removed (NaN) never is."""
        return bool((_lengths(vertices, self.edges) > CAUGHT * self.lengths).any())


def caught_sentence(frames: Mapping[str, int], of: int) -> str:
    """A sentence on the number of a clip's frames in which each piece of cloth caught; "" if none did."""
    parts = [f"{name} in {count}" for name, count in frames.items() if count]
    if not parts:
        return ""
    return (
        f"{HAS_CAUGHT}, stretched to more than {CAUGHT:g} times its length: {', '.join(parts)} of {of} frames"
    )


def caught_sentences(clips: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """A sentence for each of the first clips in which cloth caught, and one for the rest.

    Clips are names with their records.
    """
    caught = [(name, about) for name, about in clips if about.get("cloth_caught")]
    sentences = [
        f"In {name} {caught_sentence(about['cloth_caught'], about['cloth_frames'])}: do not trust what its "
        "sensors feel there"
        for name, about in caught[:NAMED]
    ]
    more = len(caught) - NAMED
    if more > 0:
        sentences.append(f"Cloth caught in {count('more clip', more)}: see cloth_caught in clips.jsonl")
    return sentences


def _lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
