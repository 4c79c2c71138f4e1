# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in its rest pose: mesh, joints and skinning weights, read from and written to npz."""

import json
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Self

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from ..files import load_arrays, write_npz
from ..given import given_path
from ..rotations import unit
from .skeleton import N_JOINTS, PARENTS

PACKAGE = Path(__file__).resolve().parents[2]
_TEMPLATES = (PACKAGE / "templates", PACKAGE.parents[1] / "assets" / "templates")
TEMPLATES = next((folder for folder in _TEMPLATES if folder.is_dir()), _TEMPLATES[0])
"""Folder of the bundled body, patches and bone-name maps."""

BUNDLED_BODY = TEMPLATES / "body.npz"

WEIGHT_TOLERANCE = 1e-5


def template(name: str) -> Any:
    """Content of one of the JSON files that come with W2W."""
    return json.loads((TEMPLATES / name).read_text(encoding="utf-8"))


@dataclass(frozen=True, eq=False)
class Body:
    """A skinned body in its rest pose.

    The rest pose is a T-pose in Blender's world: z up, metres, facing -y, its left side
    towards +x, soles on z = 0. In the rest pose every joint frame is the world frame, as
    in SMPL (Loper et al. 2015), so a joint's rotation is zero in the T-pose.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3), float64
        Rest positions, metres.
    faces : ndarray, shape (F, 3), int32
        Triangles, counter-clockwise seen from outside.
    joints : ndarray, shape (24, 3), float64
        Rest positions of the joints in the order of `skeleton.JOINT_NAMES`, metres.
    weights : ndarray, shape (V, 24), float64
        Linear blend skinning weights; every row sums to 1.
    name : str
        What to call this body in reports.
    mirror : ndarray, shape (V,), int32, optional
        Index of each vertex's mirror image across x = 0, where the mesh is symmetric.

    Raises
    ------
    ValueError
        If shapes disagree, a face names a vertex that does not exist, a value is not
        finite or the weights of a vertex do not sum to 1.

    Examples
    --------
    >>> body = w2w.Body.bundled()
    >>> body
    <Body 'neutral': 1.73 m, 6890 vertices>
    """

    vertices: np.ndarray
    faces: np.ndarray
    joints: np.ndarray
    weights: np.ndarray
    name: str = "body"
    mirror: np.ndarray | None = None

    def __repr__(self) -> str:
        return f"<Body {self.name!r}: {self.height:.2f} m, {len(self.vertices)} vertices>"

    def __post_init__(self) -> None:
        kinds = {"vertices": np.float64, "faces": np.int32, "joints": np.float64, "weights": np.float64}
        for name, kind in (kinds | ({} if self.mirror is None else {"mirror": np.int32})).items():
            with np.errstate(all="ignore"):  # `_check` refuses what comes of it
                values = np.ascontiguousarray(getattr(self, name), dtype=kind)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        _check(self)

    def __eq__(self, other: object) -> bool:
        """Whether all arrays and the name are equal, so that results for one body hold for the other."""
        if not isinstance(other, Body):
            return NotImplemented
        return self.name == other.name and all(
            np.array_equal(getattr(self, name), getattr(other, name))
            for name in ("vertices", "faces", "joints", "weights", "mirror")
        )

    def __hash__(self) -> int:
        return hash(self.vertices.tobytes())

    @property
    def parents(self) -> tuple[int, ...]:
        """Parent of each joint, -1 for the root."""
        return PARENTS

    @property
    def height(self) -> float:
        """Height of the rest pose, metres."""
        return float(np.ptp(self.vertices[:, 2]))

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """Area-weighted outward unit normals of the rest pose, shape (V, 3)."""
        return vertex_normals(self.vertices, self.faces)

    def save(self, path: str | Path) -> None:
        """Write the body to an npz file, whole or not at all."""
        arrays = {"vertices": self.vertices, "faces": self.faces, "joints": self.joints}
        arrays |= {"weights": self.weights.astype(np.float32), "name": np.array(self.name)}
        if self.mirror is not None:
            arrays["mirror"] = self.mirror
        write_npz(path, arrays)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a body that `save` wrote; ValueError if the file is no W2W body."""
        path = given_path(path, "a body")
        needed = ("vertices", "faces", "joints", "weights", "name")
        data: dict[str, Any] = load_arrays(path, needed, "is not a W2W body", ("mirror",))
        weights = data["weights"].astype(np.float64)
        with np.errstate(all="ignore"):
            weights /= weights.sum(axis=1, keepdims=True)
        data |= {"weights": weights, "name": str(data["name"])}
        return cls(**data)

    @classmethod
    def bundled(cls) -> Self:
        """The CC0 body that comes with W2W."""
        return cls.load(BUNDLED_BODY)


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area-weighted unit normals (V, 3) of a triangle mesh."""
    across, normals = face_normals(vertices[faces]), np.zeros_like(vertices)
    for corner in range(3):
        np.add.at(normals, faces[:, corner], across)
    return unit(normals)


def face_normals(corners: np.ndarray) -> np.ndarray:
    """Normals (F, 3) of triangles by their corners (F, 3, 3), each as long as twice its area."""
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def edges_of(faces: np.ndarray) -> np.ndarray:
    """Edges (3F, 2) of triangles, along the order of their corners; an edge of two triangles twice."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def neighbours(edges: np.ndarray, n_vertices: int) -> csr_matrix:
    """Matrix (V, V) with 1 for vertices that share an edge."""
    both = np.concatenate([edges, edges[:, ::-1]])
    links = coo_matrix((np.ones(len(both)), both.T), shape=(n_vertices, n_vertices)).tocsr()
    links.data[:] = 1.0
    return links


def edge_lengths(points: np.ndarray, edges: np.ndarray) -> csr_matrix:
    """Lengths of edges between points (V, 3), both ways, shape (V, V)."""
    links = neighbours(edges, len(points)).tocoo()
    lengths = np.linalg.norm(points[links.row] - points[links.col], axis=1)
    return csr_matrix((lengths, (links.row, links.col)), shape=links.shape)


def _check(body: Body) -> None:
    n_vertices = len(body.vertices)
    for name, rows in (("vertices", "V"), ("faces", "F")):
        values = getattr(body, name)
        if values.ndim != 2 or values.shape[1] != 3 or len(values) == 0:
            raise ValueError(f"{name} must have shape ({rows}, 3), not {values.shape}")
    for name in ("faces", "mirror"):
        values = getattr(body, name)
        if values is not None and values.size and not 0 <= values.min() <= values.max() < n_vertices:
            raise ValueError(f"{name} name vertices outside 0..{n_vertices - 1}")
    shapes = {"joints": (N_JOINTS, 3), "weights": (n_vertices, N_JOINTS), "mirror": (n_vertices,)}
    for name, shape in shapes.items():
        values = getattr(body, name)
        if values is not None and values.shape != shape:
            raise ValueError(f"{name} must have shape {shape}, not {values.shape}")
    for name in ("vertices", "joints", "weights"):
        if not np.isfinite(getattr(body, name)).all():
            raise ValueError(f"{name} holds values that are not finite")
    wrong = max(np.abs(body.weights.sum(axis=1) - 1).max(), -body.weights.min())
    if wrong > WEIGHT_TOLERANCE:
        raise ValueError("skinning weights must be non-negative and sum to 1 at every vertex")
