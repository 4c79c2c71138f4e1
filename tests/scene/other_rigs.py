# SPDX-License-Identifier: GPL-3.0-or-later
"""Our body on the rigs of other tools: their bones by name, parent and place, as these tools set them up."""

from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np

from w2w.core.body.body import JOINT_INDEX, PARENTS, Body
from w2w.core.retargeting.bone_maps import best_match
from w2w.scene.body.character import POINT


@dataclass(frozen=True)
class Bone:
    """A bone: it begins at a joint, or part of the way to where that joint's segment ends.

    `shares` says whether the vertices of the joint are on it, too.
    """

    name: str
    parent: str
    joint: str
    along: float = 0.0
    shares: bool = True


def sided(rows: str, sides: tuple[tuple[str, str], ...]) -> list[Bone]:
    """Bones from lines of name, parent, joint and, where given, part of the way; ``#`` marks a helper.

    A line that holds ``{}`` stands for a bone on each side.
    """
    bones = []
    for line in rows.strip().splitlines():
        name, parent, joint, *along = line.replace("#", "").split()
        for side, mark in sides if "{}" in line else (("", ""),):
            names = [text.replace("{}", mark) for text in (name, parent)]
            where = joint.replace("*", f"{side}_")
            bones.append(
                Bone(names[0], names[1].strip("-"), where, *map(float, along), shares="#" not in line)
            )
    return bones


LOWER, CAPITAL, DOTTED = (
    (("left", left), ("right", right)) for left, right in (("_l", "_r"), ("L", "R"), (".L", ".R"))
)

UNREAL = sided(
    """
    root - pelvis #
    pelvis root pelvis
    spine_01 pelvis spine1
    spine_02 spine_01 spine2
    spine_03 spine_02 spine3
    neck_01 spine_03 neck
    head neck_01 head
    clavicle{} spine_03 *collar
    upperarm{} clavicle{} *shoulder
    upperarm_twist_01{} upperarm{} *shoulder 0.4
    lowerarm{} upperarm{} *elbow
    lowerarm_twist_01{} lowerarm{} *elbow 0.6
    hand{} lowerarm{} *wrist
    middle_01{} hand{} *hand
    thigh{} pelvis *hip
    thigh_twist_01{} thigh{} *hip 0.4
    calf{} thigh{} *knee
    calf_twist_01{} calf{} *knee 0.5
    foot{} calf{} *ankle
    ball{} foot{} *foot
    ik_foot_root root pelvis #
    ik_foot{} ik_foot_root *ankle #
    ik_hand_root root pelvis #
    ik_hand{} ik_hand_root *wrist #
    """,
    LOWER,
)

UNREAL_5 = [
    *(bone for bone in UNREAL if not bone.name.startswith(("spine", "neck", "head", "clavicle", "middle"))),
    *sided(
        """
        spine_01 pelvis spine1
        spine_02 spine_01 spine1 0.5
        spine_03 spine_02 spine2
        spine_04 spine_03 spine2 0.5
        spine_05 spine_04 spine3
        neck_01 spine_05 neck
        neck_02 neck_01 neck 0.5
        head neck_02 head
        clavicle{} spine_05 *collar
        middle_metacarpal{} hand{} *wrist 0.5
        middle_01{} middle_metacarpal{} *hand
        """,
        LOWER,
    ),
]

VROID = sided(
    """
    Root - pelvis #
    J_Bip_C_Hips Root pelvis
    J_Bip_C_Spine J_Bip_C_Hips spine1
    J_Bip_C_Chest J_Bip_C_Spine spine2
    J_Bip_C_UpperChest J_Bip_C_Chest spine3
    J_Bip_C_Neck J_Bip_C_UpperChest neck
    J_Bip_C_Head J_Bip_C_Neck head
    J_Sec_Hair1_01 J_Bip_C_Head head 0.9
    J_Sec_{}_Bust1 J_Bip_C_UpperChest spine3 0.5
    J_Bip_{}_Shoulder J_Bip_C_UpperChest *collar
    J_Bip_{}_UpperArm J_Bip_{}_Shoulder *shoulder
    J_Bip_{}_LowerArm J_Bip_{}_UpperArm *elbow
    J_Bip_{}_Hand J_Bip_{}_LowerArm *wrist
    J_Bip_{}_Middle1 J_Bip_{}_Hand *hand
    J_Bip_{}_UpperLeg J_Bip_C_Hips *hip
    J_Bip_{}_LowerLeg J_Bip_{}_UpperLeg *knee
    J_Bip_{}_Foot J_Bip_{}_LowerLeg *ankle
    J_Bip_{}_ToeBase J_Bip_{}_Foot *foot
    """,
    CAPITAL,
)

