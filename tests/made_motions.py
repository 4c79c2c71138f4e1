# SPDX-License-Identifier: GPL-3.0-or-later
"""Motions made from sines, and files of them as many kinds of rig hold them: the truth is known for all."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.retargeting.bone_maps import BONE_MAPS
from w2w_studies.rehab.skeleton import BONE_INDEX, BONE_PARENTS, BONES, Figure

SECONDS = 3.0
SPEED = 1.2
"""Of a walk that travels, m/s."""

SIGNS = {"Left": 1.0, "Right": -1.0}
Y_UP = Rotation.from_euler("x", -90, degrees=True).as_matrix()
"""World axes (z up) to those of a rig with y up."""

PLAYED_BY = {
    "pelvis": "Hips", "spine1": "Spine", "spine2": "Spine1", "spine3": "Spine2", "neck": "Neck",
    "head": "Head",
} | {
    f"{side.lower()}_{joint}": side + bone
    for side in SIGNS
    for joint, bone in (
        ("collar", "Shoulder"), ("shoulder", "Arm"), ("elbow", "ForeArm"), ("wrist", "Hand"),
        ("hand", "HandMiddle1"), ("hip", "UpLeg"), ("knee", "Leg"), ("ankle", "Foot"), ("foot", "ToeBase"),
    )
}  # fmt: skip
"""Joint of the body -> bone of the figure."""


@dataclass(frozen=True, eq=False)
class MadeClip:
    """A motion on the figure's 27 bones.

    Parameters
    ----------
    activity : str
    rest : ndarray, shape (27, 3)
        Joints in the T-pose, metres, z up, facing -y.
    turns : ndarray, shape (T, 27, 3, 3)
        World rotation of each bone relative to the T-pose.
    heads : ndarray, shape (T, 27, 3)
        World positions, metres.
    rate : float
    """

    activity: str
    rest: np.ndarray
    turns: np.ndarray
    heads: np.ndarray
    rate: float


def make_clip(
    activity: str, rate: float, pace: float, size: float, lag: float, stature: float, travels: bool = False
) -> MadeClip:
    """Walking, waving or squatting for `SECONDS`.

    `pace` is in Hz, `size` scales how far joints turn, and upper arms are `lag` radians ahead of the rest.
    """
    figure = Figure(stature=stature)
    rest = figure.rest()
    time = np.arange(round(SECONDS * rate) + 1) / rate
    phase = 2 * np.pi * pace * time
    move = {"walking": _walking, "waving": _waving, "squatting": _squatting}[activity]
    local, rise = move(phase, size, lag)
    hips = rest[0] + np.stack([0 * time, -SPEED * time * travels, rise * figure.thigh], axis=1)
    turns, heads = posed(rest, local, hips)
    return MadeClip(activity, rest, turns, heads, rate)


def posed(rest: np.ndarray, local: dict[str, np.ndarray], hips: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """World rotations (T, 27, 3, 3) and positions (T, 27, 3) of bones turned against their parents."""
    turns, heads = np.empty((len(hips), len(BONES), 3, 3)), np.empty((len(hips), len(BONES), 3))
    still = np.broadcast_to(np.eye(3), (len(hips), 3, 3))
    for bone, parent in enumerate(BONE_PARENTS):
        own = local.get(BONES[bone], still)
        turns[:, bone] = own if parent < 0 else turns[:, parent] @ own
        heads[:, bone] = (
            hips if parent < 0 else heads[:, parent] + turns[:, parent] @ (rest[bone] - rest[parent])
        )
    return turns, heads


def _about(axis: str, angle: np.ndarray) -> np.ndarray:
    return Rotation.from_euler(axis, angle[:, None]).as_matrix()


def lowered_arms(angle: float, n_frames: int) -> dict[str, np.ndarray]:
    """Both arms turned down from the T-pose."""
    return {f"{side}Arm": _about("y", np.full(n_frames, sign * angle)) for side, sign in SIGNS.items()}


def _walking(phase: np.ndarray, size: float, lag: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    local = lowered_arms(1.25, len(phase))
    for side, sign in SIGNS.items():
        swing = sign * size * np.sin(phase)
        local[f"{side}UpLeg"] = _about("x", -0.5 * swing)
        local[f"{side}Leg"] = _about("x", 0.4 * size * (1 - np.cos(phase + sign)))
        local[f"{side}Arm"] = _about("x", 0.4 * sign * size * np.sin(phase + lag)) @ local[f"{side}Arm"]
        local[f"{side}ForeArm"] = _about("z", -sign * (0.3 + 0.2 * size * (1 + np.cos(phase))))
    local["Spine1"] = _about("z", 0.1 * size * np.sin(phase))
    return local, 0.03 * np.cos(2 * phase)


def _waving(phase: np.ndarray, size: float, lag: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    local = lowered_arms(1.3, len(phase))
    local["RightArm"] = _about("y", 0.5 + 0.3 * size * np.sin(phase + lag))
    local["RightForeArm"] = _about("y", 0.6 + 0.5 * size * np.sin(2 * phase))
    local["Spine"] = _about("y", 0.03 * size * np.sin(phase))
    return local, 0 * phase


def _squatting(phase: np.ndarray, size: float, lag: float) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """Ankles stay under the hips: the knee turns twice as far as hip and ankle."""
    bend, ahead = (0.6 * size * (1 - np.cos(angle)) for angle in (0.6 * phase, 0.6 * phase + lag))
    local = lowered_arms(1.2, len(phase))
    for side in SIGNS:
        local[f"{side}UpLeg"], local[f"{side}Leg"] = _about("x", -bend), _about("x", 2 * bend)
        local[f"{side}Foot"] = _about("x", -bend)
        local[f"{side}Arm"] = _about("x", -ahead) @ local[f"{side}Arm"]
    local["Spine"] = _about("x", 0.4 * bend)
    return local, -2.004 * (1 - np.cos(bend))


# --- names that rigs give their bones


def prefixed(prefix: str) -> Callable[[str], str]:
    """Mixamo's names behind a prefix."""
    return lambda bone: prefix + bone


