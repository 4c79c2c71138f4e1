# SPDX-License-Identifier: GPL-3.0-or-later
"""Somebody's own character in the scene: our body's map on its meshes, our sensors on its skin."""

from collections.abc import Collection, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ...core.body.body import Body, face_normals, vertex_normals
from ...core.motion.skinning import triangle_frames
from ...core.motion.source import SourceMotion
from ...core.patches.correspondence import Character, correspond
from ...core.retargeting.retarget import matched_joints
from ..base.body import matrix, moved, read_values, rest_vertices, triangles_of
from ..base.module import bpy
from ..base.patches import new_empty
from ..heatmap import heatmap_names, paint_colours, remove_heatmaps
from ..motion.takes import skeleton_of
from .adopt import carrier, joint_weights, moving_armature

POINT = "W2W point of the body"
"""Attribute of a character's mesh: the triangle of our body that each vertex is on, and two shares in it."""

LAYER = 0.004
"""Vertices this much farther from a sensor than the nearest, on our body, are layers of one place; metres."""

APART = 0.25
"""Most distance of the median vertex from the joint that moves it, of the skeleton's extent: 0.06 to 0.08
in four real characters."""

MARK = "w2w mark"
"""Custom property of an empty that shows a sensor on a character: number of its patch."""


def character_meshes(armature: bpy.types.Object, scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The meshes of a scene that an armature moves, by a modifier, as their parent or by a bone."""
    return [
        item
        for item in scene.objects
        if item.type == "MESH"
        and len(item.data.polygons)
        and (moving_armature(item) == armature or (item.parent == armature and not item.modifiers))
    ]


def read_character(armature: bpy.types.Object, meshes: Sequence[bpy.types.Object]) -> Character:
    """A character in its armature's rest pose, its meshes one after the other.

    Raises `UnusableMotion` if no bones were found, by name or by structure, for the joints of a body, and
    `ValueError` if the skeleton does not lie in the skin.
    """
    names, parents, rest = skeleton_of(armature)
    rest = matrix(armature.matrix_world) @ rest
    _, found = matched_joints(SourceMotion(names, parents, rest, rest[None], 1.0))
    bones = list(armature.data.bones)
    # bone 0 is the armature itself, which skins nothing
    matched = {joint: bone - 1 for joint, bone in found.items() if bone > 0}
    vertices, faces, weights, start = [], [], [], 0
    for mesh in meshes:
        vertices.append(moved(rest_vertices(mesh), _rest_world(mesh, armature)))
        faces.append(triangles_of(mesh.data) + start)
        weights.append(_weights(mesh, bones, matched))
        start += len(mesh.data.vertices)
    joints = {joint: rest[bone, :3, 3] for joint, bone in found.items()}
    figure = Character(np.concatenate(vertices), np.concatenate(faces), np.concatenate(weights), joints)
    _check_fit(figure)
    return figure


def tie(character: Character, meshes: Sequence[bpy.types.Object], body: Body) -> float:
    """Note on each vertex of a character which point of our body it is.

    Returns the median distance of the character from our body once it is laid on it, metres.
    """
    points = correspond(character, body)
    values = np.column_stack([points.faces, points.shares[:, :2]]).astype(np.float32)
    ends = np.cumsum([len(mesh.data.vertices) for mesh in meshes])
    for mesh, own in zip(meshes, np.split(values, ends[:-1]), strict=True):
        attributes = mesh.data.attributes
        attribute = attributes.get(POINT) or attributes.new(POINT, "FLOAT_VECTOR", "POINT")
        attribute.data.foreach_set("vector", own.ravel())
    return float(np.median(points.distance))


def untie(mesh: bpy.types.Object) -> None:
    """Take our map off a character's mesh."""
    remove_heatmaps(mesh)
    if POINT in mesh.data.attributes:
        mesh.data.attributes.remove(mesh.data.attributes[POINT])


def carry_heatmaps(body: bpy.types.Object, mesh: bpy.types.Object) -> None:
    """Paint the heatmaps of a body on a mesh that is tied to it; those of an earlier call are replaced."""
    remove_heatmaps(mesh)
    corners, shares = _points(body, mesh)
    for name in heatmap_names(body):
        own = body.data.color_attributes[name].data
        colours = read_values(own, "color_srgb", len(body.data.vertices) * 4, np.float32)
        paint_colours(mesh.data, name, np.einsum("vc,vca->va", shares, colours.reshape(-1, 4)[corners, :3]))


def place_marks(
    body: bpy.types.Object, vertices: Sequence[int], meshes: Sequence[bpy.types.Object], size: float
) -> list[bpy.types.Object]:
    """Balls on a character where sensors are on our body; they follow its skin, whatever moves that.

    `vertices` are those of our body under each sensor; `meshes` the character's, tied to the body; `size` the
    radius for a character as large as our body, metres. The empties are in no collection yet.
    """
    rest = rest_vertices(body)
    parts = []
    for number, mesh in enumerate(meshes):
        corners, shares = _points(body, mesh)
        world, skin = matrix(mesh.matrix_world), rest_vertices(mesh)
        on_body = np.einsum("vc,vca->va", shares, rest[corners])
        normals = vertex_normals(skin, triangles_of(mesh.data)) @ world[:3, :3].T
        owners, numbers = np.full(len(skin), number), np.arange(len(skin))
        parts.append(_Skin(on_body, moved(skin, world), normals, owners, numbers))
    whole = _Skin(*map(np.concatenate, zip(*parts, strict=True)))
    scale = _extent(whole.places) / _extent(rest)
    found = [_outermost(whole, rest[vertex]) for vertex in vertices]
    return [_ball(meshes[whole.meshes[own]], int(whole.vertices[own]), size * scale) for own in found]


class _Skin(NamedTuple):
    """Vertices of a character's meshes: where on our body and in the world, normal, mesh and number."""

    on_body: np.ndarray
    places: np.ndarray
    normals: np.ndarray
    meshes: np.ndarray
    vertices: np.ndarray


def _outermost(skin: _Skin, point: np.ndarray) -> int:
    """The vertex of a character that is at a point of our body: of layers there, the one that is outside."""
    gap = np.linalg.norm(skin.on_body - point, axis=1)
    near = np.flatnonzero(gap <= gap.min() + LAYER)
    outward = skin.normals[near].sum(axis=0)
    return int(near[np.argmax(skin.places[near] @ outward)])


def _ball(mesh: bpy.types.Object, vertex: int, radius: float) -> bpy.types.Object:
    """An empty on a vertex of a mesh, parented to a triangle there: a vertex alone gives no turn."""
    points, triangles = rest_vertices(mesh), triangles_of(mesh.data)
    triangles = triangles[(triangles == vertex).any(axis=1)]
    corners = points[triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1)
    area = np.linalg.norm(face_normals(corners), axis=-1)
    best = int((area / np.maximum(sides.max(axis=1), 1e-20)).argmax())
    (frame,) = triangle_frames(corners[best : best + 1])
    size = radius / np.cbrt(abs(np.linalg.det(matrix(mesh.matrix_world)[:3, :3])))
    empty = new_empty(mesh, "Sensor", triangles[best], "SPHERE", size)
    empty.location = frame[:3, :3].T @ (points[vertex] - frame[:3, 3])
    return empty


def _points(body: bpy.types.Object, mesh: bpy.types.Object) -> tuple[np.ndarray, np.ndarray]:
    """Vertices of our body around the point that each of a mesh's is, and their shares, both (V, 3)."""
    attribute = mesh.data.attributes.get(POINT)
    if attribute is None:
        raise ValueError(f"'{mesh.name}' has lost what ties it to the body: use the character again")
    values = read_values(attribute.data, "vector", len(mesh.data.vertices) * 3, np.float32)
    values = values.reshape(-1, 3).astype(np.float64)
    faces, triangles = np.rint(values[:, 0]).astype(np.intp), triangles_of(body.data)
    if len(faces) and not 0 <= faces.min() <= faces.max() < len(triangles):
        raise ValueError(f"'{mesh.name}' is tied to another body: use the character again")
    shares = np.column_stack([values[:, 1:], 1 - values[:, 1:].sum(axis=1)])
    return triangles[faces], shares


def lost_marks(shown: Collection[bpy.types.Collection | None]) -> Iterator[bpy.types.Object]:
    """Sensors on characters in no collection that a study shows; people may keep them among other things."""
    for home in bpy.data.collections:
        if home.library is None and home not in shown and all(MARK in item for item in home.objects):
            yield from home.objects


def _weights(mesh: bpy.types.Object, bones: list[bpy.types.Bone], matched: dict[int, int]) -> np.ndarray:
    """Weights of the 24 joints, shape (V, 24); of a mesh that hangs at a bone, that bone's."""
    if moving_armature(mesh) is not None or mesh.parent_type != "BONE":
        return joint_weights(mesh, bones, matched)
    joint_of = {bones[bone].name: joint for joint, bone in matched.items()}
    joint = carrier(mesh.parent_bone, bones, joint_of)
    weights = np.zeros((len(mesh.data.vertices), 24))
    if joint is not None:
        weights[:, joint] = 1
    return weights


def _rest_world(mesh: bpy.types.Object, armature: bpy.types.Object) -> np.ndarray:
    """World matrix of a mesh in the rest pose; one that hangs at a bone moves with it."""
    world = matrix(mesh.matrix_world)
    if mesh.parent != armature or mesh.parent_type != "BONE" or mesh.parent_bone not in armature.pose.bones:
        return world
    posed = armature.pose.bones[mesh.parent_bone]
    place = matrix(armature.matrix_world)
    back = matrix(posed.bone.matrix_local) @ np.linalg.inv(matrix(posed.matrix))
    return place @ back @ np.linalg.inv(place) @ world


def _check_fit(figure: Character) -> None:
    """Refuse a skeleton that does not lie in the skin."""
    places = np.full((figure.weights.shape[1], 3), np.nan)
    places[[*figure.joints]] = [*figure.joints.values()]
    apart = np.linalg.norm(figure.vertices - places[figure.weights.argmax(axis=1)], axis=1)
    apart = apart[np.isfinite(apart) & (figure.weights.max(axis=1) > 0)]
    if len(apart) and np.median(apart) > APART * _extent(places[np.isfinite(places).all(axis=1)]):
        raise ValueError(
            "Its bones lie far from the skin that they move; Blender's FBX importer before 4.5 leaves some "
            "files so. Import the file with Blender 4.5 or later, or fit the bones to the skin in Edit Mode"
        )


def _extent(points: np.ndarray) -> float:
    return float(np.ptp(points, axis=0).max())
