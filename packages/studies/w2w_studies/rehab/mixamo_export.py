# SPDX-License-Identifier: GPL-3.0-or-later
"""Write a generated clip as an FBX file laid out as Mixamo's downloads are."""

import contextlib
import datetime
import io
import zlib
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.scene.base.actions import set_scene_rate
from w2w.scene.base.module import bpy

from .clips import RehabClip
from .skeleton import BONE_PARENTS, BONES, PREFIX

TAKE = "mixamo.com"
"""Name of the animation in every file that Mixamo hands out."""

_ARMATURE = "Armature"

_TO_ARMATURE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
"""World axes (z up, facing -y) to Mixamo's (y up, facing z)."""

_CENTIMETRES = 100.0
_T_POSE_FRAME = -1
_SHORTEST_BONE = 0.02
"""Metres; Blender drops bones without length."""


def write_mixamo_fbx(clip: RehabClip, path: str | Path) -> None:
    """Write one clip through Blender's own FBX exporter.

    The file holds an armature in centimetres with y up and Mixamo's bone names in T-pose,
    and one take, ``mixamo.com``, with every bone keyed in every frame, as Mixamo's do.
    Blender stamps the time of day and process-dependent identifiers on its files; both are
    pinned here, so that the same clip gives the same bytes. The open scene is left as it is.

    `path`: where the file shall stand; its folder must exist. Written whole or not at all.
    Raises FileNotFoundError if the folder does not exist.
    Raises RuntimeError if Blender's FBX exporter is not there or fails.
    """
    path = Path(path)
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder {path.parent} does not exist: create it first")
    if "fbx" not in dir(bpy.ops.export_scene):
        raise RuntimeError("Blender's FBX exporter is off: switch on the add-on 'FBX format' (io_scene_fbx)")
    partial = path.with_name(f".{path.name}.part")
    try:
        with _names_free(), _scene(clip.rate, clip.n_frames) as scene:
            armature = _build_armature(scene, clip.figure.rest())
            _key(armature, clip)
            _export(scene, partial)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def rest_axes(rest: np.ndarray) -> np.ndarray:
    """Axes of every bone in the T-pose: y along the bone, z forward (upward in feet and toes).

    `rest` (27, 3): joints in the T-pose, metres, z up, facing -y.
    Returns (27, 3, 3): columns are the bone's x, y and z in world axes.
    """
    along = _tails(rest) - rest
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    flat = np.array([name.endswith(("Foot", "ToeBase", "Toe_End")) for name in BONES])
    toward = np.where(flat[:, None], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0])
    z = toward - np.sum(toward * along, axis=1, keepdims=True) * along
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return np.stack([np.cross(along, z), along, z], axis=-1)


def _tails(rest: np.ndarray) -> np.ndarray:
    """Where each bone ends: at its first child, or a little way on in its parent's direction."""
    tails = np.empty_like(rest)
    for bone, parent in enumerate(BONE_PARENTS):
        children = [child for child, its_parent in enumerate(BONE_PARENTS) if its_parent == bone]
        if children:
            tails[bone] = rest[children[0]]
        else:
            step = rest[bone] - rest[parent]
            tails[bone] = rest[bone] + step * max(0.4, _SHORTEST_BONE / np.linalg.norm(step))
    return tails


@contextlib.contextmanager
def _names_free() -> Iterator[None]:
    """Lend the names that are written to the file: a block of the same name would make ours end in .001."""
    taken = [
        (block, name)
        for blocks, name in ((bpy.data.objects, _ARMATURE), (bpy.data.scenes, TAKE))
        for block in blocks
        if block.name == name and not block.library
    ]
    for block, name in taken:
        block.name = f"{name} of the open file"
    try:
        yield
    finally:
        for block, name in taken:
            block.name = name


@contextlib.contextmanager
def _scene(rate: float, n_frames: int) -> Iterator[bpy.types.Scene]:
    """A scene of its own, taken away afterwards with all that was put into it."""
    kept = {kind: set(getattr(bpy.data, kind)) for kind in ("objects", "armatures", "actions")}
    # the exporter names the take after the scene
    scene = bpy.data.scenes.new(TAKE)
    set_scene_rate(rate, scene)
    scene.frame_start, scene.frame_end = 0, n_frames - 1
    window = bpy.context.window
    before_scene = window.scene
    try:
        # edit mode follows the window's scene and cannot be left under an overridden one
        window.scene = scene
        yield scene
    finally:
        window.scene = before_scene
        for kind, before in kept.items():
            blocks = getattr(bpy.data, kind)
            for block in set(blocks) - before:
                blocks.remove(block)
        bpy.data.scenes.remove(scene)