def of_family(file: str) -> Callable[[str], str]:
    """The first name that a bundled bone map has for each joint."""
    joints = json.loads((BONE_MAPS / f"{file}.json").read_text(encoding="utf-8"))["joints"]
    names = {bone: joints[joint] for joint, bone in PLAYED_BY.items() if joint in joints}
    names = {bone: name if isinstance(name, str) else name[0] for bone, name in names.items()}
    return lambda bone: names.get(bone, f"{bone} end")


def german(bone: str) -> str:
    """Names that no bundled map knows; `german_map` does."""
    parts = {
        "Hips": "Becken", "Spine2": "Brust", "Spine1": "Ruecken", "Spine": "Lende", "Neck": "Hals",
        "HeadTop_End": "Scheitel", "Head": "Kopf", "Shoulder": "Schluesselbein", "ForeArm": "Elle",
        "HandMiddle1": "Finger", "Hand": "Pfote", "Arm": "Oberarm", "UpLeg": "Oberschenkel",
        "Toe_End": "Spitze", "ToeBase": "Zehen", "Foot": "Fuss", "Leg": "Wade",
    }  # fmt: skip
    side = next((name for name in SIGNS if bone.startswith(name)), "")
    return parts[bone.removeprefix(side)] + {"Left": "_li", "Right": "_re", "": ""}[side]


def german_map() -> dict:
    """What a user would write as a bone map for the rig of `german` names."""
    return {"name": "Werkstatt", "joints": {joint: german(bone) for joint, bone in PLAYED_BY.items()}}


def numbered(bone: str) -> str:
    """Names that say nothing."""
    return f"n{BONE_INDEX[bone]:02d}"


# --- files

MIXAMO = prefixed("mixamorig:")


@dataclass(frozen=True, eq=False)
class Rig:
    """How a file holds a motion.

    Parameters
    ----------
    kind : {"fbx", "bvh"}
    names : callable
        Name of each of the figure's bones.
    units_per_metre : float
        Of the armature's data.
    object_scale : float
        Of the armature object.
    axes : ndarray, shape (3, 3)
        World axes to the armature's; the object (in FBX) or the format (in BVH) turns them back.
    arms_down : float
        How far the rest pose has its arms below the T-pose, radians.
    empty_take : bool
        Whether an empty take stands before the one that moves.
    file_up : {"Y", "Z"}
        The FBX file's own up axis.
    """

    kind: str = "fbx"
    names: Callable[[str], str] = MIXAMO
    units_per_metre: float = 100.0
    object_scale: float = 0.01
    axes: np.ndarray = field(default_factory=lambda: Y_UP)
    arms_down: float = 0.0
    empty_take: bool = False
    file_up: str = "Y"

    @property
    def units(self) -> float:
        """Units a metre as a reader of the file sees them."""
        return self.units_per_metre * (self.object_scale if self.kind == "fbx" else 1)


