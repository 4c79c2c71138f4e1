# SPDX-License-Identifier: GPL-3.0-or-later
"""A user's own SMPL body: official model files, or a mesh with SMPL's faces and no rig."""

import zipfile
from pathlib import Path
from typing import Any

import numpy as np
from plyfile import PlyData, PlyParseError

from ..body.body import BODY_HANDS, JOINT_INDEX, N_JOINTS, PARENTS, Y_UP_TO_Z_UP, Body
from ..body.landmarks import SENSOR_SITES
from ..files import array_names
from ..pickles import read_arrays, read_npz_member
from ..wording import restated
from .registration import register
from .rest_pose import in_t_pose, metres_per_unit, on_the_ground, to_axes, with_smpl_shoulders
from .topology import N_TRIANGLES, N_VERTICES, NUMBERING, SmplMesh, recognise

MODEL_ARRAYS = ("v_template", "f", "J_regressor", "weights", "kintree_table")

SHAPES = "shapedirs"
"""Array of an official model with the directions in which its shape varies: (V, 3, shapes)."""

BODY_JOINTS = min(BODY_HANDS)
"""Joints before the hands: the same in SMPL, SMPL-H and SMPL-X."""

EXPECTED = (
    "expected an official SMPL model (.npz or .pkl), a mesh with SMPL's faces (.obj or .ply), "
    "or a body that W2W saved (.npz)"
)

LANDMARKS = {
    332: (("head",), (0, -1, 0)),
    411: (("head",), (0, 0, 1)),
    2445: (("left_hand",), (1, 0, 0)),
    5905: (("right_hand",), (-1, 0, 0)),
    3216: (("left_foot",), (0, -1, 0)),
    6617: (("right_foot",), (0, -1, 0)),
    3387: (("left_ankle", "left_foot"), (0, 1, -0.5)),
    6787: (("right_ankle", "right_foot"), (0, 1, -0.5)),
}
"""SMPL vertices at nose, crown, middle fingertips, big toes and heels (``vertex_ids`` of the smplx
package), and where to find the same on any body: joints, and the direction they are farthest in."""

MOST_CORNERS = 4
"""Most corners of a polygon that a body's mesh has."""

CROWN, HEELS = 411, (3387, 6787)
FOREARMS = (1961, 5424)

WORST_FIT = 0.005
"""Mean distance, metres, above which the bundled body does not lie on a mesh as it should."""


class BodyError(ValueError):
    """A file that W2W cannot adopt as a body; the message gives what was expected and what was found."""


def load_body(path: Path, betas: np.ndarray | None = None) -> Body:
    """Read a body from a file, into the T-pose, z up, facing -y, metres, soles on z = 0.

    The file is an official SMPL, SMPL-H or SMPL-X model (``.npz``, ``.pkl``); a mesh with SMPL's faces, in
    any pose, vertex order, axes and unit (``.obj``, ``.ply``), which comes in SMPL's vertex order; or a
    body that `Body.save` wrote. `betas` (n,) are shape coefficients of an official model, by default its mean
    shape's.

    Raises BodyError, with what was expected and what was found, if it is none of these.
    """
    kind = path.suffix.lower()
    wanted = MODEL_ARRAYS if betas is None else (*MODEL_ARRAYS, SHAPES)
    if not path.is_file():
        raise BodyError(f"{path} is not there: {EXPECTED}")
    with restated(f"{path}:", (ValueError, OSError, EOFError, zipfile.BadZipFile), BodyError):
        if kind in (".pkl", ".pickle"):
            return body_from_model(read_arrays(path, wanted), path.stem, betas)
        if kind == ".npz":
            return _body_from_npz(path, wanted, betas)
        if kind in (".obj", ".ply"):
            if betas is not None:
                raise BodyError("a mesh has a shape of its own: betas need an official SMPL model")
            return body_from_mesh(*read_mesh(path), path.stem)
    raise BodyError(f"{path}: '{kind}' files hold no body that can be read here: {EXPECTED}")


