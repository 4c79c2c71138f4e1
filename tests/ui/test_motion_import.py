# SPDX-License-Identifier: GPL-3.0-or-later
"""Files and armatures as motions: what is taken, left alone and said."""

from __future__ import annotations

import shutil
import threading
import time
from dataclasses import replace
from pathlib import Path

import addon_utils
import bpy
import cloudpickle
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.library.import_plan import plan_folder
from w2w.core.motion.motion import Motion
from w2w.core.patches import strip_graph
from w2w.core.patches.strip_graph import SkinDistances
from w2w.core.ranking.pooling import LOST, WIDTH_M
from w2w.core.reading.formats import MOTION_SUFFIXES
from w2w.core.reading.reader import Reader
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of, body_of
from w2w.ui.jobs import jobs
from w2w.ui.panels import menus
from w2w.ui.steps import motion_import, patches
from w2w.ui.steps.motion_import import ImportItem, import_items, import_steps
from w2w.ui.study import lists
from w2w.ui.study.state import placed_patches

from ..hostile_c3d import plant, write_hostile
from ..patience import HANG_S
from .made_study import make_study, names_in_file, take_through

pytestmark = pytest.mark.usefixtures("blender")


def test_a_cancelled_import_leaves_the_file_as_it_was(library: Path) -> None:
    body = make_study(library, "")
    before = names_in_file()
    steps = import_steps(body, import_items(plan_folder(library)))
    while len(body.w2w.clips) < 3:
        next(steps)
    steps.close()
    assert len(body.w2w.clips) == 0
    assert names_in_file() == before


