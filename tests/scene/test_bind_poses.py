# SPDX-License-Identifier: GPL-3.0-or-later
"""FBX files whose bind pose has another size or another axis up than their nodes move as if it had not."""

from array import array
from functools import partial
from pathlib import Path

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.motion.skinning import joint_transforms
from w2w.core.reading import formats
from w2w.core.reading.clips import to_body
from w2w.scene.base.actions import show_action, write_action
from w2w.scene.base.body import add_body
from w2w.scene.motion import takes
from w2w.scene.motion.load import read_by_blender

from ..rings import by_day
from ..robustness.fbx_variants import rewrite

read_motion = partial(formats.read_motion, blender=read_by_blender)

CPP = [True, False] if "fbx_import" in dir(bpy.ops.wm) else [False]

MATRICES = (b"Matrix", b"TransformLink")
"""Records that hold a bone's bind pose: of a pose, and of the skin."""


@pytest.fixture
def file_with_mesh(made_once, bundled_body, waving) -> Path:
    """The bundled body on its way, with its mesh: so Blender writes a bind pose."""

    def make(folder: Path) -> None:
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        bpy.context.scene.render.fps = round(waving.rate)
        armature = add_body(bundled_body).armature
        show_action(armature, write_action(armature, waving))
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = 1, waving.n_frames
        bpy.ops.export_scene.fbx(filepath=str(folder / "mesh.fbx"), bake_anim_simplify_factor=0.0)

    return made_once(f"a body on its way by Blender {bpy.app.version_string}", make) / "mesh.fbx"


def with_bind(file: Path, target: Path, which: str, size: float, angle: float) -> Path:
    """A copy of an FBX file with another bind pose of its bones, or of the armature that holds them."""
    chosen: set[int] = set()
    turn = np.eye(4)
    turn[:3, :3] = size * Rotation.from_euler("x", angle, degrees=True).as_matrix()

    def change(element):
        props = list(element.props)
        if element.id == b"Model" and (props[2] == b"LimbNode") == (which == "bones"):
            chosen.add(props[0])
        if element.id in (b"PoseNode", b"Deformer"):
            node = next((child.props[0] for child in element.elems if child.id == b"Node"), None)
            matrices = [child for child in element.elems if child.id in MATRICES]
            if node in chosen or (node is None and which == "bones"):
                chosen.update(map(id, matrices))
        if element.id in MATRICES and id(element) in chosen:
            matrix = turn @ np.reshape(props[0], (4, 4)).T
            props[0] = array("d", matrix.T.ravel())
        return props

    assert rewrite(file, target, change)
    return target


def apart(body, one, other) -> tuple[float, float]:
    """Largest distance between two pelves, metres, from their means on, and angle between joints, degrees."""
    (turns, heads), (other_turns, others) = (joint_transforms(body, motion) for motion in (one, other))
    between = (turns.swapaxes(-1, -2) @ other_turns).reshape(-1, 3, 3)
    path = heads[:, 0] - others[:, 0]
    return (
        np.linalg.norm(path - path.mean(axis=0), axis=1).max(),
        np.degrees(Rotation.from_matrix(between).magnitude().max()),
    )


@pytest.fixture(params=CPP, autouse=True)
def importer(request, monkeypatch):
    """Blender's importer before 4.5, and that since."""
    monkeypatch.setattr(takes, "_has_cpp_importer", lambda: request.param)


BINDS = [("bones", 100, 0), ("armature", 100, 0), ("bones", 39.37, 90), ("armature", 1, -90)]
RARER = [("bones", 0.01, 0), ("bones", 2.54, 0), ("bones", 10, 0), ("bones", 1, -90), ("armature", 0.01, 90)]


@pytest.mark.parametrize(("which", "size", "angle"), by_day(BINDS, BINDS + RARER))
def test_a_bind_pose_in_another_size_or_turned_changes_nothing(
    file_with_mesh, bundled_body, tmp_path, which, size, angle
):
    expected = to_body(read_motion(file_with_mesh), bundled_body).motion
    other = with_bind(file_with_mesh, tmp_path / "other.fbx", which, size, angle)
    far, wide = apart(bundled_body, expected, to_body(read_motion(other), bundled_body).motion)
    assert far < 0.002
    assert wide < 0.2
    assert np.ptp(expected.pelvis, axis=0).max() > 1


def test_nodes_that_are_scaled_themselves_keep_their_way(file_with_mesh, bundled_body, tmp_path):
    """Bones whose own nodes are scaled, and their bind pose is not: that is another motion, read as it is."""

    def change(element):
        props = list(element.props)
        if element.id == b"Model":
            names.append(props[1].partition(b"\0")[0])
        if element.id == b"P" and props[0] == b"Lcl Scaling" and names[-1] == b"pelvis":
            props[-3:] = [2 * value for value in props[-3:]]
        return props

    names = [b""]
    assert rewrite(file_with_mesh, tmp_path / "other.fbx", change)
    expected, found = (
        to_body(read_motion(file), bundled_body) for file in (file_with_mesh, tmp_path / "other.fbx")
    )
    assert apart(bundled_body, expected.motion, found.motion)[0] < 0.002


@pytest.mark.parametrize("file", ["turn_bind_pose_1.fbx", "turn_bind_pose_100.fbx"])
def test_who_turns_in_place_does_not_travel(shared_cases, bundled_body, file):
    motion = to_body(read_motion(shared_cases / "second" / file), bundled_body).motion
    assert np.ptp(motion.pelvis, axis=0).max() < 0.05
