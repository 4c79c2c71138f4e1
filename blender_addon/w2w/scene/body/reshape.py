# SPDX-License-Identifier: GPL-3.0-or-later
"""Another shape for a body in the scene, in place: what rides on it and what moves it stay."""

from __future__ import annotations

from collections.abc import Iterable

import bpy
import numpy as np

from ...core.body.body import Body
from ...core.body.skeleton import JOINT_NAMES
from ..base import actions
from ..base.body import armature_of, editing, matrix
from ..base.fcurves import rescale

PELVIS = JOINT_NAMES[0]


def reshape_body(mesh: bpy.types.Object, body: Body, motions: Iterable[bpy.types.Action] = ()) -> None:
    """Give a body that `add_body` made the vertices and joints of another shape of it, soles on z = 0.

    Bones keep their directions, so that the rotations in actions mean the same motion as before. The pelvis's
    path in `motions` is scaled by its height over the floor, as longer legs take longer steps. Faces,
    weights, vertex groups, colours and whatever is parented to the surface stay. Raises `ValueError` if the
    mesh has other vertices than the body or shape keys, or its bones cannot be edited now.
    """
    _check(mesh, body)
    armature = armature_of(mesh)
    before = np.array(armature.data.bones[PELVIS].head_local, dtype=np.float64)
    mesh.data.vertices.foreach_set("co", body.vertices.astype(np.float32).ravel())
    mesh.data.update()
    with editing(armature) as bones:
        for joint, name in enumerate(JOINT_NAMES):
            bone = bones[name]
            along, roll = np.array(bone.tail) - np.array(bone.head), bone.roll
            bone.head, bone.tail = body.joints[joint], body.joints[joint] + along
            bone.roll = roll
    after = np.array(armature.data.bones[PELVIS].head_local, dtype=np.float64)
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