def write_motion(clip: MadeClip, rig: Rig, path: Path) -> None:
    """Write a clip through Blender's exporters, in a Blender with an empty file open."""
    import bpy

    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.render.fps, scene.render.fps_base = round(clip.rate), 1.0
    scene.frame_start, scene.frame_end = 0, len(clip.heads) - 1
    rest_turns, rest_heads = posed(clip.rest, lowered_arms(rig.arms_down, 1), clip.rest[:1])
    armature = _armature(rig, rest_heads[0], rest_turns[0])
    if rig.empty_take:
        frames = 30
        _key(armature, rig, "Take 001", rest_heads, rest_turns[0], *(
            np.repeat(part, frames, axis=0) for part in (rest_turns, rest_heads)
        ))  # fmt: skip
    _key(armature, rig, "mixamo.com", rest_heads, rest_turns[0], clip.turns, clip.heads)
    if rig.kind == "bvh":
        bpy.ops.export_anim.bvh(
            filepath=str(path), frame_start=0, frame_end=scene.frame_end, root_transform_only=True
        )
        return
    armature.animation_data.action = None  # the exporter takes the rest of the bones from the pose
    for bone in armature.pose.bones:
        bone.matrix_basis.identity()
    bpy.context.view_layer.update()
    bpy.ops.export_scene.fbx(
        filepath=str(path),
        object_types={"ARMATURE"},
        axis_up=rig.file_up,
        axis_forward="-Z" if rig.file_up == "Y" else "Y",
        add_leaf_bones=False,
        bake_anim_use_nla_strips=False,
        bake_anim_use_all_actions=True,
        bake_anim_simplify_factor=0.0,
    )


def _armature(rig: Rig, heads: np.ndarray, turns: np.ndarray):
    """The rest pose as an armature: bones along their first child, rolled any way."""
    import bpy

    data = bpy.data.armatures.new("Armature")
    armature = bpy.data.objects.new("Armature", data)
    if rig.kind == "fbx":
        armature.rotation_mode = "QUATERNION"
        armature.rotation_quaternion = Rotation.from_matrix(rig.axes.T).as_quat(scalar_first=True)
        armature.scale = (rig.object_scale,) * 3
    bpy.context.scene.collection.objects.link(armature)
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    rolls = np.random.default_rng(0).uniform(-np.pi, np.pi, len(BONES))
    for bone, parent in enumerate(BONE_PARENTS):
        child = BONE_PARENTS.index(bone) if bone in BONE_PARENTS else None
        along = turns[bone] @ [0, 0, 0.05] if child is None else heads[child] - heads[bone]
        made = data.edit_bones.new(rig.names(BONES[bone]))
        made.head, made.tail = (
            rig.units_per_metre * rig.axes @ place for place in (heads[bone], heads[bone] + along)
        )
        made.roll = rolls[bone]
        if parent >= 0:
            made.parent = data.edit_bones[rig.names(BONES[parent])]
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def _key(armature, rig: Rig, take: str, rest_heads, rest_turns, turns, heads) -> None:
    """One action that turns the bones from the rest pose to `turns`, and moves the hips."""
    import bpy

    action = bpy.data.actions.new(take)
    armature.animation_data_create().action = action
    rolled = np.array([armature.data.bones[rig.names(bone)].matrix_local for bone in BONES])[:, :3, :3]
    world = rig.axes @ turns @ rest_turns.swapaxes(-1, -2) @ rig.axes.T @ rolled
    frames = np.arange(len(turns), dtype=float)
    for bone, parent in enumerate(BONE_PARENTS):
        basis = rolled[bone].T @ world[:, bone]
        if parent >= 0:
            basis = rolled[bone].T @ rolled[parent] @ world[:, parent].swapaxes(1, 2) @ world[:, bone]
        quaternions = Rotation.from_matrix(basis).as_quat(scalar_first=True)
        flips = np.sign(np.sum(quaternions[1:] * quaternions[:-1], axis=1, keepdims=True))
        quaternions[1:] *= np.cumprod(flips, axis=0)
        path = f'pose.bones["{rig.names(BONES[bone])}"].'
        _curves(action, armature, path + "rotation_quaternion", frames, quaternions)
        if parent < 0:
            moved = rig.units_per_metre * (heads[:, 0] - rest_heads[0, 0]) @ rig.axes.T @ rolled[0]
            _curves(action, armature, path + "location", frames, moved)