def _build_armature(scene: bpy.types.Scene, rest: np.ndarray) -> bpy.types.Object:
    data = bpy.data.armatures.new(_ARMATURE)
    armature = bpy.data.objects.new(_ARMATURE, data)
    armature.rotation_euler = (np.pi / 2, 0.0, 0.0)
    armature.scale = (1 / _CENTIMETRES,) * 3
    scene.collection.objects.link(armature)
    heads, tails = (_CENTIMETRES * points @ _TO_ARMATURE.T for points in (rest, _tails(rest)))
    rolls = _TO_ARMATURE @ rest_axes(rest)[:, :, 2, None]
    bpy.context.view_layer.objects.active = armature
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, parent in enumerate(BONE_PARENTS):
        edit_bone = data.edit_bones.new(PREFIX + BONES[bone])
        edit_bone.head, edit_bone.tail = heads[bone], tails[bone]
        edit_bone.align_roll(rolls[bone, :, 0])
        if parent >= 0:
            edit_bone.parent = data.edit_bones[PREFIX + BONES[parent]]
    bpy.ops.object.mode_set(mode="OBJECT")
    return armature


def _key(armature: bpy.types.Object, clip: RehabClip) -> None:
    """Key the rotation of every bone, and the place of the hips, in every frame.

    The frame before the first is the T-pose: without a mesh, Blender's exporter has no other
    place to take a bone's rest from than the frame that is current while it writes.
    """
    rest = clip.figure.rest()
    axes = rest_axes(rest)
    t_pose = np.broadcast_to(np.eye(3), (1, len(BONES), 3, 3))
    turns = axes.transpose(0, 2, 1) @ np.concatenate([t_pose, clip.rotations]) @ axes
    action = bpy.data.actions.new(TAKE)
    armature.animation_data_create().action = action
    frames = np.arange(_T_POSE_FRAME, clip.n_frames, dtype=float)
    for bone, name in enumerate(BONES):
        path = f'pose.bones["{PREFIX}{name}"].'
        # curves are read at their keys only, so the signs of neighbouring quaternions need not agree
        quaternions = Rotation.from_matrix(turns[:, bone]).as_quat(scalar_first=True)
        _write_curves(action, armature, path + "rotation_quaternion", frames, quaternions)
    moved = np.vstack([np.zeros(3), _CENTIMETRES * (clip.hips - rest[0]) @ axes[0]])
    _write_curves(action, armature, f'pose.bones["{PREFIX}Hips"].location', frames, moved)


def _write_curves(
    action: bpy.types.Action, armature: bpy.types.Object, path: str, frames: np.ndarray, values: np.ndarray
) -> None:
    for index, column in enumerate(values.T):
        if hasattr(action, "fcurve_ensure_for_datablock"):
            curve = action.fcurve_ensure_for_datablock(armature, path, index=index)
        else:  # Blender 4.3 has no slots yet
            curve = action.fcurves.new(path, index=index)
        curve.keyframe_points.add(len(frames))
        curve.keyframe_points.foreach_set("co", np.column_stack([frames, column]).ravel())
        curve.update()


def _export(scene: bpy.types.Scene, path: Path) -> None:
    scene.frame_set(_T_POSE_FRAME)
    said = io.StringIO()
    with _reproducible(), contextlib.redirect_stdout(said):
        result = bpy.ops.export_scene.fbx(
            filepath=str(path),
            check_existing=False,
            object_types={"ARMATURE"},
            axis_forward="-Z",
            axis_up="Y",
            add_leaf_bones=False,
            bake_anim_use_all_bones=True,
            bake_anim_use_nla_strips=False,
            bake_anim_use_all_actions=False,
            bake_anim_simplify_factor=0.0,
        )
    if result != {"FINISHED"}:
        raise RuntimeError(f"Blender could not export {path.name}: {said.getvalue().strip()}")


class _Epoch(datetime.datetime):
    """A clock that stands still."""

    @classmethod
    def now(cls, tz: datetime.tzinfo | None = None) -> datetime.datetime:
        return cls(1970, 1, 1, 10, tzinfo=tz)


@contextlib.contextmanager
def _reproducible() -> Iterator[None]:
    """Pin what Blender's exporter takes from the clock and from Python's randomised `hash`."""
    from io_scene_fbx import export_fbx_bin, fbx_utils

    fbx_utils._keys_to_uuids.clear()
    fbx_utils._uuids_to_keys.clear()
    with (
        mock.patch.object(export_fbx_bin.datetime, "datetime", _Epoch),
        mock.patch.object(fbx_utils, "hash", _stable_hash, create=True),
    ):
        yield


def _stable_hash(key: object) -> int:
    return zlib.crc32(repr(key).encode())
