# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w inspect` says what a file holds and whether it would be used."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import bpy
import pytest
from typer.testing import CliRunner

from w2w.core.library.library import read_library
from w2w.headless.app import APP
from w2w.headless.commands.inspect import label_said

from ...command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

ROOT = Path(__file__).resolve().parents[3]


def inspect(*arguments):
    return cli("inspect", *arguments)


def test_a_clip_that_would_be_used(shared_data):
    code, output = inspect(
        shared_data / "mixamo/MahindraVishal06__Third-PersonMovementSystem/Walking Turn 180.fbx"
    )
    assert code == 0
    assert "would be used" in output
    assert "67 bones, matched by their names (Mixamo)" in output
    assert "31 at 30 frames/s" in output
    assert "180 degrees" in output


def test_an_amass_clip(shared_data):
    code, output = inspect(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    assert code == 0
    assert "601 at 120 frames/s" in output


@pytest.mark.parametrize(
    ("file", "reason"),
    [
        ("mixamo/_broken/zero_bytes.fbx", "the file is empty"),
        ("mixamo/M3-org__CharacterStudio/T-Pose.fbx", "a pose, not a motion"),
        ("smpl_poses/hbertiche__NeuralClothSim/0000.npz", "(19, 65, 4)"),
        ("README.md", "not a kind of motion file"),
        ("nowhere.mot", "OpenSim model: take the trc"),
        ("nowhere.fbx", "cannot be read"),
    ],
)
def test_a_file_that_would_not_be_used(shared_data, file, reason):
    code, output = inspect(shared_data / file)
    assert code == 1
    assert "would be skipped" in output
    assert reason in output
    assert "Traceback" not in output


def test_a_bone_map_of_the_user_s_own(shared_data, tmp_path):
    clip = shared_data / "mixamo/Conqster__TheBarMan/Walking.fbx"
    mine = tmp_path / "mine.json"
    joints = json.loads((ROOT / "assets/templates/bone_maps/mixamo.json").read_text())["joints"]
    mine.write_text(json.dumps({"name": "our own rig", "joints": joints}))
    result = CliRunner().invoke(APP, ["inspect", str(clip), "--bone-map", str(mine)], env={"COLUMNS": "200"})
    assert result.exit_code == 0
    assert "33 bones, matched by their names (our own rig)" in result.output
    mine.write_text("{}")
    result = CliRunner().invoke(APP, ["inspect", str(clip), "--bone-map", str(mine)], env={"COLUMNS": "200"})
    assert result.exit_code == 2
    assert "is not a bone map" in " ".join(result.output.split())


WALKING = "mixamo/Conqster__TheBarMan/Walking.fbx"


@pytest.mark.later
@pytest.mark.parametrize(
    ("file", "left_out"),
    [
        ("root_glitch.bvh", "frames 0 to 6 cut off: damaged"),
        ("cmu_07_01.fbx", "frame 0 cut off: a rest pose"),
    ],
)
def test_frames_that_are_left_out_are_named(shared_cases, file, left_out):
    code, output = inspect(shared_cases / file)
    assert code == 0
    assert f"left out {left_out}" in output


@pytest.mark.slow
def test_takes_that_are_not_used_are_named(shared_data, tmp_path):
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(shared_data / WALKING))
    action = next(iter(bpy.data.actions))
    for name in ("one", "two"):
        action.copy().name = name
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"), export_animation_mode="ACTIONS")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    code, output = inspect(tmp_path / "a.glb")
    assert code == 0, output
    assert re.search(
        r"other takes 2 that move are not used: '.*' and '.*'; save each as a file of its own", output
    )


