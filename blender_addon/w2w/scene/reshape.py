# SPDX-License-Identifier: GPL-3.0-or-later
"""Another shape for a body in the scene, in place: what rides on it and what moves it stay."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from ..core.body.body import Body
from ..core.body.skeleton import JOINT_NAMES
from . import actions
from .body import armature_of, matrix
from .fcurves import rescale

PELVIS = JOINT_NAMES[0]


def reshape_body(mesh: bpy.types.Object, body: Body, motions: Iterable[bpy.types.Action] = ()) -> None:
    """Give a body in the scene the vertices and joints of another shape of it.

    Bones keep their directions, so that the rotations in actions mean the same motion as before.
    The pelvis's path is scaled by its height over the floor, as longer legs take longer steps.
    Faces, weights, vertex groups, colours and whatever is parented to the surface stay.

    Parameters
    ----------
    mesh : Object
        A body that `add_body` made.
    body : Body
        The same body in another shape: as many vertices, soles on z = 0.
    motions : iterable of Action
        Actions of its armature to fit to the new shape.

    Raises
    ------
    ValueError
        If the mesh has other vertices than the body or shape keys, or its bones cannot be edited now.
    """
    _check(mesh, body)
    armature = armature_of(mesh)
    before = _pelvis(armature)
    mesh.data.vertices.foreach_set("co", body.vertices.astype(np.float32).ravel())
    mesh.data.update()
    _move_bones(armature, body.joints)
    after = _pelvis(armature)
    for action in motions:
        _fit_path(armature, action, before, after)


def _check(mesh: bpy.types.Object, body: Body) -> None:
    armature = armature_of(mesh)
    if bpy.context.mode != "OBJECT":
        raise ValueError("go back to object mode first: a body is reshaped in no other")
    if bpy.context.view_layer.objects.get(armature.name) != armature:
        raise ValueError(f"'{armature.name}' is in no visible collection: its bones could not follow")
    if len(mesh.data.vertices) != len(body.vertices):
        raise ValueError(
            f"'{mesh.name}' has {len(mesh.data.vertices)} vertices, the body has {len(body.vertices)}: "
            "a mesh that was edited cannot be reshaped"
        )
    if mesh.data.shape_keys is not None:
        raise ValueError(f"'{mesh.name}' has shape keys, which hold its old shape: remove them first")


def _pelvis(armature: bpy.types.Object) -> np.ndarray:
    return np.array(armature.data.bones[PELVIS].head_local, dtype=np.float64)


def _move_bones(armature: bpy.types.Object, joints: np.ndarray) -> None:
    """Move each bone to its joint; that goes in edit mode only, and needs an active, visible object."""
    view_layer = bpy.context.view_layer
    active, hidden = view_layer.objects.active, armature.hide_get()
    others = [item for item in bpy.context.selected_objects if item.type == "ARMATURE" and item != armature]
    for item in others:  # they would go into edit mode along with this one
        item.select_set(False)
    armature.hide_set(False)
    view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        for joint, name in enumerate(JOINT_NAMES):
            bone = armature.data.edit_bones[name]
            along, roll = np.array(bone.tail) - np.array(bone.head), bone.roll
            bone.head, bone.tail = joints[joint], joints[joint] + along
            bone.roll = roll
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")
        armature.hide_set(hidden)
        view_layer.objects.active = active
        for item in others:
            item.select_set(True)


def _fit_path(
    armature: bpy.types.Object, action: bpy.types.Action, before: np.ndarray, after: np.ndarray
) -> None:
    """Scale the pelvis's path; its curves hold the way from the rest position, in the bone's own axes."""
    scale = after[2] / before[2]
    rest = matrix(armature.data.bones[PELVIS].matrix_local)[:3, :3]
    shift = rest.T @ (scale * before - after)
    curves = actions.bone_curves(armature, action).get(PELVIS, {})
    for axis in range(3):
        if ("location", axis) in curves:
            rescale(curves["location", axis], 1, scale, shift[axis])
