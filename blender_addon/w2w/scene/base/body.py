# SPDX-License-Identifier: GPL-3.0-or-later
"""A body in the scene: its mesh, its armature of 24 SMPL-named bones, and back again."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ...core.body.body import JOINT_INDEX, JOINT_NAMES, PARENTS, Body
from ...core.motion.examples import SINGLE
from .module import bmesh, bpy

MIRROR_ATTRIBUTE = "mirror vertex"
"""Integer attribute with each vertex's mirror image, on meshes that know it."""

AIMS = {
    "pelvis": "spine1", "left_hip": "left_knee", "right_hip": "right_knee", "spine1": "spine2",
    "left_knee": "left_ankle", "right_knee": "right_ankle", "spine2": "spine3", "left_ankle": "left_foot",
    "right_ankle": "right_foot", "spine3": "neck", "neck": "head", "left_collar": "left_shoulder",
    "right_collar": "right_shoulder", "left_shoulder": "left_elbow", "right_shoulder": "right_elbow",
    "left_elbow": "left_wrist", "right_elbow": "right_wrist", "left_wrist": "left_hand",
    "right_wrist": "right_hand",
}  # fmt: skip
"""Joint that each bone points at; the others go on in the direction of their parent."""


class BodyObjects(NamedTuple):
    """A body in the scene."""

    mesh: bpy.types.Object
    armature: bpy.types.Object


def add_body(body: Body, collection: bpy.types.Collection | None = None, name: str = "") -> BodyObjects:
    """Add a body's mesh and armature to the scene, or to a collection.

    The bones point from joint to joint, so that the armature can be posed by hand; the mesh
    follows by vertex groups and an armature modifier alone, as Blender skins: linearly.
    """
    collection = collection or bpy.context.scene.collection
    name = name or body.name
    armature = bpy.data.objects.new(f"{name} Armature", bpy.data.armatures.new(f"{name} Armature"))
    collection.objects.link(armature)
    tails = _bone_tails(body.joints)
    with editing(armature) as bones:
        for joint, bone_name in enumerate(JOINT_NAMES):
            bone = bones.new(bone_name)
            bone.head, bone.tail = body.joints[joint], tails[joint]
            bone.align_roll((0.0, -1.0, 0.0))
            if PARENTS[joint] >= 0:
                bone.parent = bones[JOINT_NAMES[PARENTS[joint]]]
    armature.data.display_type = "STICK"
    return BodyObjects(add_skinned(body, armature, collection, name), armature)


def add_skinned(
    body: Body, armature: bpy.types.Object, collection: bpy.types.Collection, name: str
) -> bpy.types.Object:
    """Add a mesh that an armature of `add_body` moves, in the body that it was made for."""
    mesh = bpy.data.objects.new(name, _new_mesh(body, name))
    collection.objects.link(mesh)
    _add_weights(mesh, body.weights)
    mesh.parent = armature
    mesh.modifiers.new("Armature", "ARMATURE").object = armature
    return mesh


def reskin(item: bpy.types.Object, body: Body) -> None:
    """Give an object of `add_skinned` another mesh, with weights of its own."""
    before = item.data
    item.data = _new_mesh(body, item.name)
    bpy.data.meshes.remove(before)
    item.vertex_groups.clear()
    _add_weights(item, body.weights)


def body_of(mesh: bpy.types.Object) -> Body:
    """Read a body back from a mesh that 24 SMPL-named bones skin.

    The body is in the armature's space, in metres: where the armature stands, and how it is turned, is no
    property of the body. Raises `ValueError` if it is no mesh, has no armature with all 24 bones, or vertices
    that no bone weighs on.
    """
    armature = armature_of(mesh)
    heads = np.array([armature.data.bones[name].head_local for name in JOINT_NAMES], dtype=np.float64)
    vertices = in_body_space(mesh, armature)
    named = [group for group in mesh.vertex_groups if group.name in JOINT_INDEX]
    weights = group_weights(mesh, {group.index: JOINT_INDEX[group.name] for group in named})
    sums = weights.sum(axis=1)
    if (sums <= 0).any():
        raise ValueError(f"{(sums <= 0).sum()} vertices of '{mesh.name}' follow none of the 24 bones")
    mirror = mesh.data.attributes.get(MIRROR_ATTRIBUTE)
    body = Body(
        vertices=vertices,
        faces=triangles_of(mesh.data),
        joints=heads @ body_space(armature)[:3, :3].T,
        weights=weights / sums[:, None],  # Blender, too, normalises when it skins
        name=mesh.name,
        mirror=None if mirror is None else read_values(mirror.data, "value", len(vertices), np.int32),
    )
    bundled = Body.bundled()
    is_bundled = np.array_equal(body.faces, bundled.faces) and all(
        np.abs(getattr(body, name) - getattr(bundled, name)).max() < SINGLE
        for name in ("vertices", "joints", "weights")
    )
    return replace(bundled, name=mesh.name, mirror=body.mirror) if is_bundled else body  # to the last bit


def armature_of(mesh: bpy.types.Object) -> bpy.types.Object:
    """The armature that skins a body's mesh; a `ValueError` if none has all 24 SMPL-named bones."""
    if mesh.type != "MESH":
        raise ValueError(f"'{mesh.name}' is not a mesh: choose the mesh of a body")
    armatures = [m.object for m in mesh.modifiers if m.type == "ARMATURE" and m.object is not None]
    if not armatures:
        raise ValueError(f"'{mesh.name}' has no armature modifier: choose a mesh that an armature moves")
    complete = [a for a in armatures if not set(JOINT_NAMES) - set(a.data.bones.keys())]
    if not complete:
        missing = [name for name in JOINT_NAMES if name not in armatures[0].data.bones]
        raise ValueError(f"the armature '{armatures[0].name}' lacks the bones {', '.join(missing)}")
    return complete[0]