VRM = sided(
    """
    hips - pelvis
    spine hips spine1
    chest spine spine2
    neck chest neck
    head neck head
    {}Shoulder chest *collar
    {}UpperArm {}Shoulder *shoulder
    {}LowerArm {}UpperArm *elbow
    {}Hand {}LowerArm *wrist
    {}UpperLeg hips *hip
    {}LowerLeg {}UpperLeg *knee
    {}Foot {}LowerLeg *ankle
    """,
    (("left", "left"), ("right", "right")),
)

MAKEHUMAN = sided(
    """
    root - pelvis
    spine05 root pelvis 0.2
    spine04 spine05 pelvis 0.6
    spine03 spine04 spine1
    spine02 spine03 spine2
    spine01 spine02 spine3
    neck01 spine01 neck
    neck02 neck01 neck 0.3
    neck03 neck02 neck 0.7
    head neck03 head
    breast{} spine02 spine2 0.5
    clavicle{} spine01 *collar
    shoulder01{} clavicle{} *collar 0.6
    upperarm01{} shoulder01{} *shoulder
    upperarm02{} upperarm01{} *shoulder 0.5
    lowerarm01{} upperarm02{} *elbow
    lowerarm02{} lowerarm01{} *elbow 0.5
    wrist{} lowerarm02{} *wrist
    metacarpal2{} wrist{} *wrist 0.3
    finger3-1{} metacarpal2{} *hand
    pelvis{} root pelvis 0.1
    upperleg01{} pelvis{} *hip
    upperleg02{} upperleg01{} *hip 0.5
    lowerleg01{} upperleg02{} *knee
    lowerleg02{} lowerleg01{} *knee 0.5
    foot{} lowerleg02{} *ankle
    toe1-1{} foot{} *foot
    toe2-1{} foot{} *foot
    """,
    DOTTED,
)

RIGIFY_DEFORM = sided(
    """
    root - pelvis #
    DEF-spine root pelvis
    DEF-pelvis{} DEF-spine pelvis 0.1
    DEF-spine.001 DEF-spine spine1
    DEF-spine.002 DEF-spine.001 spine2
    DEF-spine.003 DEF-spine.002 spine3
    DEF-spine.004 DEF-spine.003 neck
    DEF-spine.005 DEF-spine.004 neck 0.5
    DEF-spine.006 DEF-spine.005 head
    DEF-shoulder{} DEF-spine.003 *collar
    DEF-upper_arm{} DEF-shoulder{} *shoulder
    DEF-upper_arm{}.001 DEF-upper_arm{} *shoulder 0.5
    DEF-forearm{} DEF-upper_arm{}.001 *elbow
    DEF-forearm{}.001 DEF-forearm{} *elbow 0.5
    DEF-hand{} DEF-forearm{}.001 *wrist
    DEF-f_middle.01{} DEF-hand{} *hand
    DEF-thigh{} DEF-spine *hip
    DEF-thigh{}.001 DEF-thigh{} *hip 0.5
    DEF-shin{} DEF-thigh{}.001 *knee
    DEF-shin{}.001 DEF-shin{} *knee 0.5
    DEF-foot{} DEF-shin{}.001 *ankle
    DEF-toe{} DEF-foot{} *foot
    """,
    DOTTED,
)

RIGS = {
    "Unreal 4": UNREAL,
    "Unreal 5": UNREAL_5,
    "VRoid": VROID,
    "VRM": VRM,
    "MakeHuman and MPFB": MAKEHUMAN,
    "Rigify": RIGIFY_DEFORM,
}


