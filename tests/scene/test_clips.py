# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading real motion files: right take, right frames, nothing left behind, true sentences."""

import bpy
import numpy as np
import pytest

from w2w.core.motion.source import UnusableMotion
from w2w.scene.motion.takes import find_takes, imported, read_clip, read_take


@pytest.fixture(autouse=True)
def empty_scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def evaluated(armature, frames):
    """World matrices of all bones as Blender itself evaluates them, frame by frame."""
    result = []
    for frame in frames:
        bpy.context.scene.frame_set(int(frame))
        graph = bpy.context.evaluated_depsgraph_get()
        posed = armature.evaluated_get(graph)
        result.append([posed.matrix_world @ bone.matrix for bone in posed.pose.bones])
    return np.array(result)


@pytest.mark.parametrize(
    "file",
    [
        "M3-org__CharacterStudio/StrutWalking.fbx",
        "M3-org__CharacterStudio/Crawling.fbx",
        "eminkarakaya__Idle-Restaurant/Eating.fbx",
        "GDDMN__Test_DigitalOxygen/Punch.fbx",
        "keijiro__CMUMocap/135_01.fbx",
    ],
)
def test_frames_are_those_blender_evaluates(shared_data, file):
    with imported(shared_data / "mixamo" / file) as objects:
        armature = next(item for item in objects if item.type == "ARMATURE")
        take = next(
            take
            for take in find_takes(armature, bpy.data.actions)
            if take.action == armature.animation_data.action
        )
        motion = read_take(take)
        start = take.frame_range[0]
        frames = np.arange(motion.n_frames)[:: max(1, motion.n_frames // 6)]
        truth = evaluated(armature, frames + start)
        order = [bone.name for bone in armature.pose.bones]
    ours = motion.matrices[frames][:, [motion.bones.index(name) for name in order]]
    size = np.ptp(motion.rest[1:, :3, 3], axis=0).max()
    np.testing.assert_allclose(ours[..., :3, 3], truth[..., :3, 3], atol=2e-4 * size)
    scale = np.linalg.norm(truth[..., :3, 0], axis=-1)[..., None, None]
    np.testing.assert_allclose(ours[..., :3, :3] / scale, truth[..., :3, :3] / scale, atol=2e-3)


def test_nothing_is_left_behind(shared_data):
    scene = bpy.context.scene
    scene.render.fps, scene.frame_end = 25, 99
    bpy.ops.mesh.primitive_cube_add()
    before = {
        kind: set(getattr(bpy.data, kind).keys())
        for kind in ("objects", "armatures", "actions", "meshes", "materials")
    }
    read_clip(shared_data / "mixamo/Conv-AI__ThreeJs-World-Tutorial/TalkingMale.fbx")
    with pytest.raises(UnusableMotion):
        read_clip(shared_data / "mixamo/_broken/static_mesh_box_001.fbx")
    after = {kind: set(getattr(bpy.data, kind).keys()) for kind in before}
    assert after == before
    assert (scene.render.fps, scene.frame_end) == (25, 99)


@pytest.mark.parametrize(
    ("file", "take", "frames", "rate"),
    [
        ("s4ru__Projecto-Visualizacion/Digging.fbx", "mixamo.com", 291, 60),
        ("fufroom__synthetic-echoes/Right Turn.fbx", "mixamo.com", 55, 30),
        ("Conv-AI__ThreeJs-World-Tutorial/TalkingMale.fbx", "mixamo.com", 298, 30),
        ("W3bbieLabs__bullrun/Fast Run (3).fbx", "mixamo.com", 17, 30),
        ("GDDMN__Test_DigitalOxygen/Punch.fbx", "mixamo.com", 81, 30),
        ("Uncleared__RootMotionNavMesh/Soccer Kick.fbx", "10_03", 73, 24),
    ],
)
def test_the_take_that_moves_is_read(shared_data, file, take, frames, rate):
    if "fbx_import" not in dir(bpy.ops.wm):
        pytest.skip("this Blender has only the Python importer")
    motion = read_clip(shared_data / "mixamo" / file)
    assert take in motion.take
    assert (motion.n_frames, motion.rate) == (frames, rate)


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("_broken/zero_bytes.fbx", "empty"),
        ("_broken/lfs_pointer_Feminine_TPose.fbx", "Git LFS pointer"),
        ("_broken/truncated_50pct_Walking.fbx", "cut short"),
        ("_broken/truncated_header_only.fbx", "cut short: 27 bytes"),
        ("_broken/static_mesh_box_001.fbx", "no armature"),
        ("keijiro__CMUMocap/Base.fbx", "no animation"),
        ("M3-org__CharacterStudio/T-Pose.fbx", "a pose, not a motion"),
        (
            "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Female Dynamic Pose.fbx",
            "a pose, not a motion",
        ),
    ],
)
def test_unusable_files_are_refused_with_a_true_sentence(shared_data, file, reason):
    with pytest.raises(UnusableMotion, match=reason):
        read_clip(shared_data / "mixamo" / file)


def test_other_files_and_missing_files_are_refused(tmp_path):
    (tmp_path / "text.fbx").write_text("hello, this is not a motion file")
    (tmp_path / "text.bvh").write_text("hello")
    (tmp_path / "clip.xyz").write_text("hello")
    for name, reason in (
        ("text.fbx", "not an FBX file"),
        ("text.bvh", "does not begin with HIERARCHY"),
        ("clip.xyz", "'.xyz' is not a kind"),
        ("missing.fbx", "cannot be read"),
    ):
        with pytest.raises(UnusableMotion, match=reason):
            read_clip(tmp_path / name)