def body_from_model(model: dict[str, Any], name: str, betas: np.ndarray | None = None) -> Body:
    """A body from the arrays of an official model (Loper et al. 2015, doi:10.1145/2816795.2818013).

    ``v_template`` (V, 3) in y-up axes, metres; ``f`` (F, 3); ``J_regressor`` (J, V); ``weights`` (V, J);
    ``kintree_table`` (2, J), parents in its first row. J is 24 for SMPL, 52 for SMPL-H, 55 for SMPL-X;
    fingers, jaw and eyes go to the joint that carries them. For `betas`, at most as many as the model has,
    also ``shapedirs`` (V, 3, n); the joints follow the shape.

    Raises BodyError if an array is missing or of another shape.
    """
    missing = [key for key in MODEL_ARRAYS if key not in model]
    if missing:
        held = ", ".join(sorted(model)[:10]) or "nothing"
        raise BodyError(f"it lacks {', '.join(missing)} and holds {held}: {EXPECTED}")
    arrays = {key: np.asarray(model[key]) for key in MODEL_ARRAYS}
    vertices, regressor, weights = (_floats(arrays, key) for key in ("v_template", "J_regressor", "weights"))
    n_joints = weights.shape[-1]
    expected = {
        "v_template": (len(vertices), 3),
        "J_regressor": (n_joints, len(vertices)),
        "weights": (len(vertices), n_joints),
        "kintree_table": (2, n_joints),
        "f": (len(arrays["f"]), 3),
    }
    for key, shape in expected.items():
        if arrays[key].shape != shape:
            raise BodyError(f"its '{key}' has shape {arrays[key].shape}, expected {shape}")
    parents = arrays["kintree_table"][0].astype(np.uint32).astype(np.int32)
    as_smpl = tuple(parents[:BODY_JOINTS]) == PARENTS[:BODY_JOINTS]
    if not as_smpl or (parents[BODY_JOINTS:] >= np.arange(BODY_JOINTS, n_joints)).any():
        raise BodyError(f"its {n_joints} joints are not joined like SMPL's 24, SMPL-H's 52 or SMPL-X's 55")
    if betas is not None:
        vertices = vertices + _shape_offsets(model, np.asarray(betas, dtype=np.float64), vertices.shape)
    joints, weights = _as_24_joints(regressor @ vertices, weights, parents)
    vertices, joints = on_the_ground(vertices @ Y_UP_TO_Z_UP.T, joints @ Y_UP_TO_Z_UP.T)
    faces = arrays["f"].astype(np.int64)
    mesh = recognise(faces, vertices)
    in_order = mesh is not None and np.array_equal(mesh.order, np.arange(len(vertices)))
    mirror = mesh.mirror if mesh is not None and in_order else None
    return Body(vertices, faces, joints, _normalised(weights), name, mirror)


def body_from_mesh(vertices: np.ndarray, polygons: np.ndarray, name: str) -> Body:
    """A body from a mesh with SMPL's faces, in SMPL's vertex order: rig and weights are the bundled body's.

    Vertices (V, 3) are in any axes and unit; polygons (F, 3) or (F, 4) have -1 in the fourth column of a
    triangle. Raises BodyError if the faces are not SMPL's, or the bundled body cannot be laid on the mesh.
    """
    mesh = smpl_mesh(vertices, polygons)
    template = Body.bundled()
    placed = vertices[mesh.order]
    up = placed[CROWN] - placed[list(HEELS)].mean(axis=0)
    placed = placed @ to_axes(placed[FOREARMS[0]] - placed[FOREARMS[1]], up).T
    placed = placed * metres_per_unit(float(np.ptp(placed[:, 2])))
    own_joints, own_weights, distance = register(template, placed, mesh.faces, _landmarks(template))
    error = float(distance.mean())
    if error > WORST_FIT:
        raise BodyError(
            f"its faces are SMPL's, but the bundled body cannot be laid on it (it stays {1000 * error:.1f} "
            "mm away on average): expected a body in a T-pose or an A-pose"
        )
    straight, straight_joints = in_t_pose(placed, own_joints, own_weights, template)
    joints, weights = with_smpl_shoulders(straight, straight_joints, own_weights)
    # a shoulder joint stays where it is when the arm turns about it
    posed = own_joints + joints - straight_joints
    straight, joints = in_t_pose(placed, posed, weights, template, limbs=own_joints)
    straight, joints = on_the_ground(straight, joints)
    return Body(straight, mesh.faces, joints, weights, name, mesh.mirror)


