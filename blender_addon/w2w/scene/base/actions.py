# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion as an action of a body's armature and back, and actions kept when a body gets another shape."""

from collections.abc import Iterable

import numpy as np
from scipy.spatial.transform import Rotation

from ...core.body.body import JOINT_NAMES, Body
from ...core.motion.examples import as_example
from ...core.motion.motion import LABELS, Motion
from ...core.rotations import continuous_quaternions, in_axes
from .body import armature_of, body_space, editing, matrix, read_values
from .fcurves import BONE_PATH, LINEAR, Curves, action_curves, basis_matrices, curves_by_owner, rescale
from .module import bpy

FIRST_FRAME = 1.0

CONSTANT = 1e-7
"""Channels that change less than float32 resolves are keyed once."""

STRAY = 1e-6
"""Tolerances (m, scale) within which a bone's translation and scale may be ignored."""

SPACING_TOLERANCE = 1e-3
"""Largest unevenness of the keys of a motion's frames, in frames."""

RATE = "rate"
"""Custom property of the actions written here: the motion's frames per second, each of them a key."""

KEYED_AT = "keyed at"
"""Custom property of an action: frames per second of the time its keys lie in, whatever the scene's is."""

CHANNELS = (
    *((JOINT_NAMES[0], "location", index) for index in range(3)),
    *((name, "rotation_quaternion", index) for name in JOINT_NAMES for index in range(4)),
)
"""Bone, property and index of every curve that a motion needs."""

OBJECT_CHANNELS = ("location", "rotation_euler", "rotation_quaternion", "rotation_axis_angle", "scale")


class InexpressibleActionError(ValueError):
    """An action that a `Motion` cannot express: it moves bones off their joints, or scales them."""


def write_action(armature: bpy.types.Object, motion: Motion, name: str = "") -> bpy.types.Action:
    """Write a motion as an action of an armature of `add_body`, called as the clip or activity by default.

    Every frame of the motion is a key at its own time, straight lines between, so that a motion at another
    rate than the scene's keeps its speed and all of its frames. The action is not made active (see
    `show_action`) and is kept when the file is saved.
    """
    action = bpy.data.actions.new(name or motion.clip or motion.activity or "motion")
    action.use_fake_user = True
    for label in LABELS:
        action[label] = getattr(motion, label)
    action[RATE], action[KEYED_AT] = motion.rate, scene_rate()
    times = FIRST_FRAME + np.arange(motion.n_frames) * (scene_rate() / motion.rate)
    values = _values(armature, motion)
    still = np.ptp(values, axis=1) < CONSTANT
    keys = np.empty((*values.shape, 2), dtype=np.float32)
    keys[..., 0], keys[..., 1] = times, values
    lines = np.full(motion.n_frames, LINEAR, dtype=np.uint8)  # bytes, as Blender has it, are written faster
    for curve, own, once in zip(_new_curves(action, armature), keys, still, strict=True):
        n_keys = 1 if once else motion.n_frames
        points = curve.keyframe_points
        points.add(n_keys)
        points.foreach_set("co", own[:n_keys].ravel())
        # handles, which straight lines do not use, would take more room in a file than the motion; Blender
        # works them out as soon as somebody edits the curve
        points.foreach_set("interpolation", lines[:n_keys])
    return action


def show_action(armature: bpy.types.Object, action: bpy.types.Action) -> None:
    """Make an action the one that the armature plays."""
    data = armature.animation_data or armature.animation_data_create()
    data.action = action
    if hasattr(data, "action_slot") and data.action_slot is None and len(action.slots):
        data.action_slot = action.slots[0]


def key_rate(action: bpy.types.Action | None) -> float:
    """Frames per second of the time of an action's keys; by default the scene's."""
    return scene_rate() if action is None else action.get(KEYED_AT, scene_rate())


def keep_pace(action: bpy.types.Action) -> None:
    """Move the keys of an action so that it plays at its speed at the scene's present frame rate."""
    ratio = scene_rate() / key_rate(action)
    if ratio == 1 or not action.is_editable:
        return
    for curves in action_curves(action):
        for curve in curves:
            rescale(curve, 0, ratio, FIRST_FRAME * (1 - ratio))
    action[KEYED_AT] = scene_rate()


