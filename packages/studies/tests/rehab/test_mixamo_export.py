# SPDX-License-Identifier: GPL-3.0-or-later
"""Generated clips through Blender's FBX exporter and back through its importers."""

import contextlib
import csv
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

bpy = pytest.importorskip("bpy")

from w2w.core.motion.examples import demo_motions  # noqa: E402
from w2w.core.reading.clips import to_body  # noqa: E402
from w2w.core.reading.formats import read_motion  # noqa: E402
from w2w.scene.motion.load import read_by_blender  # noqa: E402
from w2w_studies.commands.demo_library import ACTIVITIES, write_demo_library  # noqa: E402
from w2w_studies.rehab import mixamo_export  # noqa: E402
from w2w_studies.rehab.clips import EXERCISES, RehabClip, generate_clip  # noqa: E402
from w2w_studies.rehab.mixamo_export import rest_axes, write_mixamo_fbx  # noqa: E402
from w2w_studies.rehab.skeleton import BONE_PARENTS, BONES, PREFIX  # noqa: E402

ROOT = Path(__file__).resolve().parents[4]
KINDS = ("objects", "armatures", "actions", "scenes")
IMPORTERS = ["import_scene.fbx"]
if "fbx_import" in dir(bpy.ops.wm):  # Blender 4.5 and later
    IMPORTERS.append("wm.fbx_import")


@pytest.fixture(scope="module", params=EXERCISES)
def exported(request, tmp_path_factory) -> tuple[RehabClip, Path]:
    clip = generate_clip(request.param, 1)
    path = tmp_path_factory.mktemp("fbx") / f"{request.param}.fbx"
    write_mixamo_fbx(clip, path)
    return clip, path


@contextlib.contextmanager
def imported(path: Path, importer: str) -> Iterator[bpy.types.Object]:
    before = {kind: set(getattr(bpy.data, kind)) for kind in KINDS}
    module, operator = importer.split(".")
    getattr(getattr(bpy.ops, module), operator)(filepath=str(path))
    new = [block for kind in KINDS for block in set(getattr(bpy.data, kind)) - before[kind]]
    try:
        yield next(block for block in new if getattr(block, "type", "") == "ARMATURE")
    finally:
        bpy.data.batch_remove(new)


def heads(armature: bpy.types.Object) -> np.ndarray:
    return np.array([armature.matrix_world @ armature.pose.bones[PREFIX + name].head for name in BONES])


@pytest.mark.parametrize("importer", IMPORTERS)
def test_joints_come_back_to_within_a_millimetre(exported, importer):
    clip, path = exported
    joints = clip.joints()
    with imported(path, importer) as armature:
        first, last = armature.animation_data.action.frame_range
        render = bpy.context.scene.render
        assert render.fps / render.fps_base == pytest.approx(clip.rate)
        assert last - first == clip.n_frames - 1
        for frame in range(0, clip.n_frames, 11):
            bpy.context.scene.frame_set(int(first) + frame)
            assert np.abs(heads(armature) - joints[frame]).max() < 1e-3


@pytest.mark.parametrize("importer", IMPORTERS)
def test_the_file_looks_like_one_of_mixamos(exported, importer):
    clip, path = exported
    with imported(path, importer) as armature:
        assert {bone.name for bone in armature.data.bones} == {PREFIX + name for name in BONES}
        assert "mixamo.com" in armature.animation_data.action.name
        np.testing.assert_allclose(armature.scale, 0.01, rtol=1e-5)
        rest = np.array(
            [armature.matrix_world @ armature.data.bones[PREFIX + name].head_local for name in BONES]
        )
        np.testing.assert_allclose(rest, clip.figure.rest(), atol=1e-5)
        for name, parent in zip(BONES[1:], BONE_PARENTS[1:], strict=True):
            assert armature.data.bones[PREFIX + name].parent.name == PREFIX + BONES[parent]


def test_bone_axes_are_right_handed_frames_along_the_bones():
    rest = generate_clip("sit_to_stand", 0).figure.rest()
    axes = rest_axes(rest)
    np.testing.assert_allclose(
        axes @ axes.transpose(0, 2, 1), np.broadcast_to(np.eye(3), axes.shape), atol=1e-12
    )
    np.testing.assert_allclose(np.linalg.det(axes), 1.0)
    thigh = BONES.index("LeftUpLeg")
    np.testing.assert_allclose(axes[thigh, :, 1], [0, 0, -1], atol=1e-12)
    np.testing.assert_allclose(axes[thigh, :, 2], [0, -1, 0], atol=1e-12)


