# SPDX-License-Identifier: GPL-3.0-or-later
"""A user's own body from Blender: a rigged FBX, or a mesh in the scene, with SMPL's bone names or faces."""

from pathlib import Path

import numpy as np

from ...core.adopt.smpl import MOST_CORNERS, BodyError, body_from_mesh, body_from_rig, load_body, padded
from ...core.body.body import BODY_HANDS, JOINT_INDEX, JOINT_NAMES, N_JOINTS, Body
from ...core.motion.source import UnusableMotion
from ...core.retargeting.bone_maps import BONE_MAPS, BoneMap
from ...core.wording import restated
from ..base.body import group_weights, matrix, moved, read_values, rest_vertices, triangles_of
from ..base.module import bpy
from ..motion.takes import imported

WRISTS = {BODY_HANDS[0]: JOINT_INDEX["left_wrist"], BODY_HANDS[1]: JOINT_INDEX["right_wrist"]}
"""Wrists of the hands, for which a rig of SMPL-H or SMPL-X has fingers instead."""


def adopt_file(path: str | Path, betas: np.ndarray | None = None) -> Body:
    """Read a body from a rigged FBX with SMPL's bone names, or from any file that `load_body` reads.

    `betas` are shape coefficients for an official SMPL model. Raises `BodyError` if it is none of these; the
    message says what was expected and what was found.
    """
    path = Path(path)
    if path.suffix.lower() != ".fbx":
        return load_body(path, betas)
    if betas is not None:
        raise BodyError(f"{path}: a rigged mesh has a shape of its own: betas need an official SMPL model")
    with restated(f"{path}:", (BodyError, UnusableMotion), BodyError), imported(path) as objects:
        meshes = [item for item in objects if item.type == "MESH"]
        if not meshes:
            kinds = ", ".join(sorted({item.type.lower() for item in objects})) or "nothing"
            raise BodyError(f"expected a mesh moved by bones with SMPL's names, found only: {kinds}")
        return adopt_mesh(max(meshes, key=lambda mesh: (_is_smpl_rigged(mesh), len(mesh.data.vertices))))


def adopt_mesh(mesh: bpy.types.Object) -> Body:
    """A body from a mesh in the scene, in the T-pose, z up, facing -y, metres, soles on z = 0.

    The mesh is taken in its armature's rest pose; nothing in the scene changes. Bones are known by SMPL's
    names in any of their spellings (``L_Hip``, ``left_hip``, ``m_avg_L_Hip``); weights of fingers, jaw and
    eyes go to the joint that carries them. Without such bones the mesh must have SMPL's faces. Raises
    `BodyError` if it is no mesh, its bones are not SMPL's, or it has neither bones nor SMPL's faces.
    """
    if mesh.type != "MESH":
        raise BodyError(f"'{mesh.name}' is a {mesh.type.lower()}: choose the mesh of a body")
    if len(mesh.data.polygons) == 0:
        raise BodyError(f"the mesh '{mesh.name}' has no faces")
    vertices = moved(rest_vertices(mesh), matrix(mesh.matrix_world))
    polygons = _polygons(mesh.data)
    armature = moving_armature(mesh)
    if armature is None:
        without = f"the mesh '{mesh.name}' has no armature, and"
        with restated(lambda error: f"{without} {error}", BodyError, BodyError):
            return body_from_mesh(vertices, polygons, mesh.name)
    bones = list(armature.data.bones)
    matched = _smpl_bones(armature)
    needed = [joint for joint in range(N_JOINTS) if joint not in BODY_HANDS]
    missing = [JOINT_NAMES[joint] for joint in needed if joint not in matched]
    if missing:
        raise BodyError(
            f"the mesh '{mesh.name}' is moved by '{armature.name}', whose bones are not SMPL's: expected "
            "Pelvis, L_Hip, ... or pelvis, left_hip, ...; no bone was found for "
            f"{', '.join(missing[:6])} among {', '.join(bone.name for bone in bones[:6])}, ..."
        )
    heads = moved(np.array([bone.head_local for bone in bones], float), matrix(armature.matrix_world))
    joints = np.empty((N_JOINTS, 3))
    joints[[*matched]] = heads[[*matched.values()]]
    for hand in set(BODY_HANDS) - matched.keys():  # where its fingers begin; at the wrist without fingers
        wrist = matched[WRISTS[hand]]
        fingers = [index for index, bone in enumerate(bones) if bone.parent == bones[wrist]]
        joints[hand] = heads[fingers or [wrist]].mean(axis=0)
    return body_from_rig(vertices, polygons, joints, joint_weights(mesh, bones, matched), mesh.name)


def _is_smpl_rigged(mesh: bpy.types.Object) -> bool:
    armature = moving_armature(mesh)
    return armature is not None and len(_smpl_bones(armature)) >= N_JOINTS - len(BODY_HANDS)


def moving_armature(mesh: bpy.types.Object) -> bpy.types.Object | None:
    """The armature that moves a mesh, by modifier or as its parent."""
    moving = [item.object for item in mesh.modifiers if item.type == "ARMATURE" and item.object is not None]
    if not moving and mesh.parent is not None and mesh.parent_type == "ARMATURE":
        moving = [mesh.parent]
    return moving[0] if moving else None


def _smpl_bones(armature: bpy.types.Object) -> dict[int, int]:
    """Joint index -> index of the armature's bone."""
    return BoneMap.load(BONE_MAPS / "smpl.json").match([bone.name for bone in armature.data.bones])


def joint_weights(mesh: bpy.types.Object, bones: list[bpy.types.Bone], matched: dict[int, int]) -> np.ndarray:
    """Weights of the 24 joints, shape (V, 24); other bones' weights go to the joint that carries them."""
    joint_of_bone = {bones[bone].name: joint for joint, bone in matched.items()}
    hands = {wrist: hand for hand, wrist in WRISTS.items() if hand not in matched}
    joints = {}
    for group in mesh.vertex_groups:
        joint = carrier(group.name, bones, joint_of_bone)
        if joint is not None:
            joints[group.index] = joint if group.name in joint_of_bone else hands.get(joint, joint)
    return group_weights(mesh, joints)


def carrier(name: str, bones: list[bpy.types.Bone], joint_of_bone: dict[str, int]) -> int | None:
    """The joint that moves the bone of a name: its own or that of the nearest bone above it."""
    bone = next((bone for bone in bones if bone.name == name), None)
    while bone is not None and bone.name not in joint_of_bone:
        bone = bone.parent
    return None if bone is None else joint_of_bone[bone.name]


def _polygons(mesh: bpy.types.Mesh) -> np.ndarray:
    """Polygons, shape (F, 4), -1 behind triangles; cut into triangles where one has more corners."""
    sizes = read_values(mesh.polygons, "loop_total", len(mesh.polygons), np.int32)
    if sizes.max() > MOST_CORNERS:
        return np.pad(triangles_of(mesh), ((0, 0), (0, 1)), constant_values=-1)
    return padded(read_values(mesh.loops, "vertex_index", len(mesh.loops), np.int32), sizes)