def body_space(armature: bpy.types.Object) -> np.ndarray:
    """Matrix from the armature's space to the body's: its scale alone, shape (4, 4)."""
    return np.diag([*np.linalg.norm(matrix(armature.matrix_world)[:3, :3], axis=0), 1.0])


def in_body_space(mesh: bpy.types.Object, armature: bpy.types.Object) -> np.ndarray:
    """Undeformed vertices (V, 3) of a mesh in the space of an armature's body, metres."""
    to_body = body_space(armature) @ np.linalg.inv(matrix(armature.matrix_world)) @ matrix(mesh.matrix_world)
    return moved(rest_vertices(mesh), to_body)


def with_parents(item: bpy.types.Object) -> Iterator[bpy.types.Object]:
    """An object and everything that it is parented to."""
    while item is not None:
        yield item
        item = item.parent


def moved(points: np.ndarray, transform: np.ndarray) -> np.ndarray:
    """Points (N, 3) under a transform (4, 4)."""
    return points @ transform[:3, :3].T + transform[:3, 3]


def rest_vertices(mesh: bpy.types.Object) -> np.ndarray:
    """Undeformed vertex positions in the mesh's own space, shape (V, 3)."""
    vertices = mesh.data.vertices
    return read_values(vertices, "co", len(vertices) * 3, np.float32).reshape(-1, 3).astype(float)


def matrix(value: bpy.types.bpy_struct) -> np.ndarray:
    """A Blender matrix as float64."""
    return np.array(value, dtype=np.float64)


@contextmanager
def editing(armature: bpy.types.Object) -> Iterator[bpy.types.ArmatureEditBones]:
    """Bones of an armature to make and move: that goes in edit mode only, on an active, visible object."""
    hidden = armature.hide_get()
    with same_selection():
        select(())  # armatures would go into edit mode along with this one
        armature.hide_set(False)
        bpy.context.view_layer.objects.active = armature
        bpy.ops.object.mode_set(mode="EDIT")
        try:
            yield armature.data.edit_bones
        finally:
            bpy.ops.object.mode_set(mode="OBJECT")
            armature.hide_set(hidden)


@contextmanager
def same_selection() -> Iterator[None]:
    """Let the same objects be selected and active at the end as before."""
    objects = bpy.context.view_layer.objects
    active, selected = objects.active, [item for item in objects if item.select_get()]
    try:
        yield
    finally:
        select(selected)
        objects.active = active


def select(items: Iterable[bpy.types.Object]) -> None:
    """Select these objects and no others."""
    for item in bpy.context.selected_objects:
        item.select_set(False)
    for item in items:
        item.select_set(True)


def _bone_tails(joints: np.ndarray) -> np.ndarray:
    tails = np.empty_like(joints)
    for joint, name in enumerate(JOINT_NAMES):
        # a bone that ends in no joint is 0.6 times as long as its parent
        leaf = joints[joint] + 0.6 * (joints[joint] - joints[PARENTS[joint]])
        tails[joint] = joints[JOINT_INDEX[AIMS[name]]] if name in AIMS else leaf
    # Blender's matrices lose two digits in bones that point straight against their parent, as legs would
    tails[0, 1] -= 0.5 * np.linalg.norm(tails[0] - joints[0])
    return tails


def _new_mesh(body: Body, name: str) -> bpy.types.Mesh:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(body.vertices.tolist(), [], body.faces.tolist())  # of arrays it takes twice as long
    mesh.shade_smooth()
    if body.mirror is not None:
        mesh.attributes.new(MIRROR_ATTRIBUTE, "INT", "POINT").data.foreach_set("value", body.mirror)
    return mesh


def _add_weights(mesh: bpy.types.Object, weights: np.ndarray) -> None:
    for joint, name in enumerate(JOINT_NAMES):
        group = mesh.vertex_groups.new(name=name)
        of_group = weights[:, joint]
        for vertex in np.flatnonzero(of_group).tolist():
            group.add((vertex,), of_group[vertex], "REPLACE")


def group_weights(mesh: bpy.types.Object, joints: dict[int, int]) -> np.ndarray:
    """Weights of the 24 joints, shape (V, 24), added up from the vertex groups that each joint has."""
    weights = np.zeros((len(mesh.data.vertices), len(JOINT_NAMES)))
    copy = bmesh.new()  # gives the groups of a vertex in half the time that the mesh itself takes
    copy.from_mesh(mesh.data)
    groups = copy.verts.layers.deform.active
    for number, vertex in enumerate(copy.verts if groups else ()):
        for group, weight in vertex[groups].items():
            if group in joints:
                weights[number, joints[group]] += weight
    copy.free()
    return weights


def triangles_of(mesh: bpy.types.Mesh) -> np.ndarray:
    """Triangles of a mesh as Blender cuts it, shape (F, 3)."""
    mesh.calc_loop_triangles()
    return read_values(mesh.loop_triangles, "vertices", len(mesh.loop_triangles) * 3, np.int32).reshape(-1, 3)


def read_values(items: bpy.types.bpy_prop_collection, name: str, size: int, dtype: type) -> np.ndarray:
    """One property of all items of a collection, as a flat array of this size."""
    values: np.ndarray = np.empty(size, dtype=dtype)
    items.foreach_get(name, values)
    return values


def painted_colours(attribute: bpy.types.Attribute) -> np.ndarray:
    """sRGB colours (V, 3) of a colour attribute."""
    return read_values(attribute.data, "color_srgb", 4 * len(attribute.data), np.float32).reshape(-1, 4)[
        :, :3
    ]
