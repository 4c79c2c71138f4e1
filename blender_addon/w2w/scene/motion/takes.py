# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion files in, through Blender's own importers: a named skeleton and its frames as arrays."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np

from ...core.motion.sight import Up
from ...core.motion.source import (
    LOWEST_RATE,
    NOT_FINITE,
    SourceMotion,
    UnusableMotion,
    is_pose,
    motion_amount,
    people_in,
    refuse_pose,
    refuse_too_long,
    usable_rate,
)
from ...core.readers.animations import MIXAMO
from ...core.readers.bvh import BVH_SUFFIX
from ...core.readers.bvh_text import read_bvh_text
from ...core.readers.import_checks import PLAIN_GLTF, USD_SUFFIXES, check_gltf
from ...core.reading.formats import GLTF_SUFFIXES, unknown
from ...core.retargeting.bone_maps import best_match, missing_joints
from ...core.retargeting.repair import rests_straight
from ...core.retargeting.retarget import is_crumpled
from ...core.wording import restated
from ..base.actions import key_rate
from ..base.body import same_selection
from ..base.fcurves import (
    Curves,
    NotFiniteError,
    action_curves,
    basis_matrices,
    curves_by_owner,
    slot_named_for,
)
from ..base.module import bpy
from ..base.playback import same_timing
from .importers import (
    are_scaled,
    bind_sizes,
    check_fbx,
    fbx_up,
    import_fault,
    import_gltf,
    import_usd,
    mend_places,
    node_sizes,
)

LONG_NAME = 58
"""Bytes of an action's name from which on Blender may have cut it off."""


@dataclass(frozen=True)
class Take:
    """One armature under one action."""

    armature: bpy.types.Object
    action: bpy.types.Action
    curves: Curves

    @property
    def frame_range(self) -> tuple[int, int]:
        """First and last whole frame that the bones' curves cover; a NotFiniteError if there is none."""
        curves = (curve for channels in self.curves.values() for curve in channels.values())
        keys = [curve.keyframe_points for curve in curves if len(curve.keyframe_points)]
        ends = np.array([(own[0].co[0], own[-1].co[0]) for own in keys]).reshape(-1, 2)
        if not np.isfinite(ends).all():
            raise NotFiniteError(NOT_FINITE)
        return round(ends[:, 0].min()), round(ends[:, 1].max())


def read_clip(path: str | Path, rate: float | None = None, animation: str = "") -> SourceMotion:
    """Import an FBX, glTF, VRM or USD file, read the take that moves, and remove all that came.

    `animation` is the name of the one to read, if the file has several. `rate` goes before the file's own
    frames per second; a glTF file's frames are its keys then. Raises `UnusableMotion` if the file holds no
    motion that can be used.
    """
    path = Path(path)
    before = {action.session_uid for action in bpy.data.actions}
    with imported(path, rate is not None, animation) as objects:
        # actions that were there before may fit the file's armature too: other clips of the same rig
        actions = [item for item in bpy.data.actions if item.session_uid not in before]
        if animation and path.suffix.lower() == ".fbx":  # of others no more was imported
            actions = [item for item in actions if _is_of(item.name, animation)]
        source = best_take(objects, actions)
    if path.suffix.lower() in PLAIN_GLTF and not check_gltf(path).skin:  # its nodes may rest in any pose
        source = replace(source, rest_is_known=rests_straight(source))
    return replace(source, rate=usable_rate(source.rate, rate))


def _is_of(action: str, animation: str) -> bool:
    """Whether an action is of an FBX file's animation: importers put names before and after its own."""
    plain = re.sub(r"\.\d{3}$", "", action)
    cut_off = len(action.encode()) > LONG_NAME and animation.startswith(plain)
    return cut_off or any(f"|{animation}|" in f"|{name}|" for name in (action, plain))


@contextmanager
def imported(
    path: Path, keys_as_frames: bool = False, animation: str = ""
) -> Iterator[list[bpy.types.Object]]:
    """The objects that a motion file brings, removed again at the end; the selection is restored."""
    before = existing_data()
    with same_selection():
        try:
            with same_timing():
                import_file(path, keys_as_frames, animation)
                yield [item for item in new_data(before) if isinstance(item, bpy.types.Object)]
        finally:
            bpy.data.batch_remove(new_data(before))