def test_plain_english_for_each_kind_of_file(shared_data):
    """The whole output, as people read it."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)  # or Blender may number the take
    take = "mixamo.com"
    if "fbx_import" not in dir(bpy.ops.wm):  # the importer before 4.5 adds the names of armature and layer
        take = f"Armature|{take}|Layer0"
    expected = {
        WALKING: f"take '{take}' skeleton 33 bones, matched by their names (Mixamo) scale 1 unit in the "
        "file is 0.8209 m on W2W's body; the rest pose spans 2.01 units frames 32 at 30 frames/s duration "
        "1.03 s body turns 0 degrees between the first and last frame body travels 0.00 m between the first "
        "and last frame hands travel left 0.90 m, right 1.09 m along their paths Walking.fbx would be used.",
        "smpl_poses/nghorbani__amass/amass_sample.npz": "skeleton SMPL joints frames 601 at 120 frames/s "
        "up z, 1 file of AMASS duration 5.00 s",
        "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh": "skeleton 22 bones, matched by their "
        "names (Bandai-Namco) rest pose a guess, from its own motion: the file has none that a body can "
        "take scale 1 unit in the file is 0.01049 m on W2W's body; the rest pose spans 140 units frames 37 "
        "at 30 frames/s up y",
    }
    for file, words in expected.items():
        code, output = inspect(shared_data / file)
        assert code == 0
        assert words in output


def test_bones_of_unknown_names(shared_data, tmp_path):
    text = (shared_data / "bvh/bandai_namco/dataset-2_raise-up-left-hand_active_001.bvh").read_text()
    names = re.findall(r"(?:ROOT|JOINT)\s+(\S+)", text)
    for number, name in enumerate(names):
        text = re.sub(rf"(ROOT|JOINT)\s+{name}\b", rf"\1 qx{number:02d}z", text)
    (tmp_path / "walk.bvh").write_text(text)
    code, output = inspect(tmp_path / "walk.bvh")
    assert code == 0
    assert "22 bones, matched by structure, as no bone map knows their names" in output


def test_a_clip_shorter_than_a_window_would_be_skipped_as_a_run_does(tmp_path, waving):
    replace(waving, rotations=waving.rotations[:8], pelvis=waving.pelvis[:8]).save(tmp_path / "moment.npz")
    code, output = inspect(tmp_path / "moment.npz")
    assert code == 1
    assert "moment.npz would be skipped: it is shorter than the 0.5 s a window needs." in output


@pytest.fixture
def library(shared_data, tmp_path):
    """A folder of folders that label, with a file of another word, and a csv of yet another."""
    for file in ("1_walk/Walking (2).fbx", "flat@Waving.fbx", "b/2. Läufe/clip.fbx", "b/unlisted.fbx"):
        (tmp_path / "library" / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(shared_data / WALKING, tmp_path / "library" / file)
    (tmp_path / "labels.csv").write_text(
        "file,activity\n1_walk/Walking (2).fbx,stroll\nflat@Waving.fbx,wave\nclip.fbx,run\n", encoding="utf-8"
    )
    return tmp_path / "library"


@pytest.mark.parametrize("labels", [False, True])
def test_inspect_labels_every_clip_as_a_run_does(library, labels):
    csv = library.parent / "labels.csv" if labels else None
    found = read_library(library, csv)
    assert len(found.clips) == (3 if labels else 4)
    for clip in found.clips:
        assert label_said(clip.path, library, csv).startswith(f"A run labels it '{clip.activity}' after its ")
    if labels:
        code, output = inspect(library / "b/unlisted.fbx", "--library", library, "--labels", csv)
        assert code == 0
        assert "But a run on this library would skip it: labels.csv does not list it." in output


def test_inspect_takes_the_rate_of_the_labels(tmp_path, motions):
    path = next(motions.rglob("*.npz"))
    assert "at 25 frames/s" not in inspect(path)[1]
    (path.parent / "labels.csv").write_text(f"file,activity,rate\n{path.name},walk,25\n")
    assert "at 25 frames/s" in inspect(path)[1]
    csv = tmp_path / "others.csv"
    csv.write_text(f"file,activity,rate\n{path.name},walk,45\n")
    assert "at 45 frames/s" in inspect(path, "--labels", csv)[1]
    csv.write_text(f"file,activity,rate\n{path.name},walk,soon\n")
    code, output = inspect(path, "--labels", csv)
    assert (code, "line 2: the rate is 'soon'; it is in frames a second" in output) == (2, True)


def test_without_a_library_both_labels_are_said(library, monkeypatch):
    said = (
        "A run labels it '1_walk' after its folder, or 'walking' after its file name if that folder is "
        "itself the library (see --library)."
    )
    monkeypatch.chdir(library / "1_walk")
    code, output = inspect("Walking (2).fbx")
    assert code == 0
    assert said in output
    assert label_said(library / "1_walk/Walking (2).fbx", None, None) == said
    assert {clip.activity for clip in read_library(library).clips} >= {"1_walk"}
    assert [clip.activity for clip in read_library(library / "1_walk").clips] == ["walking"]


def test_a_file_outside_the_library_is_wrong_use(library, shared_data):
    code, output = inspect(shared_data / WALKING, "--library", library)
    assert code == 2
    assert "is not in the library" in output


def test_a_rate_that_is_taken_for_granted_is_said(shared_cases):
    glb = shared_cases / "rpm_no_skin_walk.glb"
    assert "rate taken for granted: glTF has times, no rate" in inspect(glb)[1]
    assert "taken for granted" not in inspect(glb, "--pose-rate", 30)[1]
