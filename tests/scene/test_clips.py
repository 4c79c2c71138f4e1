# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading real motion files: right take, right frames, nothing left behind, true sentences."""

import bpy
import numpy as np
import pytest

from w2w.core.motion.skinning import skin, skinning_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.animations import animations_in
from w2w.core.reading.clips import to_body
from w2w.scene.base.fcurves import action_curves
from w2w.scene.motion.takes import find_takes, imported, read_clip, read_take

from ..rings import by_day


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


def test_a_source_that_sinks_stands_at_its_ends(shared_data, bundled_body):
    """The source's hips are 13 cm lower in the middle than at its ends."""
    source = read_clip(
        shared_data / "mixamo/lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Dig And Plant Seeds.fbx"
    )
    motion = to_body(source, bundled_body).motion
    lowest = skin(bundled_body, skinning_transforms(bundled_body, motion))[..., 2].min(axis=1)
    assert abs(lowest[[0, -1]]).max() < 0.02
    assert lowest.min() > -0.02
    assert np.median(lowest) < 0.02


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


@pytest.mark.later
@pytest.mark.parametrize("suffix", by_day([".glb"], [".glb", ".fbx"]))
def test_each_of_several_animations_is_read_as_blender_plays_it(shared_data, tmp_path, suffix):
    bpy.ops.import_scene.fbx(filepath=str(shared_data / "mixamo/Conqster__TheBarMan/Walking.fbx"))
    armature = next(item for item in bpy.data.objects if item.type == "ARMATURE")
    walk = armature.animation_data.action
    walk.name = "Walk"
    stretch = {"Walk": 1.0, "Armature|Slow Walk": 2.0, "Fast Walk": 0.75}
    bones = ["mixamorig:LeftHand", "mixamorig:RightFoot", "mixamorig:Head", "mixamorig:LeftLeg"]
    truth, start = {}, walk.frame_range[0]
    for name, factor in stretch.items():
        action = walk if name == "Walk" else walk.copy()
        action.name = name
        for curve in next(action_curves(action)):
            for key in curve.keyframe_points if action != walk else ():
                key.co[0] = start + factor * (key.co[0] - start)
            curve.update()
        armature.animation_data.action = action
        frames = np.arange(start, action.frame_range[1] + 0.5)
        order = [bone.name for bone in armature.pose.bones]
        truth[name] = evaluated(armature, frames)[..., :3, 3][:, [order.index(bone) for bone in bones]]
    file = tmp_path / f"pack{suffix}"
    if suffix == ".glb":
        bpy.ops.export_scene.gltf(filepath=str(file), export_animation_mode="ACTIONS")
    else:
        every = {"bake_anim_use_nla_strips": False, "bake_anim_simplify_factor": 0.0}
        bpy.ops.export_scene.fbx(filepath=str(file), **every)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    names = animations_in(file)
    assert names.keys() == {"Walk", "Armature|Slow Walk", "Fast Walk"}
    for name, full in names.items():
        source = read_clip(file, 30.0, full)
        places = [[bone.split(":")[-1] for bone in source.bones].index(bone.split(":")[-1]) for bone in bones]
        found = source.matrices[..., :3, 3][:, places]
        assert source.n_frames == len(truth[name])
        assert np.linalg.norm(found - truth[name], axis=-1).max() < 0.005
    with pytest.raises(UnusableMotion, match="no animation"):
        read_clip(file, 30.0, "Swim")
