# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of an action as numpy arrays, in every Blender from 4.3 on."""

from __future__ import annotations

from collections.abc import Iterator

import bpy
import numpy as np
from scipy.spatial.transform import Rotation

LINEAR = 1
"""Value of the enum ``Keyframe.interpolation`` as `foreach_get` gives it."""


def action_curves(action: bpy.types.Action) -> Iterator[list[bpy.types.FCurve]]:
    """The f-curves of an action, one list a slot.

    Blender 4.4 moved f-curves into layers, strips and channelbags, one a slot, and 5.0
    took `Action.fcurves` away; in 4.3 there is one list and no slots.
    """
    if not hasattr(action, "layers"):
        yield list(action.fcurves)
        return
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield list(bag.fcurves)


def sample(curve: bpy.types.FCurve, frames: np.ndarray) -> np.ndarray:
    """Values of an f-curve at some frames.

    Parameters
    ----------
    curve : FCurve
    frames : ndarray, shape (T,)

    Returns
    -------
    ndarray, shape (T,), float64
    """
    points = curve.keyframe_points
    if len(points) == 0 or curve.modifiers:
        return np.array([curve.evaluate(frame) for frame in frames])
    keys = np.empty(len(points) * 2, dtype=np.float32)
    points.foreach_get("co", keys)
    times, values = keys[::2].astype(np.float64), keys[1::2].astype(np.float64)
    if _is_straight(curve, times, frames):
        return np.interp(frames, times, values)
    return np.array([curve.evaluate(frame) for frame in frames])


def _is_straight(curve: bpy.types.FCurve, times: np.ndarray, frames: np.ndarray) -> bool:
    """Whether straight lines between keys give this curve's values at these frames."""
    if curve.extrapolation != "CONSTANT" and (frames[0] < times[0] or frames[-1] > times[-1]):
        return False
    if len(times) == len(frames) and np.abs(times - frames).max() < 1e-3:
        return True
    kinds = np.empty(len(times), dtype=np.int32)
    curve.keyframe_points.foreach_get("interpolation", kinds)
    return bool((kinds[:-1] == LINEAR).all())


def basis_matrices(
    owner: bpy.types.PoseBone | bpy.types.Object,
    curves: dict[tuple[str, int], bpy.types.FCurve],
    frames: np.ndarray,
) -> np.ndarray:
    """Local matrix of an object or pose bone in each frame, from its f-curves.

    Parameters
    ----------
    owner : PoseBone or Object
        Gives the rotation mode and the value of every channel without a curve.
    curves : dict of (property, index) to FCurve
        Curves of `location`, `rotation_*` and `scale`.
    frames : ndarray, shape (T,)

    Returns
    -------
    ndarray, shape (T, 4, 4)
    """
    matrices = np.zeros((len(frames), 4, 4))
    matrices[:, 3, 3] = 1
    scale = _channels(owner, "scale", curves, frames)
    matrices[:, :3, :3] = _rotations(owner, curves, frames) * scale[:, None, :]
    matrices[:, :3, 3] = _channels(owner, "location", curves, frames)
    return matrices


def _rotations(owner: bpy.types.PoseBone | bpy.types.Object, curves: dict, frames: np.ndarray) -> np.ndarray:
    mode = owner.rotation_mode
    if mode == "QUATERNION":
        quaternions = _channels(owner, "rotation_quaternion", curves, frames)
        return Rotation.from_quat(_non_zero(quaternions), scalar_first=True).as_matrix()
    if mode == "AXIS_ANGLE":
        values = _channels(owner, "rotation_axis_angle", curves, frames)
        axis = values[:, 1:] / np.maximum(np.linalg.norm(values[:, 1:], axis=1, keepdims=True), 1e-12)
        return Rotation.from_rotvec(axis * values[:, :1]).as_matrix()
    angles = _channels(owner, "rotation_euler", curves, frames)
    # Blender's XYZ turns about x first, in fixed axes: scipy writes fixed axes in lower case.
    order = ["XYZ".index(letter) for letter in mode]
    return Rotation.from_euler(mode.lower(), angles[:, order]).as_matrix()


def _channels(
    owner: bpy.types.PoseBone | bpy.types.Object, name: str, curves: dict, frames: np.ndarray
) -> np.ndarray:
    resting = np.array(getattr(owner, name), dtype=np.float64)
    values = np.tile(resting, (len(frames), 1))
    for index in range(len(resting)):
        curve = curves.get((name, index))
        if curve is not None:
            values[:, index] = sample(curve, frames)
    return values


def _non_zero(quaternions: np.ndarray) -> np.ndarray:
    """Blender reads a zero quaternion as no rotation."""
    zero = np.linalg.norm(quaternions, axis=1) < 1e-12
    if zero.any():
        quaternions = quaternions.copy()
        quaternions[zero] = (1, 0, 0, 0)
    return quaternions