def read_action(armature: bpy.types.Object, action: bpy.types.Action) -> Motion:
    """Read an action of a body's armature back as a motion; the armature's place in the world is left out.

    Where the keys are evenly spaced, as those of `write_action`, each is a frame. Of others each frame of the
    motion that was written is, or every whole frame where none was. Raises `InexpressibleActionError` if the
    action moves a bone other than the pelvis off its joint, or scales one, and `ValueError` if the action
    moves no bone of the armature.
    """
    curves = bone_curves(armature, action)
    if not curves:
        raise ValueError(f"the action '{action.name}' moves no bone of '{armature.name}'")
    frames, rate = frames_of(action, curves)
    bones = [armature.pose.bones[name] for name in JOINT_NAMES]
    basis = basis_matrices(bones, [curves.get(name, {}) for name in JOINT_NAMES], frames)
    turns, places = basis[..., :3, :3], basis[..., :3, 3]
    scaled = np.abs(np.linalg.norm(turns, axis=-2) - 1).max(axis=(0, 2)) > STRAY
    moved = np.abs(places).max(axis=(0, 2)) > STRAY
    moved[0] = False
    for joint in np.flatnonzero(scaled | moved)[:1]:
        named = f"the bone '{JOINT_NAMES[joint]}'"
        what = f"scales {named}" if scaled[joint] else f"moves {named} off its joint"
        raise InexpressibleActionError(f"the action '{action.name}' {what}")
    rests = np.array([matrix(bone.bone.matrix_local)[:3, :3] for bone in bones])
    rotations = rests @ turns @ np.linalg.inv(rests)
    head = matrix(bones[0].bone.head_local)
    pelvis = (head + places[:, 0] @ rests[0].T) @ body_space(armature)[:3, :3].T
    motion = Motion(rotations, pelvis, rate)
    return as_example(motion.labelled(*(str(action.get(label, "")) for label in LABELS)))


def frames_of(action: bpy.types.Action, curves: Curves) -> tuple[np.ndarray, float]:
    """The frames of an action (T,), in the time of its keys (`key_rate`), and their rate per second.

    They are not whole where the motion has another rate than the keys' time.
    """
    channels = [curve for bone in curves.values() for curve in bone.values() if len(curve.keyframe_points)]
    densest = max((curve.keyframe_points for curve in channels), key=len)
    keys = read_values(densest, "co", len(densest) * 2, np.float32)
    times = keys[::2].astype(np.float64)
    spacing = (times[-1] - times[0]) / max(len(times) - 1, 1)
    tolerance = SPACING_TOLERANCE + 2 * float(np.spacing(keys[-2]))  # late keys are rounded more
    even = len(times) > 1 and np.abs(np.diff(times) - spacing).max() < tolerance
    # wider keys that somebody set by hand are poses to go between, not the frames of a motion
    if even and (RATE in action or spacing < 1 - SPACING_TOLERANCE):
        unmoved = RATE in action and abs(key_rate(action) / action[RATE] - spacing) * len(times) < tolerance
        return times, action[RATE] if unmoved else key_rate(action) / spacing
    start = min(curve.keyframe_points[0].co[0] for curve in channels)
    stop = max(curve.keyframe_points[-1].co[0] for curve in channels)
    if RATE not in action:
        return np.arange(round(start), round(stop) + 1, dtype=np.float64), key_rate(action)
    step = key_rate(action) / action[RATE]
    return start + step * np.arange(int((stop - start) / step + SPACING_TOLERANCE) + 1), action[RATE]


def bone_curves(armature: bpy.types.Object, action: bpy.types.Action, slot: object | None = None) -> Curves:
    """F-curves of an action by bone name, then by property and index; muted ones are left out.

    Of an action with several slots those of `slot`, else of the one that fits best.
    """
    found = curves_by_owner(armature, slot_curves(armature, action, slot))
    found.pop("", None)
    return found


def scene_rate() -> float:
    """Frames per second of the open scene."""
    render = bpy.context.scene.render
    return render.fps / render.fps_base


def set_scene_rate(rate: float, scene: bpy.types.Scene | None = None) -> None:
    """Set a scene's frames per second, the open one's by default: a whole number and a divisor in Blender."""
    render = (scene or bpy.context.scene).render
    render.fps = max(1, round(rate))
    render.fps_base = render.fps / rate