def import_file(path: Path, keys_as_frames: bool = False, animation: str = "") -> None:
    """Import an FBX, BVH, glTF, VRM or USD file with Blender's importer into the open scene.

    `keys_as_frames` puts the keys of a glTF file on whole frames; of its animations one is imported if it is
    named. Raises `UnusableMotion` if the file
    is of another kind, damaged, or Blender refuses it.
    """
    kind = path.suffix.lower()
    if kind not in IMPORTERS:
        raise unknown(path)
    try:
        if kind in GLTF_SUFFIXES:
            import_gltf(path, keys_as_frames, animation)
        else:
            IMPORTERS[kind](path)
    except UnusableMotion:
        raise
    except Exception as error:  # Blender's importers raise anything: KeyError, struct.error, RuntimeError
        raise UnusableMotion(import_fault(path, error)) from error


def best_take(
    objects: list[bpy.types.Object], actions: Sequence[bpy.types.Action] | None = None
) -> SourceMotion:
    """Read the take that moves most, the one Mixamo names before any other, among all actions or some.

    Of several people in a file, each an armature, the one that moves most is read. Raises `UnusableMotion` if
    there is no armature, no animation of it, or none that moves.
    """
    armatures = [item for item in objects if item.type == "ARMATURE"]
    if not armatures:
        kinds = sorted({item.type.lower() for item in objects})
        raise UnusableMotion(f"it holds no armature, only: {', '.join(kinds) or 'nothing'}")
    # joint -> bone by name, the armature itself being bone 0
    matched = {
        item: best_match([item.name, *(bone.name for bone in item.data.bones)])[1] for item in armatures
    }
    missing = {item: len(missing_joints(joints)) for item, joints in matched.items()}
    people = [item for item in armatures if missing[item] == min(missing.values())]
    people = [item for item in people if not _rests_crumpled(item, matched[item])] or people
    actions = bpy.data.actions if actions is None else actions
    takes = [take for armature in people for take in find_takes(armature, actions)]
    if not takes:
        which = " that moves a third of them, or of a body's" if actions else ""
        raise UnusableMotion(
            f"its armature '{people[0].name}' ({len(people[0].data.bones)} bones) has no animation{which}"
        )
    motion = _most_moving(takes)
    return replace(motion, people=max(len(people), people_in(motion.parents[1:] - 1)))


def find_takes(armature: bpy.types.Object, actions: Iterable[bpy.types.Action]) -> list[Take]:
    """The actions that animate a third of an armature's bones, or of those that play a body's joints."""
    names = [bone.name for bone in armature.data.bones]
    matched = best_match(names)[1]
    body = set() if missing_joints(matched) else {names[bone] for bone in matched.values()}
    takes = []
    for action in actions:
        for curves in action_curves(action):
            by_owner = curves_by_owner(armature, curves)
            moved = by_owner.keys() - {""}
            if any(0 < len(bones) <= 3 * len(moved & bones) for bones in (set(names), body)):
                takes.append(Take(armature, action, by_owner))
    return takes


def read_take(take: Take, frames: np.ndarray | None = None, unkeyed: Sequence | None = None) -> SourceMotion:
    """World matrices of the bones, frame by frame, from the f-curves alone.

    The armature object comes first, as a bone of its own: some rigs animate the object
    instead of a hip bone. Read are `frames` (T,), or every whole frame of the take; a bone without
    a curve has the channels of its counterpart in `unkeyed`, or of its pose bone as it is.
    """
    if frames is None:
        start, stop = take.frame_range
        refuse_too_long(stop - start + 1, len(take.armature.data.bones))
        frames = np.arange(start, stop + 1, dtype=np.float64)
    armature = take.armature
    names, parents, rest_local = skeleton_of(armature)
    matrices = np.empty((len(frames), len(names), 4, 4))
    matrices[:, 0] = world = _object_matrices(armature, take, frames)
    basis = basis_matrices(
        unkeyed or [armature.pose.bones[name] for name in names[1:]],
        [take.curves.get(name, {}) for name in names[1:]],
        frames,
    )
    local = np.linalg.solve(rest_local[parents[1:]], rest_local[1:]) @ basis
    for number in range(1, len(parents)):
        np.matmul(matrices[:, parents[number]], local[:, number - 1], out=matrices[:, number])
    rest, rate = world[0] @ rest_local, key_rate(take.action)
    return SourceMotion(names, parents, rest, matrices, rate, take.action.name, first_bone=1)


def written_up(path: Path) -> Up:
    """The file's axis that Blender stands up: of glTF y, of FBX the one that its header names, of USD z."""
    if path.suffix.lower() != ".fbx":
        return "y" if path.suffix.lower() in GLTF_SUFFIXES else "z"
    return fbx_up(path)


