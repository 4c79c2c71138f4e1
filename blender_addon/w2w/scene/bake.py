# SPDX-License-Identifier: GPL-3.0-or-later
"""World matrices of patches from what is in the scene: fast from f-curves, or as Blender evaluates it."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import closing
from dataclasses import dataclass, replace
from typing import Literal

import bpy
import numpy as np

from ..core.body.body import Body
from ..core.garments.on_cloth import ClothSensors
from ..core.motion.motion import Motion
from ..core.motion.skinning import patch_matrices, triangle_frames
from ..core.patches.patches import PatchSet
from . import actions
from .body import armature_of, body_of, body_space, matrix
from .evaluated import EvaluatedVertices
from .fast_path import why_not_fast
from .playback import active_action, at_rate, each_frame, playing, without_empties
from .steps import without_pauses

EVEN_SCALE = 1e-4
"""How far the three scales of an object may differ and still count as one."""


@dataclass(frozen=True, eq=False)
class Bake:
    """Where every patch was in every frame.

    Parameters
    ----------
    matrices : ndarray, shape (T, N, 4, 4), float64
        World matrices of the patches' frames, metres, without scale.
    rate : float
        Frames per second.
    path : {"fast", "general"}
        From f-curves, or from Blender's evaluated mesh.
    reason : str
        Why that path, as a sentence for the person who waits.
    motion : Motion or None
        What the action does in the armature's space; None where no `Motion` can tell it.
    root : ndarray, shape (T, 3), or None
        Path of the root in the world; None on the general path, where more than the bones may move it.
    on_cloth : ClothSensors or None
        The sensors that sit on garments; in `matrices` they are on the skin.
    """

    matrices: np.ndarray
    rate: float
    path: Literal["fast", "general"]
    reason: str
    motion: Motion | None
    root: np.ndarray | None = None
    on_cloth: ClothSensors | None = None


class PatchBaker:
    """Bakes the patches of one body, action by action.

    Parameters
    ----------
    mesh : Object
        The body's mesh.
    patches : PatchSet

    Raises
    ------
    ValueError
        If the mesh is no body, is scaled unevenly or mirrored, or the patches are not its own.
    """

    def __init__(self, mesh: bpy.types.Object, patches: PatchSet) -> None:
        self.mesh = mesh
        self.patches = patches
        self.armature = armature_of(mesh)
        _check(mesh, patches)
        self._body: Body | None = None

    def bake(self, action: bpy.types.Action | None = None, path: Literal["auto", "general"] = "auto") -> Bake:
        """World matrices of the patches while the armature plays an action.

        Parameters
        ----------
        action : Action, optional
            The armature's active action by default; without one, whatever moves the body
            between the scene's first and last frame.
        path : {"auto", "general"}
            "auto" reads the f-curves wherever they alone decide where the patches are.
        """
        return without_pauses(self.by_frame(action, path))

    def by_frame(
        self, action: bpy.types.Action | None = None, path: Literal["auto", "general"] = "auto"
    ) -> Generator[float, None, Bake]:
        """Bake as `bake` does, with a pause after each frame of the general path, which takes time.

        Between the pauses the scene is on another frame; at the end, or when the generator is
        closed early, it is as it was.

        Yields
        ------
        float
            Share of the frames done.
        """
        action = action or active_action(self.armature)
        motion, not_told = _motion_of(self.armature, action)
        reason = "asked for"
        if path == "auto":
            reason = why_not_fast(self.mesh, self.armature, action) or not_told
        if motion is not None and not reason:
            return self._fast(motion)
        frames, rate = _frames_to_bake(self.armature, action)
        with at_rate(actions.key_rate(action)), playing(self.armature, action), without_empties(self.mesh):
            matrices = yield from _evaluated_matrices(self.mesh, self.patches.triangles, frames)
        return Bake(matrices, rate, "general", reason, motion)

    def _fast(self, motion: Motion) -> Bake:
        if self._body is None:
            self._body = body_of(self.mesh)
        stood = placed(motion, self.armature)
        matrices = patch_matrices(self._body, self.patches.triangles, stood)
        reason = "the armature's f-curves alone move the body"
        return Bake(matrices, motion.rate, "fast", reason, motion, stood.pelvis)


def _check(mesh: bpy.types.Object, patches: PatchSet) -> None:
    if len(patches.labels) != len(mesh.data.vertices):
        raise ValueError(
            f"the patches are not of this body: they cover {len(patches.labels)} vertices, "
            f"but '{mesh.name}' has {len(mesh.data.vertices)}"
        )
    axes = matrix(mesh.matrix_world)[:3, :3]
    scales = np.linalg.norm(axes, axis=0)
    if np.ptp(scales) > EVEN_SCALE * scales.max() or np.linalg.det(axes) <= 0:
        raise ValueError(
            f"'{mesh.name}' is scaled unevenly or mirrored: apply its scale (Object > Apply > Scale) first"
        )


def _motion_of(armature: bpy.types.Object, action: bpy.types.Action | None) -> tuple[Motion | None, str]:
    """An action as a motion, or None and why it cannot be told as one."""
    if action is None or not actions.bone_curves(armature, action):
        return None, "no bone moves"
    try:
        return actions.read_action(armature, action), ""
    except actions.InexpressibleActionError as error:
        return None, str(error)


def placed(motion: Motion, armature: bpy.types.Object) -> Motion:
    """A motion in the armature's space, put where the armature stands in the world."""
    place = matrix(armature.matrix_world) @ np.linalg.inv(body_space(armature))
    rotations = motion.rotations.copy()
    rotations[:, 0] = place[:3, :3] @ rotations[:, 0]
    return replace(motion, rotations=rotations, pelvis=motion.pelvis @ place[:3, :3].T + place[:3, 3])


def _frames_to_bake(armature: bpy.types.Object, action: bpy.types.Action | None) -> tuple[np.ndarray, float]:
    if action is not None and (curves := actions.bone_curves(armature, action)):
        return actions.frames_of(action, curves)
    scene = bpy.context.scene
    return np.arange(scene.frame_start, scene.frame_end + 1, dtype=np.float64), actions.scene_rate()


def _evaluated_matrices(
    mesh: bpy.types.Object, triangles: np.ndarray, frames: np.ndarray
) -> Generator[float, None, np.ndarray]:
    """Frames of triangles on the evaluated mesh, shape (T, N, 4, 4)."""
    vertices = EvaluatedVertices(mesh, triangles)
    corners = np.empty((len(frames), *triangles.shape, 3))
    with closing(each_frame(frames)) as numbers:
        for number in numbers:
            corners[number] = vertices.positions()
            yield (number + 1) / len(frames)
    return triangle_frames(corners)