@pytest.mark.slow
def test_the_same_clip_gives_the_same_bytes_in_another_process(exported, tmp_path):
    clip, path = exported
    again = tmp_path / "again.fbx"
    write_mixamo_fbx(clip, again)
    assert again.read_bytes() == path.read_bytes()
    if clip.activity == "sit_to_stand":  # one process is enough: it takes a second to start
        elsewhere = tmp_path / "elsewhere.fbx"
        code = (
            "from w2w_studies.rehab.clips import generate_clip\n"
            "from w2w_studies.rehab.mixamo_export import write_mixamo_fbx\n"
            f"write_mixamo_fbx(generate_clip({clip.activity!r}, 1), {str(elsewhere)!r})"
        )
        environment = os.environ | {"PYTHONHASHSEED": "12345"}
        subprocess.run(
            [sys.executable, "-c", code], cwd=ROOT, env=environment, check=True, capture_output=True
        )
        assert elsewhere.read_bytes() == path.read_bytes()


def test_blocks_of_the_open_file_do_not_change_the_bytes(exported, tmp_path):
    """As other tests of the same process, or a user, leave them."""
    clip, path = exported
    left = [bpy.data.objects.new("Armature", None), bpy.data.scenes.new("mixamo.com")]
    names = [block.name for block in left]
    try:
        write_mixamo_fbx(clip, tmp_path / "again.fbx")
        assert (tmp_path / "again.fbx").read_bytes() == path.read_bytes()
        assert [block.name for block in left] == names == ["Armature", "mixamo.com"]
    finally:
        bpy.data.batch_remove(left)


def test_the_open_scene_is_left_as_it_was(tmp_path):
    before = {kind: set(getattr(bpy.data, kind)) for kind in KINDS}
    scene, rate = bpy.context.window.scene, bpy.context.window.scene.render.fps
    write_mixamo_fbx(generate_clip("arm_raise_band", 0), tmp_path / "clip.fbx")
    assert {kind: set(getattr(bpy.data, kind)) for kind in KINDS} == before
    assert bpy.context.window.scene == scene
    assert scene.render.fps == rate


def test_nothing_half_written_stays_behind(tmp_path, monkeypatch):
    clip = generate_clip("arm_raise_band", 0)
    with pytest.raises(FileNotFoundError, match="create it first"):
        write_mixamo_fbx(clip, tmp_path / "missing" / "clip.fbx")

    def fails(_, path: Path) -> None:
        path.write_bytes(b"half")
        raise KeyboardInterrupt

    monkeypatch.setattr(mixamo_export, "_export", fails)
    scenes = set(bpy.data.scenes)
    with pytest.raises(KeyboardInterrupt):
        write_mixamo_fbx(clip, tmp_path / "clip.fbx")
    assert list(tmp_path.iterdir()) == []
    assert set(bpy.data.scenes) == scenes


@pytest.mark.slow
def test_a_library_has_a_folder_an_activity_and_says_who_moves(tmp_path):
    advances = []
    paths = write_demo_library(tmp_path / "library", clips_per_activity=2, seed=5, progress=advances.append)
    assert advances == [1] * len(paths) == [1] * 2 * len(ACTIVITIES)
    assert (tmp_path / "library" / "shake_head" / "Shake Head (2).fbx") in paths
    assert all(path.read_bytes().startswith(b"Kaydara FBX Binary") for path in paths)
    assert len({path.read_bytes() for path in paths}) == len(paths)
    with (tmp_path / "library" / "labels.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [tmp_path / "library" / row["file"] for row in rows] == paths
    assert {row["activity"] for row in rows} == set(ACTIVITIES)
    assert {row["subject"] for row in rows} == {"S01", "S02"}
    with pytest.raises(ValueError, match="at least one clip"):
        write_demo_library(tmp_path / "none", clips_per_activity=0)


def test_the_demos_motions_are_such_clips_on_the_bundled_body(bundled_body, tmp_path):
    stored = demo_motions()["shake_head_3.npz"]
    write_mixamo_fbx(generate_clip("shake_head", 2), tmp_path / "clip.fbx")
    made = to_body(read_motion(tmp_path / "clip.fbx", blender=read_by_blender), bundled_body).motion
    assert (stored.subject, stored.rate, stored.n_frames) == ("S03", made.rate, made.n_frames)
    np.testing.assert_allclose(stored.pelvis, made.pelvis, rtol=0, atol=1e-6)
    np.testing.assert_allclose(stored.rotations, made.rotations, rtol=0, atol=1e-6)