def body_from_rig(
    vertices: np.ndarray, polygons: np.ndarray, joints: np.ndarray, weights: np.ndarray, name: str
) -> Body:
    """A body from a mesh with a rig of the 24 joints; in SMPL's vertex order where its faces are SMPL's.

    Vertices (V, 3) are in the rig's rest pose, in any axes and unit; polygons (F, 4) have -1 in the fourth
    column of a triangle; joints are (24, 3), weights (V, 24).

    Raises BodyError if it is not the size of a person or a vertex has no weight.
    """
    bare = int((weights.sum(axis=1) <= 0).sum())
    if bare:
        raise BodyError(f"{bare} of its {len(vertices)} vertices follow none of the 24 joints")
    turn = to_axes(
        joints[JOINT_INDEX["left_shoulder"]] - joints[JOINT_INDEX["right_shoulder"]],
        joints[JOINT_INDEX["neck"]] - joints[JOINT_INDEX["pelvis"]],
    )
    vertices, joints = vertices @ turn.T, joints @ turn.T
    unit = metres_per_unit(float(np.ptp(vertices[:, 2])))
    mesh = recognise(polygons, vertices)
    quads = polygons[polygons[:, 3] >= 0]
    faces = np.concatenate([polygons[:, :3], quads[:, [0, 2, 3]]]) if mesh is None else mesh.faces
    order = slice(None) if mesh is None else mesh.order
    weights = _normalised(weights[order])
    straight, joints = in_t_pose(vertices[order] * unit, joints * unit, weights, Body.bundled())
    straight, joints = on_the_ground(straight, joints)
    return Body(straight, faces, joints, weights, name, None if mesh is None else mesh.mirror)


def smpl_mesh(vertices: np.ndarray, polygons: np.ndarray) -> SmplMesh:
    """Recognise a mesh by its faces; BodyError, with what was found, if they are not SMPL's."""
    if not np.isfinite(vertices).all():
        raise BodyError("it holds positions that are not finite")
    mesh = recognise(polygons, vertices)
    if mesh is None and not NUMBERING.is_file():
        raise BodyError(
            "SMPL's mesh without a rig is recognised by a table that the Blender extension may not hold: "
            "give the official SMPL model (.npz or .pkl), or a body saved by w2w.load_body(path).save(path) "
            "in Python"
        )
    if mesh is None:
        n_triangles = int((polygons >= 0).sum() - 2 * len(polygons))
        same_size = (len(vertices), n_triangles) == (N_VERTICES, N_TRIANGLES)
        found = (
            "joined in another way" if same_size else f"{len(vertices)} vertices and {n_triangles} triangles"
        )
        raise BodyError(
            f"its faces are not SMPL's: expected {N_VERTICES} vertices and {N_TRIANGLES} triangles (or the "
            f"quads they are cut from) joined as SMPL joins them, found {found}. A body with other faces "
            "needs its own rig: import it as a rigged FBX with SMPL's bone names"
        )
    return mesh


def _body_from_npz(path: Path, wanted: tuple[str, ...], betas: np.ndarray | None) -> Body:
    names = set(array_names(path))
    if {"vertices", "faces", "joints"} <= names:
        if betas is not None:
            raise BodyError("a saved body has a shape of its own: betas need an official SMPL model")
        return Body.load(path)
    model = {name: read_npz_member(path, name) if name in wanted else None for name in names}
    return body_from_model(model, path.stem, betas)


