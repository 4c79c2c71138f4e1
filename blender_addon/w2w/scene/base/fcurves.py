# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of an action as numpy arrays, in every Blender from 4.3 on."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ...core.motion.source import MOST
from .body import read_values
from .module import bpy

OwnCurves = dict[tuple[str, int], bpy.types.FCurve]
"""F-curves of one object or bone by property and index."""

Curves = dict[str, OwnCurves]
"""F-curves of each bone by its name, and of the object itself under the empty name."""


SMALLEST = 1e-6
"""Bones are hidden by a scale of 0, which would leave no trace of how they turn."""

BONE_PATH = 'pose.bones["'

LINEAR = 1
"""Value of the enum ``Keyframe.interpolation`` as `foreach_get` gives it."""


class NotFiniteError(ValueError):
    """Curves hold NaN, infinite or physically impossible values."""


def action_curves(action: bpy.types.Action, slot: object | None = None) -> Iterator[list[bpy.types.FCurve]]:
    """The f-curves of an action, one list a slot, or of one slot alone.

    Blender 4.4 moved f-curves into layers, strips and channelbags, one a slot, and 5.0
    took `Action.fcurves` away; in 4.3 there is one list and no slots.
    """
    if not hasattr(action, "layers"):
        yield list(action.fcurves)
        return
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                if slot is None or bag.slot == slot:
                    # looked up by its slot: through the collection, curves take three times as long to read
                    yield list(strip.channelbag(bag.slot).fcurves)


def slot_named_for(item: bpy.types.Object, action: bpy.types.Action) -> object | None:
    """The slot of an action that has an object's name, or None; there are none before Blender 4.4."""
    named = f"OB{item.name}"
    return next((slot for slot in getattr(action, "slots", ()) if slot.identifier == named), None)


def curves_by_owner(armature: bpy.types.Object, curves: Iterable[bpy.types.FCurve]) -> Curves:
    """Curves of an armature by the name of their bone, those of the object itself under the empty name."""
    bone_names = [bone.name for bone in armature.data.bones]
    paths = {f'{BONE_PATH}{bpy.utils.escape_identifier(name)}"]': name for name in bone_names} | {"": ""}
    by_owner: Curves = {}
    for curve in curves:
        path, _, prop = curve.data_path.rpartition(".")
        if path in paths:
            by_owner.setdefault(paths[path], {})[prop, curve.array_index] = curve
    return by_owner


def sample(curve: bpy.types.FCurve, frames: np.ndarray) -> np.ndarray:
    """Values of an f-curve at some frames (T,); a NotFiniteError if a key is at none."""
    points = curve.keyframe_points
    if len(points) and not curve.modifiers:
        keys = read_values(points, "co", len(points) * 2, np.float32)
        if np.array_equal(keys[::2], frames):  # a key in every frame, as in most files
            return keys[1::2]
        if not np.isfinite(keys[::2]).all():
            raise NotFiniteError("a key's time is not finite")
        times, values = keys[::2].astype(np.float64), keys[1::2].astype(np.float64)
        within = times[0] <= frames[0] and frames[-1] <= times[-1]
        if curve.extrapolation == "CONSTANT" or within:
            at_keys = len(times) == len(frames) and np.abs(times - frames).max() < 1e-3
            if at_keys or (read_values(points, "interpolation", len(points), np.int32)[:-1] == LINEAR).all():
                return np.interp(frames, times, values)
    return np.array([curve.evaluate(frame) for frame in frames])


def rescale(curve: bpy.types.FCurve, axis: int, scale: float, shift: float) -> None:
    """Scale and shift the keys of a curve, handles with them: their times (axis 0) or their values (1)."""
    points = curve.keyframe_points
    places = np.empty((len(points), 2), dtype=np.float32)
    for field in ("co", "handle_left", "handle_right"):
        points.foreach_get(field, places.ravel())
        places[:, axis] = scale * places[:, axis].astype(np.float64) + shift
        points.foreach_set(field, places.ravel())
    curve.update()


def basis_matrices(
    owners: Sequence[bpy.types.PoseBone] | Sequence[bpy.types.Object],
    curves: Sequence[OwnCurves],
    frames: np.ndarray,
) -> np.ndarray:
    """Local matrices (T, B, 4, 4) of objects or pose bones in each frame, from their f-curves.

    The owners give the rotation mode and the value of every channel without a curve. A value that is NaN,
    infinite or beyond `MOST` raises a `NotFiniteError`.
    """
    matrices = np.zeros((len(frames), len(owners), 4, 4))
    matrices[..., 3, 3] = 1
    scale = _channels(owners, "scale", curves, frames)
    scale[np.abs(scale) < SMALLEST] = SMALLEST
    matrices[..., :3, :3] = _rotations(owners, curves, frames) * scale[..., None, :]
    matrices[..., :3, 3] = _channels(owners, "location", curves, frames)
    return matrices


def _rotations(owners: Sequence, curves: Sequence[OwnCurves], frames: np.ndarray) -> np.ndarray:
    """Rotation matrices (T, B, 3, 3): all owners of one mode at once, as there are few modes."""
    turns = np.empty((len(frames), len(owners), 3, 3))
    modes = [owner.rotation_mode for owner in owners]
    for mode in set(modes):
        chosen = [number for number, its_mode in enumerate(modes) if its_mode == mode]
        own, own_curves = [owners[number] for number in chosen], [curves[number] for number in chosen]
        matrices = _rotations_of_mode(mode, own, own_curves, frames)
        turns[:, chosen] = matrices.reshape(len(frames), len(chosen), 3, 3)
    return turns


def _rotations_of_mode(
    mode: str, owners: Sequence, curves: Sequence[OwnCurves], frames: np.ndarray
) -> np.ndarray:
    """Rotation matrices (T * B, 3, 3)."""
    if mode == "QUATERNION":
        quaternions = _channels(owners, "rotation_quaternion", curves, frames).reshape(-1, 4)
        # Blender reads a zero quaternion as no rotation
        quaternions[np.linalg.norm(quaternions, axis=1) < 1e-12] = (1, 0, 0, 0)
        return Rotation.from_quat(quaternions, scalar_first=True).as_matrix()
    if mode == "AXIS_ANGLE":
        values = _channels(owners, "rotation_axis_angle", curves, frames).reshape(-1, 4)
        axis = values[:, 1:] / np.maximum(np.linalg.norm(values[:, 1:], axis=1, keepdims=True), 1e-12)
        return Rotation.from_rotvec(axis * values[:, :1]).as_matrix()
    angles = _channels(owners, "rotation_euler", curves, frames).reshape(-1, 3)
    # Blender's XYZ turns about x first, in fixed axes: scipy writes fixed axes in lower case.
    order = ["XYZ".index(letter) for letter in mode]
    return Rotation.from_euler(mode.lower(), angles[:, order]).as_matrix()


def _channels(owners: Sequence, name: str, curves: Sequence[OwnCurves], frames: np.ndarray) -> np.ndarray:
    """Values of one property, shape (T, B, size)."""
    resting = np.array([getattr(owner, name) for owner in owners], dtype=np.float64)
    values = np.tile(resting, (len(frames), 1, 1))
    for number, own in enumerate(curves):
        for index in range(resting.shape[1]):
            curve = own.get((name, index))
            if curve is not None:
                values[:, number, index] = sample(curve, frames)
    if not (np.abs(values) < MOST).all():
        raise NotFiniteError(f"{name} is not finite")
    return values