def end_of(body: Body, joint: int) -> np.ndarray:
    """Where a joint's segment ends: at its farthest child, or a little on."""
    children = [child for child, parent in enumerate(PARENTS) if parent == joint]
    middle = [child for child in children if abs(body.joints[child, 0]) < 0.02] or children
    return body.joints[middle[0]] if middle else body.joints[joint] + [0, 0, 0.08]


def add_rigged(
    body: Body, bones: list[Bone], name: str = "Hero"
) -> tuple[bpy.types.Object, bpy.types.Object]:
    """Our body's skin on such a rig; gives the armature and the mesh."""
    armature = bpy.data.objects.new(name, bpy.data.armatures.new(name))
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for bone in bones:
        joint = JOINT_INDEX[bone.joint]
        way = end_of(body, joint) - body.joints[joint]
        made = armature.data.edit_bones.new(bone.name)
        made.head = body.joints[joint] + bone.along * way
        made.tail = made.head + type(made.head)(0.1 * way + [0, 0, 1e-3])
    for bone in bones:
        if bone.parent:
            armature.data.edit_bones[bone.name].parent = armature.data.edit_bones[bone.parent]
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature, add_skin(body, armature, {bone.name: bone.joint for bone in bones if bone.shares})


def add_skin(body: Body, armature: bpy.types.Object, joint_of: dict[str, str]) -> bpy.types.Object:
    """Our body's skin: bones share the vertices of the joint they play, or a parent of it does."""
    data = bpy.data.meshes.new("Skin")
    data.from_pydata(body.vertices.tolist(), [], body.faces.tolist())
    mesh = bpy.data.objects.new("Skin", data)
    bpy.context.scene.collection.objects.link(mesh)
    weights = body.weights.copy()
    for joint in range(len(PARENTS) - 1, 0, -1):
        if joint not in {JOINT_INDEX[name] for name in joint_of.values()}:
            weights[:, PARENTS[joint]] += weights[:, joint]
    players = list(joint_of.values())
    for bone, joint in joint_of.items():
        share = weights[:, JOINT_INDEX[joint]] / players.count(joint)
        group = mesh.vertex_groups.new(name=bone)
        for vertex in np.flatnonzero(share > 0).tolist():
            group.add((vertex,), float(share[vertex]), "REPLACE")
    mesh.parent = armature
    mesh.modifiers.new("Armature", "ARMATURE").object = armature
    bpy.context.view_layer.update()
    return mesh


def distance_from_itself(body: Body, mesh: bpy.types.Object) -> np.ndarray:
    """How far each vertex of a skin of ours is from where it was laid, metres."""
    values = np.empty(len(mesh.data.vertices) * 3, dtype=np.float32)
    mesh.data.attributes[POINT].data.foreach_get("vector", values)
    face, first, second = values.reshape(-1, 3).T
    corners = body.vertices[body.faces[face.astype(int)]]
    shares = np.stack([first, second, 1 - first - second], axis=1)
    return np.linalg.norm(np.einsum("vc,vca->va", shares, corners) - body.vertices, axis=1)


def fit_metarig(metarig: bpy.types.Object, body: Body) -> None:
    """Move the bones of Rigify's human to the joints of a body, each with what hangs on it."""
    _, matched = best_match([bone.name for bone in metarig.data.bones])
    joint_of = {metarig.data.bones[bone].name: joint for joint, bone in matched.items()}
    bpy.ops.object.mode_set(mode="EDIT")
    bones = metarig.data.edit_bones
    before = {bone.name: bone.head.copy() for bone in bones}
    for bone in bones:
        carrier = bone
        while carrier.name not in joint_of and carrier.parent is not None:
            carrier = carrier.parent
        joint = joint_of.get(carrier.name, 0)
        move = type(bone.head)(body.joints[joint]) - before[carrier.name]
        if bone.name in joint_of:
            bone.head = body.joints[joint]
            if not bone.children or not bone.children[0].use_connect:
                bone.tail = end_of(body, joint)
        elif not bone.use_connect:
            bone.head, bone.tail = before[bone.name] + move, bone.tail + move
    bpy.ops.object.mode_set(mode="OBJECT")