def slot_curves(
    armature: bpy.types.Object, action: bpy.types.Action, slot: object | None = None
) -> list[bpy.types.FCurve]:
    """Curves of an action that this armature plays; of one it does not play, the slot for most bones."""
    data = armature.animation_data
    if slot is None and data is not None and data.action == action:
        slot = getattr(data, "action_slot", None)
    best = max(
        action_curves(action, slot),
        key=lambda curves: sum(curve.data_path.startswith(BONE_PATH) for curve in curves),
        default=[],
    )
    return [curve for curve in best if not (curve.mute or (curve.group and curve.group.mute))]


def _values(armature: bpy.types.Object, motion: Motion) -> np.ndarray:
    """Values of the `CHANNELS` in every frame of a motion, shape (C, T)."""
    bones = armature.data.bones
    columns = read_values(bones, "matrix_local", len(bones) * 16, np.float32).reshape(-1, 4, 4)
    joints = [bones.find(name) for name in JOINT_NAMES]
    shown = columns[joints, :3, :3].swapaxes(1, 2).astype(np.float64)
    rests = Rotation.from_matrix(shown).as_matrix()  # orthogonal in double precision, too
    quaternions = continuous_quaternions(in_axes(motion.rotations, rests))
    pelvis = motion.pelvis / np.diag(body_space(armature))[:3]
    offsets = (pelvis - matrix(bones[JOINT_NAMES[0]].head_local)) @ shown[0]
    return np.concatenate([offsets.T, quaternions.transpose(2, 0, 1).reshape(-1, motion.n_frames)])


def _new_curves(action: bpy.types.Action, armature: bpy.types.Object) -> list[bpy.types.FCurve]:
    """A new curve for each of the `CHANNELS`; curves moved into channelbags with Blender 4.4."""
    channels = [(f'{BONE_PATH}{bone}"].{prop}', index, bone) for bone, prop, index in CHANNELS]
    if not hasattr(action, "layers"):
        return [action.fcurves.new(path, index=index, action_group=bone) for path, index, bone in channels]
    slot = action.slots.new("OBJECT", armature.name)
    bag = action.layers.new("Layer").strips.new(type="KEYFRAME").channelbag(slot, ensure=True)
    groups = {bone: bag.groups.new(bone) for bone in JOINT_NAMES}
    curves = []
    for path, index, bone in channels:
        curves.append(bag.fcurves.new(path, index=index))
        curves[-1].group = groups[bone]
    return curves


def reshape_body(mesh: bpy.types.Object, body: Body, motions: Iterable[bpy.types.Action] = ()) -> None:
    """Give a body that `add_body` made the vertices and joints of another shape of it, soles on z = 0.

    Bones keep their directions, so that the rotations in actions mean the same motion as before. The pelvis's
    path in `motions` is scaled by its height over the floor, as longer legs take longer steps. Faces,
    weights, vertex groups, colours and whatever is parented to the surface stay. Raises `ValueError` if the
    mesh has other vertices than the body or shape keys, or its bones cannot be edited now.
    """
    _check(mesh, body)
    armature = armature_of(mesh)
    before = matrix(armature.data.bones[JOINT_NAMES[0]].head_local)
    mesh.data.vertices.foreach_set("co", body.vertices.astype(np.float32).ravel())
    mesh.data.update()
    with editing(armature) as bones:
        for joint, name in enumerate(JOINT_NAMES):
            bone = bones[name]
            along, roll = np.array(bone.tail) - np.array(bone.head), bone.roll
            bone.head, bone.tail = body.joints[joint], body.joints[joint] + along
            bone.roll = roll
    pelvis = armature.data.bones[JOINT_NAMES[0]]
    after = matrix(pelvis.head_local)
    scale = after[2] / before[2]
    # its curves hold the way from the rest position, in the bone's own axes
    shift = matrix(pelvis.matrix_local)[:3, :3].T @ (scale * before - after)
    for action in motions:
        for (prop, axis), curve in bone_curves(armature, action).get(JOINT_NAMES[0], {}).items():
            if prop == "location":
                rescale(curve, 1, scale, shift[axis])


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
