# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in its rest pose: the joints of its SMPL skeleton, mesh and skinning weights, as npz holds them."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.sparse import coo_matrix, csr_matrix

from ..files import load_arrays, write_npz
from ..given import given_path
from ..rotations import unit

JOINT_NAMES: tuple[str, ...] = (
    "pelvis", "left_hip", "right_hip", "spine1", "left_knee", "right_knee", "spine2", "left_ankle",
    "right_ankle", "spine3", "left_foot", "right_foot", "neck", "left_collar", "right_collar", "head",
    "left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist", "right_wrist",
    "left_hand", "right_hand",
)  # fmt: skip
"""Joint order of SMPL (Loper et al. 2015), named as in the smplx package."""

PARENTS: tuple[int, ...] = (
    -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19, 20, 21,
)  # fmt: skip
"""Parent of each joint; -1 for the root. Parents always come before their children."""

N_JOINTS = len(JOINT_NAMES)
BODY_HANDS = (22, 23)
"""SMPL's hand joints, which SMPL-H and SMPL-X replace by fingers."""

JOINT_INDEX: dict[str, int] = {name: index for index, name in enumerate(JOINT_NAMES)}

_OTHER_SIDE = {"left": "right", "right": "left"}
MIRRORED_JOINTS: tuple[int, ...] = tuple(
    JOINT_INDEX["_".join(_OTHER_SIDE.get(word, word) for word in name.split("_"))] for name in JOINT_NAMES
)
"""Index of the joint on the other side of the body (a middle joint is its own mirror)."""

Y_UP_TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""Rotation that turns SMPL's y-up axes to Blender's z-up axes: (x, y, z) -> (x, -z, y)."""

LEG = ("hip", "knee", "ankle")


def posed_joints(rest: np.ndarray, turns: np.ndarray, pelvis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forward kinematics: world rotations (T, 24, 3, 3) and positions (T, 24, 3) of the joints.

    `rest` (24, 3) are their places in the rest pose, `turns` (T, 24, 3, 3) are relative to their parents.
    """
    rotations = np.empty_like(turns)
    positions = np.empty((len(turns), N_JOINTS, 3))
    rotations[:, 0] = turns[:, 0]
    positions[:, 0] = pelvis
    for joint in range(1, N_JOINTS):
        parent = PARENTS[joint]
        np.matmul(rotations[:, parent], turns[:, joint], out=rotations[:, joint])
        positions[:, joint] = positions[:, parent] + rotations[:, parent] @ (rest[joint] - rest[parent])
    return rotations, positions


Joints = Mapping[int, np.ndarray] | np.ndarray
"""Positions (..., 3) of joints by their index."""


def midpoint(joints: Joints, part: str) -> np.ndarray:
    """The point halfway between left and right."""
    return (joints[JOINT_INDEX[f"left_{part}"]] + joints[JOINT_INDEX[f"right_{part}"]]) / 2


def trunk_line(joints: Joints) -> np.ndarray:
    """The vector from between the hips to between the shoulders."""
    return midpoint(joints, "shoulder") - midpoint(joints, "hip")


def limb_length(joints: Joints, parts: tuple[str, ...] = LEG) -> float:
    """Mean length of the two limbs over some joints, each position (3,)."""
    limbs = [[joints[JOINT_INDEX[f"{side}_{part}"]] for part in parts] for side in ("left", "right")]
    return float(np.linalg.norm(np.diff(np.array(limbs), axis=1), axis=-1).sum() / 2)


PACKAGE = Path(__file__).resolve().parents[2]
_TEMPLATES = (PACKAGE / "templates", PACKAGE.parents[1] / "assets" / "templates")
TEMPLATES = next((folder for folder in _TEMPLATES if folder.is_dir()), _TEMPLATES[0])
"""Folder of the bundled body, patches and bone-name maps."""

BUNDLED_BODY = TEMPLATES / "body.npz"

WEIGHT_TOLERANCE = 1e-5

HALF_TURNED, FROM_ABOVE, HIDES = 0.7, 0.12, 0.01
"""Turn towards a spot at a body's side, radians, rise of the look at it, and metres of what is before it."""


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
        return hash(self.vertices[::100].tobytes())

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
    def load(cls, path: str | Path) -> "Body":
        """Read a body that `save` wrote; ValueError if the file is no W2W body."""
        path = given_path(path, "a body")
        needed = ("vertices", "faces", "joints", "weights", "name")
        data: dict[str, Any] = load_arrays(path, needed, "is not a W2W body", ("mirror",))
        weights = data["weights"].astype(np.float64)
        with np.errstate(all="ignore"):
            weights /= weights.sum(axis=1, keepdims=True)
        data |= {"weights": weights, "name": str(data["name"])}
        return _the_same(cls(**data))

    def is_near(self, other: "Body", within: float) -> bool:
        """Whether another body has the same positions (metres) and weights but for so much."""
        pairs = [(getattr(self, name), getattr(other, name)) for name in ("vertices", "joints", "weights")]
        return all(a.shape == b.shape and np.allclose(a, b, rtol=0, atol=within) for a, b in pairs)

    @classmethod
    def bundled(cls) -> "Body":
        """The CC0 body that comes with W2W."""
        return cls.load(BUNDLED_BODY)


@lru_cache(maxsize=8)
def _the_same(body: Body) -> Body:
    """One object for equal bodies: whatever is cached by body finds it without comparing arrays."""
    return body


def first_turn(body: Body, vertex: int) -> float:
    """Turn about z of whoever first looks at a vertex of a body at rest, radians; 0 sees the front.

    It is half turned to the vertex from the front, or from behind where the body hides the vertex there.
    """
    aside = HALF_TURNED * float(body.vertex_normals[vertex, 0])
    towards = np.array([np.sin(aside), -np.cos(aside), FROM_ABOVE])
    first, second, third = (body.vertices[body.faces] - body.vertices[vertex]).swapaxes(0, 1)
    one, other = second - first, third - first  # by Moeller and Trumbore (1997)
    across, along = np.cross(towards, other), np.cross(one, first)
    with np.errstate(divide="ignore", invalid="ignore"):
        size = (one * across).sum(axis=1)
        u, v, away = (
            -(first * across).sum(axis=1) / size,
            along @ towards / size,
            (other * along).sum(axis=1) / size,
        )
    is_hidden = ((u >= 0) & (v >= 0) & (u + v <= 1) & (away > HIDES)).any()
    return float(np.pi - aside if is_hidden else aside)


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