def test_while_files_are_read_spots_are_spread_and_the_skin_is_measured(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body, begun = make_study(library, ""), []
    body.w2w.patch_count = 23  # as in no other test
    submit = jobs.pool.submit
    monkeypatch.setattr(jobs.pool, "submit", lambda *work: begun.append(submit(*work)) or begun[-1])
    for _ in import_steps(body, import_items(plan_folder(library))):
        pass
    begun[0].result(HANG_S)
    monkeypatch.setattr(patches, "sample", lambda *_: pytest.fail("they are spread twice"))
    assert bpy.ops.w2w.place_patches() == {"FINISHED"}
    known = strip_graph._measured.cache_info().hits
    SkinDistances.of(body_of(body), placed_patches(body).vertices, LOST * WIDTH_M)
    assert strip_graph._measured.cache_info().hits == known + 1


def test_a_rate_in_the_labels_goes_before_the_dialog_s(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = shutil.copytree(library, tmp_path / "labelled")
    files = sorted(path.relative_to(library).as_posix() for path in library.rglob("*.npz"))[:2]
    (library / "labels.csv").write_text(f"file,activity,rate\n{files[0]},wave,50\n{files[1]},wave,\n")
    items = import_items(plan_folder(library), rate=25.0)
    assert [item.rate for item in items] == [50, 25]
    body = make_study(library, "")
    monkeypatch.setattr(lists, "listed_spelling", lambda *_: pytest.fail("labels are spelled by all others"))
    for _ in import_steps(body, items):
        pass
    assert [(clip.rate, clip.given_rate) for clip in body.w2w.clips] == [(50, 50), (25, 25)]


def test_no_file_is_imported_in_one_turn_of_the_window(
    library: Path, shared_data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Files are read and retargeted in a thread, FBX by another Blender."""
    threads: list[bool] = []
    brought: list[bytes] = []
    do = Reader.read

    def watched(*given: object) -> object:
        time.sleep(3 * jobs.POLL)
        threads.append(threading.current_thread() is threading.main_thread())
        brought.append(cloudpickle.dumps(given[-1]))
        return do(*given)

    monkeypatch.setattr(Reader, "read", watched)
    body = make_study(library, "")
    files = ("mixamo/Conqster__TheBarMan/Walking.fbx", "bvh/bandai_namco/dataset-1_walk_active_001.bvh")
    items = [
        ImportItem(shared_data / file, file, f"walk {number}", "walking") for number, file in enumerate(files)
    ]
    turns = [[len(body.w2w.clips), len(threads)] for _ in import_steps(body, items)]
    assert threads == [False] * 2
    assert not any(b"w2w.ui" in work for work in brought)  # which another Blender would import
    assert [0, 1] in turns  # the FBX file is being read, and is not written yet
    assert len(body.w2w.clips) == 2


def test_unusable_files_stay_in_the_list_and_say_why(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "")
    (tmp_path / "empty.fbx").touch()
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "empty.fbx"}])
    assert "empty" in body.w2w.clips[0].problem
    assert "cannot be used" in jobs.message.text
    bpy.ops.w2w.tick_clips(which="PROBLEM")
    bpy.ops.w2w.remove_clips()
    assert len(body.w2w.clips) == 0


@pytest.mark.later
def test_a_file_that_kills_its_reader_leaves_this_blender_alive(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant(tmp_path / "planted", monkeypatch)
    (file,) = write_hostile(tmp_path / "damaged", ("crashes",))
    body = make_study(library, "")
    bpy.ops.w2w.import_motions(directory=str(file.parent), files=[{"name": file.name}])
    assert "the program that reads it crashed" in body.w2w.clips[0].problem


def test_a_fault_of_ours_at_one_file_costs_that_file_alone(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    read = motion_import.open_clip

    def faulty(clip: ImportItem, *more: object) -> object:
        if clip.path.stem == "kicking 1":
            raise AttributeError("no bones")
        return read(clip, *more)

    monkeypatch.setattr(motion_import, "open_clip", faulty)
    body = take_through(library, "motions")
    problems = {clip.problem for clip in body.w2w.clips if clip.problem}
    assert problems == {"W2W failed on it, please report this: AttributeError: no bones"}
    assert sum(clip.action is not None for clip in body.w2w.clips) == 8


def test_a_later_import_spells_labels_as_the_list_does(library: Path) -> None:
    body = make_study(library, "motions")
    item = import_items(plan_folder(library))[0]
    for _ in import_steps(body, [replace(item, activity=f" {item.activity.upper()} ")]):
        pass
    assert body.w2w.clips[len(body.w2w.clips) - 1].activity == item.activity


def test_labels_typed_in_the_list_are_spelled_as_others_are(library: Path) -> None:
    clips = make_study(library, "motions").w2w.clips
    for typed in (" Kicking ", "KICKING", "kicking"):
        clips[-1].activity = typed
        assert clips[-1].activity == clips[-1].action["activity"] == "kicking"
    clips[-1].activity = "KICKING"
    assert jobs.message.text == "'kicking' and 'KICKING' count as one activity, 'kicking'"
    clips[0].subject, clips[1].subject = "Zoe\u0301", "zo\u00e9"
    assert {clips[0].subject, clips[1].subject} == {"Zo\u00e9"}
    clips[-1].selected = True
    bpy.ops.w2w.relabel_clips(activity="Kick ing")
    assert clips[-1].activity == "Kick ing"
    bpy.ops.w2w.relabel_clips(activity="KickinG")
    assert clips[-1].activity == "kicking"


def test_a_rest_pose_that_is_dropped_is_said(library: Path, tmp_path: Path) -> None:
    motion = Motion.load(library / "kicking/kicking 1.npz")
    turns, place = motion.rotations[:1] * 0 + np.eye(3), motion.pelvis[:1]
    rotations = np.concatenate([turns, turns, motion.rotations])
    pelvis = np.concatenate([place, place, motion.pelvis])
    replace(motion, rotations=rotations, pelvis=pelvis).save(tmp_path / "led.npz")
    make_study(library, "")
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "led.npz"}])
    assert jobs.message.text.endswith("1 clip cut at the ends: led.npz (frames 0 to 1 cut off: a rest pose)")


def test_relabelling_ticked_clips_relabels_their_actions(library: Path) -> None:
    body = make_study(library, "motions")
    bpy.ops.w2w.tick_clips(which="ACTIVITY")
    bpy.ops.w2w.relabel_clips(activity="greeting")
    relabelled = [clip for clip in body.w2w.clips if clip.activity == "greeting"]
    assert len(relabelled) == 3
    assert all(clip.action["activity"] == "greeting" for clip in relabelled)
    with pytest.raises(RuntimeError, match="Type an activity"):
        bpy.ops.w2w.relabel_clips(activity="  ")


@pytest.mark.slow
def test_actions_of_the_same_rig_in_the_scene_are_not_taken_for_the_file_s(
    library: Path, tmp_path: Path
) -> None:
    bpy.context.scene.render.fps = 30
    body = make_study(library, "motions")
    armature, clips = armature_of(body), body.w2w.clips
    export_clip(body, 4, tmp_path / "one.fbx")
    expected = read_action(armature, clips[4].action)
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "one.fbx"}])
    found = read_action(armature, clips[-1].action)
    np.testing.assert_allclose(turns(found), turns(expected), atol=4)


def turns(motion: Motion) -> np.ndarray:
    """Widest turn of each joint, degrees."""
    angles = Rotation.from_matrix(motion.rotations.reshape(-1, 3, 3)).magnitude()
    return np.degrees(angles.reshape(motion.n_frames, -1).max(axis=0))


def export_clip(body: bpy.types.Object, index: int, path: Path) -> None:
    """Write the body's armature with one clip as an FBX file."""
    bpy.ops.w2w.preview_clip(index=index)
    scene, armature = bpy.context.scene, armature_of(body)
    scene.frame_start, scene.frame_end = 1, scene.frame_preview_end
    armature.hide_set(False)
    bpy.ops.object.select_all(action="DESELECT")
    armature.select_set(True)
    addon_utils.enable("io_scene_fbx")
    bpy.ops.export_scene.fbx(
        filepath=str(path), use_selection=True, object_types={"ARMATURE"}, add_leaf_bones=False,
        bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
    )  # fmt: skip


def test_all_kinds_of_motion_files_can_be_chosen_and_dropped() -> None:
    offered = bpy.ops.w2w.import_motions.get_rna_type().properties["filter_glob"].default
    assert offered.split(";") == [f"*{suffix}" for suffix in MOTION_SUFFIXES]
    assert menus.W2W_FH_motions.bl_file_extensions.split(";") == list(MOTION_SUFFIXES)


@pytest.mark.slow
def test_each_animation_of_a_file_becomes_a_clip_under_its_name(
    shared_data: Path, library: Path, tmp_path: Path
) -> None:
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(shared_data / "mixamo/Conqster__TheBarMan/Walking.fbx"))
    action = bpy.data.actions[0]
    action.name, action.copy().name = "Walk", "Slow Walk"
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "pack.glb"), export_animation_mode="ACTIONS")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    body = make_study(library, "")
    bpy.ops.w2w.import_motions(directory=str(tmp_path), files=[{"name": "pack.glb"}])
    found = {(clip.name, clip.activity, clip.animation, clip.problem) for clip in body.w2w.clips}
    assert found == {
        ("pack_glb_Slow_Walk", "slow_walk", "Slow Walk", ""),
        ("pack_glb_Walk", "walk", "Walk", ""),
    }
    assert {clip.file for clip in body.w2w.clips} == {str(tmp_path / "pack.glb")}