def _shape_offsets(model: dict[str, Any], betas: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """How far betas move each vertex (Loper et al. 2015, eq. 8), shape (V, 3)."""
    if model.get(SHAPES) is None:
        raise BodyError(f"it lacks {SHAPES}, so betas cannot shape it")
    directions = np.asarray(model[SHAPES])
    if directions.ndim != 3 or directions.shape[:2] != shape or directions.dtype.kind not in "fiu":
        raise BodyError(f"its '{SHAPES}' has shape {directions.shape}, expected ({shape[0]}, 3, shapes)")
    if betas.ndim != 1 or len(betas) > directions.shape[2] or not np.isfinite(betas).all():
        raise BodyError(f"betas must be at most {directions.shape[2]} finite numbers, not {betas.tolist()}")
    return directions[:, :, : len(betas)].astype(np.float64) @ betas


def _floats(arrays: dict[str, np.ndarray], key: str) -> np.ndarray:
    if arrays[key].dtype.kind not in "fiu" or arrays[key].ndim != 2:
        raise BodyError(f"its '{key}' is no table of numbers")
    return arrays[key].astype(np.float64)


def _normalised(weights: np.ndarray) -> np.ndarray:
    weights = np.maximum(weights, 0)
    return weights / weights.sum(axis=1, keepdims=True)


def _as_24_joints(
    joints: np.ndarray, weights: np.ndarray, parents: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Joints and weights of SMPL-H and SMPL-X with fingers gathered in the hands, face in the head."""
    if len(joints) == N_JOINTS:
        return joints, weights
    gathered, body_joints = np.zeros((len(weights), N_JOINTS)), np.empty((N_JOINTS, 3))
    gathered[:, :BODY_JOINTS], body_joints[:BODY_JOINTS] = weights[:, :BODY_JOINTS], joints[:BODY_JOINTS]
    hands = {JOINT_INDEX["left_wrist"]: BODY_HANDS[0], JOINT_INDEX["right_wrist"]: BODY_HANDS[1]}
    moves = list(range(BODY_JOINTS))  # the joint of the 24 that each moves with
    for joint in range(BODY_JOINTS, len(joints)):
        carrier = moves[parents[joint]]
        moves.append(hands.get(carrier, carrier))
        gathered[:, moves[joint]] += weights[:, joint]
    for wrist, hand in hands.items():
        knuckles = np.flatnonzero(parents == wrist)
        body_joints[hand] = joints[knuckles].mean(axis=0)
    return body_joints, gathered


def _landmarks(template: Body) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of the template, and of SMPL, that mark the same places."""
    part = template.weights.argmax(axis=1)
    same = {}
    for smpl_vertex, (joints, direction) in LANDMARKS.items():
        members = np.flatnonzero(np.isin(part, [JOINT_INDEX[joint] for joint in joints]))
        same[smpl_vertex] = int(members[np.argmax(template.vertices[members] @ np.array(direction, float))])
    for site in SENSOR_SITES:
        if site.smpl_vertex is not None:
            same.setdefault(site.smpl_vertex, site.vertex(template))
    return np.array(list(same.values())), np.array(list(same))


def read_mesh(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Vertices (V, 3) and polygons (F, 4) of an OBJ or PLY; -1 in the last column of triangles.

    Raises ValueError if the file is damaged, holds no faces, or faces of more than four corners.
    """
    vertices, polygons = _read_obj(path) if path.suffix.lower() == ".obj" else _read_ply(path)
    if len(vertices) == 0 or len(polygons) == 0:
        raise ValueError("it holds no mesh: no vertices or no faces")
    sizes = np.array([len(polygon) for polygon in polygons])
    if sizes.min() < 3 or sizes.max() > MOST_CORNERS:
        raise ValueError(f"it holds faces of {sizes.min()} to {sizes.max()} corners, expected 3 or 4")
    corners = np.concatenate(polygons)
    if corners.min() < 0 or corners.max() >= len(vertices):
        raise ValueError(f"its faces name vertices that it does not hold ({len(vertices)} vertices)")
    return vertices, padded(corners, sizes)


def padded(corners: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """Polygons (F, 4) of 3 or 4 corners, listed one polygon after the other; -1 behind triangles."""
    polygons = np.full((len(sizes), MOST_CORNERS), -1, dtype=corners.dtype)
    polygons[np.arange(MOST_CORNERS) < sizes[:, None]] = corners
    return polygons


def _read_ply(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and the corners of each polygon."""
    with restated("it is not a PLY file, damaged or cut short:", (PlyParseError, ValueError, MemoryError)):
        content = PlyData.read(str(path))
    lacking = "it holds no vertices with x, y, z or no faces with vertex_indices"
    with restated(lacking, (KeyError, StopIteration, TypeError, ValueError)):
        vertex, face = content["vertex"].data, content["face"].data
        vertices = np.column_stack([vertex[axis].astype(float) for axis in "xyz"])
        named = next(face[name] for name in ("vertex_indices", "vertex_index") if name in face.dtype.names)
        return vertices, [[int(corner) for corner in polygon] for polygon in named]


def _read_obj(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """The lines ``v`` and ``f`` of an OBJ."""
    positions, polygons = [], []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1):
        kind, *fields = line.split("#", 1)[0].split() or [""]
        with restated(f"line {number} cannot be read as OBJ: {line.strip()[:60]!r}", ValueError):
            if kind == "v":
                positions.append([float(field) for field in fields[:3]])
            elif kind == "f":
                named = [int(field.partition("/")[0]) for field in fields]
                polygons.append([name - 1 if name > 0 else len(positions) + name for name in named])
    if any(len(position) != 3 for position in positions):
        raise ValueError("a vertex has fewer than three coordinates")
    return np.array(positions, dtype=float).reshape(-1, 3), polygons