def _import_fbx(path: Path) -> None:
    """Blender's C++ importer (4.5 and later), or the Python one it had before."""
    check_fbx(path, python_importer=not _has_cpp_importer())
    if not _has_cpp_importer():
        bpy.ops.import_scene.fbx(filepath=str(path), use_custom_normals=False, use_image_search=False)
        return
    before = existing_data()
    bpy.ops.wm.fbx_import(filepath=str(path), use_custom_normals=False)
    brought, sizes = new_data(before), node_sizes(path)
    if are_scaled(brought, sizes):
        before = existing_data()
        try:
            bpy.ops.wm.fbx_import(filepath=str(path), use_custom_normals=False, use_anim=False)
            mend_places(brought, bind_sizes(new_data(before), sizes))
        finally:
            bpy.data.batch_remove(new_data(before))


def _import_bvh(path: Path) -> None:
    """Blender's importer, for the armature alone: it takes fewer files than W2W's reader of motions."""
    read_bvh_text(path, LOWEST_RATE)  # its own does not matter
    unshown = (
        "its armature cannot be shown: Blender's own importer does not read this BVH file, though W2W reads "
        "its motion"
    )
    with restated(unshown, Exception, UnusableMotion):  # it raises anything, and none of it is for people
        bpy.ops.import_anim.bvh(filepath=str(path), update_scene_fps=True, use_fps_scale=False)


@cache  # Blender lists some hundred operators to answer
def _has_cpp_importer() -> bool:
    return "fbx_import" in dir(bpy.ops.wm)


IMPORTERS = {
    ".fbx": _import_fbx,
    BVH_SUFFIX: _import_bvh,
    **dict.fromkeys(GLTF_SUFFIXES, import_gltf),
    **dict.fromkeys(USD_SUFFIXES, import_usd),
}


def _most_moving(takes: list[Take]) -> SourceMotion:
    motions = []
    for take in takes:
        with suppress(NotFiniteError):
            motions.append(read_take(take))
    motions = [motion for motion in motions if np.isfinite(motion.matrices).all()]
    if not motions:
        raise UnusableMotion(NOT_FINITE)
    moving = [motion for motion in motions if not is_pose(motion)]
    if not moving:
        refuse_pose(max(motions, key=lambda motion: motion.n_frames))
    preferred = [motion for motion in moving if MIXAMO in motion.take]
    best = max(preferred or moving, key=motion_amount)
    return replace(best, other_takes=tuple(sorted({motion.take for motion in moving} - {best.take})))


def _rests_crumpled(armature: bpy.types.Object, matched: dict[int, int]) -> bool:
    """Whether an armature's rest pose is no body's, as that of a broken copy may be."""
    heads = [np.zeros(3), *(np.array(bone.head_local) for bone in armature.data.bones)]
    return is_crumpled({joint: heads[bone] for joint, bone in matched.items()})


def skeleton_of(armature: bpy.types.Object) -> tuple[tuple[str, ...], np.ndarray, np.ndarray]:
    """Names of the bones, their parents and their rest matrices in the armature's space; it comes first."""
    bones = list(armature.data.bones)  # depth-first, as Blender keeps them: a parent before its children
    index = {bone.name: number for number, bone in enumerate(bones, start=1)}
    parents = np.array([-1] + [index[bone.parent.name] if bone.parent else 0 for bone in bones])
    rest = np.array([np.eye(4)] + [np.array(bone.matrix_local) for bone in bones])
    return (armature.name, *index), parents, rest


def _object_matrices(item: bpy.types.Object, take: Take, frames: np.ndarray) -> np.ndarray:
    """World matrix of an object in each frame, its animated parents included."""
    curves = take.curves.get("", {})
    if item is not take.armature:
        slot = slot_named_for(item, take.action)
        found = [] if slot is None else next(action_curves(take.action, slot), [])
        curves = {(c.data_path, c.array_index): c for c in found}
    local = basis_matrices([item], [curves], frames)[:, 0]
    if item.parent is None:
        return local
    return _object_matrices(item.parent, take, frames) @ np.array(item.matrix_parent_inverse) @ local


def existing_data() -> set[int]:
    """Identifiers of all data in the file, to recognise what comes later."""
    return {item.session_uid for item in _all_data()}


def new_data(before: set[int]) -> list[bpy.types.ID]:
    """The data that came into the file since `existing_data`."""
    return [item for item in _all_data() if item.session_uid not in before]


def _all_data() -> Iterator[bpy.types.ID]:
    data = bpy.data
    for collection in (
        data.objects, data.armatures, data.actions, data.meshes, data.materials, data.images,
        data.textures, data.cameras, data.lights, data.collections, data.shape_keys, data.curves,
    ):  # fmt: skip
        yield from collection