def _curves(action, armature, path: str, frames: np.ndarray, values: np.ndarray) -> None:
    for index, column in enumerate(values.T):
        if hasattr(action, "fcurve_ensure_for_datablock"):
            curve = action.fcurve_ensure_for_datablock(armature, path, index=index)
        else:  # Blender 4.3 has no slots yet
            curve = action.fcurves.new(path, index=index)
        curve.keyframe_points.add(len(frames))
        curve.keyframe_points.foreach_set("co", np.column_stack([frames, column]).ravel())
        curve.update()


TURNED = Y_UP @ Rotation.from_euler("z", 90, degrees=True).as_matrix()
METRES = {"units_per_metre": 1.0, "object_scale": 1.0}
STANDING = {"axes": np.eye(3)} | METRES
BVH = {"kind": "bvh", "axes": Y_UP}

FILES: dict[str, tuple[Rig, dict]] = {
    "walking/as Mixamo's.fbx": (Rig(), {"rate": 30, "travels": True}),
    "walking/another prefix, in place.fbx": (Rig(names=prefixed("mixamorig1:")), {"rate": 24}),
    "walking/no prefix, z up, metres.fbx": (
        Rig(names=prefixed(""), **STANDING), {"rate": 60, "travels": True}
    ),
    "walking/names of one's own.fbx": (Rig(names=german), {"rate": 120, "travels": True}),
    "walking/centimetres.bvh": (
        Rig(names=of_family("mocap_cmu"), **BVH), {"rate": 30, "travels": True}
    ),
    "walking/metres, in place.bvh": (
        Rig(names=prefixed(""), units_per_metre=1.0, **BVH), {"rate": 60}
    ),
    "waving/an empty take first.fbx": (Rig(empty_take=True), {"rate": 30}),
    "waving/arms down at rest.fbx": (Rig(arms_down=1.3), {"rate": 30}),
    "waving/armature turned.fbx": (Rig(axes=TURNED), {"rate": 24}),
    "waving/names that say nothing.fbx": (Rig(names=numbered), {"rate": 30}),
    "waving/3ds Max's names.bvh": (Rig(names=of_family("biped"), **BVH), {"rate": 120}),
    "waving/SMPL's names.bvh": (Rig(names=of_family("smpl"), units_per_metre=1.0, **BVH), {"rate": 24}),
    "squatting/a hundred times too large.fbx": (Rig(object_scale=1.0), {"rate": 30}),
    "squatting/a hundredth of the size.fbx": (
        Rig(units_per_metre=0.01, object_scale=1.0), {"rate": 30}
    ),
    "squatting/z up in the file.fbx": (Rig(file_up="Z"), {"rate": 60}),
    "squatting/Unreal's names, arms down, two takes.fbx": (
        Rig(names=of_family("unreal"), arms_down=0.8, empty_take=True, **STANDING), {"rate": 30}
    ),
    "squatting/inches, names that say nothing.bvh": (
        Rig(names=numbered, kind="bvh", units_per_metre=39.37), {"rate": 30}
    ),
    "squatting/Xsens's names.bvh": (Rig(names=of_family("xsens_bvh"), **BVH), {"rate": 60}),
}  # fmt: skip
"""File -> the rig in it, and what of its motion is not as the others' are."""


def make_clips() -> dict[str, MadeClip]:
    """What is in every file of `FILES`."""
    random = np.random.default_rng(11)
    clips = {}
    for number, (file, (_, asked)) in enumerate(FILES.items()):
        pace, size, stature = random.uniform((0.8, 0.85, 1.55), (1.2, 1.15, 1.9))
        settings = {"pace": pace, "size": size, "lag": number / 2, "stature": stature} | asked
        clips[file] = make_clip(file.split("/")[0], **settings)
    return clips


def write_files(folder: Path) -> None:
    """Write every file of `FILES`, and the bone map of the one whose names no bundled map knows."""
    for file, clip in make_clips().items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        write_motion(clip, FILES[file][0], folder / file)
    (folder / "werkstatt.json").write_text(json.dumps(german_map()), encoding="utf-8")
