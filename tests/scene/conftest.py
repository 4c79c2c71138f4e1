# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of tests inside Blender: an empty scene, a body in it, its patches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.body.body import Body
from w2w.core.patches.patches import PatchSet, sample_patches
from w2w.scene.bake import Bake, PatchBaker
from w2w.scene.base.body import BodyObjects, add_body
from w2w.scene.base.playback import each_frame
from w2w.scene.base.steps import without_pauses

bpy.ops.preferences.addon_disable(module="cycles")  # it looks through every file that is opened


@pytest.fixture
def empty_file() -> bpy.types.Scene:
    """Blender with an empty file open, at 24 frames a second."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return bpy.context.scene


@pytest.fixture
def body_in_scene(made_once: Callable[..., Path], bundled_body: Body) -> BodyObjects:
    """The bundled body in an otherwise empty file, made once and opened: adding it takes longer."""

    def make(folder: Path) -> None:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        add_body(bundled_body)
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / "body.blend"), copy=True)

    file = made_once(f"body in Blender {bpy.app.version_string}", make) / "body.blend"
    bpy.ops.wm.open_mainfile(filepath=str(file), load_ui=False)
    (mesh,) = (item for item in bpy.data.objects if item.type == "MESH")
    return BodyObjects(mesh, mesh.parent)


@pytest.fixture(scope="session")
def patches(bundled_body: Body) -> PatchSet:
    """A few patches all over the bundled body."""
    return sample_patches(bundled_body, n=48, seed=3)


def difference(matrices: np.ndarray, truth: np.ndarray) -> tuple[float, float]:
    """Largest distance, metres, and largest angle, degrees, between two arrays of poses."""
    distance = np.linalg.norm(matrices[..., :3, 3] - truth[..., :3, 3], axis=-1).max()
    turn = np.swapaxes(matrices[..., :3, :3], -1, -2) @ truth[..., :3, :3]
    # from the antisymmetric part: the arc cosine of the trace has no digits left near zero
    axis = np.stack(
        [
            turn[..., 2, 1] - turn[..., 1, 2],
            turn[..., 0, 2] - turn[..., 2, 0],
            turn[..., 1, 0] - turn[..., 0, 1],
        ]
    )
    cosine = (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2
    return float(distance), float(np.degrees(np.arctan2(np.linalg.norm(axis / 2, axis=0), cosine)).max())


def bake(mesh, patches, action=None, path="auto") -> Bake:
    """World matrices of a body's patches during one action."""
    with pytest.MonkeyPatch.context() as patch:
        if path == "general":
            patch.setattr("w2w.scene.bake.why_not_fast", lambda *_: "asked for")
        return without_pauses(PatchBaker(mesh, patches).by_frame(action))


def read_empties(empties, frames: np.ndarray) -> np.ndarray:
    """World matrices of objects, frame by frame, as Blender gives them: the truth for both ways to bake."""
    matrices = np.empty((len(frames), len(empties), 4, 4))
    for number in each_frame(frames):
        matrices[number] = [np.array(empty.matrix_world) for empty in empties]
    return matrices
