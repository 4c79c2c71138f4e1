# SPDX-License-Identifier: GPL-3.0-or-later
"""Joint positions from video go the whole road: inspected, run, loaded from Python."""

import gzip
import json
import os
from dataclasses import replace

import numpy as np
import pytest

import w2w
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.motion.motion import Motion, read_amass
from w2w.core.motion.skinning import on_the_ground
from w2w_studies.datasets.utd_mhad import UTD_ACTIONS, read_utd_mhad

from ..clip_lists import skipped_clips, used_clips
from ..command_line import cli
from ..rings import by_day
from ..seen_joints import seen_as

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

ACTIONS = ("wave", "walk")


@pytest.fixture(scope="module")
def kinect(shared_data, tmp_path_factory):
    """Real Kinect skeletons of two actions as npy files, and two files that cannot be used."""
    folder = tmp_path_factory.mktemp("kinect")
    counts = dict.fromkeys(ACTIONS, 0)
    for trial in read_utd_mhad(shared_data / "imu/utd_mhad/utd_mhad_subjects_1_4.npz"):
        action = trial.recording.activity
        if counts.get(action, 9) < 3:
            (folder / action).mkdir(exist_ok=True)
            np.save(folder / action / f"{counts[action]}.npy", trial.skeleton)
            counts[action] += 1
    assert set(counts) <= set(UTD_ACTIONS)
    np.save(folder / "walk" / "flat.npy", np.zeros((30, 20, 2)))
    (folder / "walk" / "broken.npy").write_text("no array")
    (folder / "walk" / "notes.csv").write_text("file,activity\nx,y\n")
    (folder / "walk" / "settings.json").write_text('{"name": 1}')
    return folder


@pytest.mark.slow
def test_kinect_skeletons_are_a_library(kinect, tmp_path):
    options = ("--patches", 8, "--folds", 3, "--no-pictures", "--no-report", "--workers", 1, "--window", 1)
    code, output = cli(
        "run", kinect, "--out", tmp_path / "out", *options, "--pose-rate", 30, "--pose-unit", "m"
    )
    assert code == 0, output
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["clips"]["found"], summary["clips"]["used"]) == (8, 6)
    assert {entry["skeleton"] for entry in used_clips(tmp_path / "out")} == {"Kinect, 20 joints"}
    reasons = skipped_clips(tmp_path / "out")
    assert "positions in the picture (2D)" in reasons["walk/flat.npy"]
    assert "damaged or no npy file" in reasons["walk/broken.npy"]
    walk = Motion.load(tmp_path / "out" / "motions" / "walk_0.npz")
    assert walk.rate == 30
    before = (tmp_path / "out" / "signals" / "walk_0.npz").stat().st_mtime_ns
    (kinect / "walk" / "0.json").write_text('{"rate": 60}')  # the options come before a side-car...
    code, output = cli(
        "run", kinect, "--out", tmp_path / "out", *options, "--pose-rate", 30, "--pose-unit", "m"
    )
    assert code == 0, output
    (kinect / "walk" / "0.json").unlink()
    after = (tmp_path / "out" / "signals" / "walk_0.npz").stat().st_mtime_ns
    assert after > before  # ... but the clip is read again, for it might have said more
    code, output = cli("run", kinect, "--out", tmp_path / "other", *options)
    assert code == 1
    assert "does not say its frame rate: give --pose-rate" in output


def test_inspect_names_the_joints_and_what_cannot_be_seen(kinect):
    code, output = cli("inspect", kinect / "wave" / "0.npy", "--pose-rate", 30, "--pose-unit", "m")
    assert code == 0, output
    assert "joints Kinect, 20 joints" in output
    assert "up y, 1 file of joints (Kinect, 20 joints)" in output
    assert "turns of the forearms about their own axis" in output
    assert "m tall" in output
    code, output = cli("inspect", kinect / "wave" / "0.npy")
    assert (code, "does not say its frame rate" in output) == (1, True)
    code, output = cli("inspect", kinect / "wave" / "0.npy", "--pose-unit", "furlong")
    assert (code, "the pose's unit must be one of m, cm" in output) == (2, True)
    code, output = cli("inspect", kinect / "wave" / "0.npy", "--pose-rate", 30, "--pose-unit", "mm")
    assert (code, "m tall: correct its unit" in output) == (1, True)


KINDS = ["fbx", "bvh", "bvh without a rate", "mvnx", "smpl", "amass", "no rate", "glb", "joints"]


@pytest.mark.parametrize("kind", by_day(set(KINDS) - {"glb", "mvnx"}, KINDS))
def test_a_rate_that_is_given_holds_whatever_the_file_says(
    shared_data, shared_cases, bundled_body, tmp_path, kind
):
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    bvh = shared_cases / "tpose_at_end.bvh"
    frames = {}
    if kind == "bvh without a rate":
        text = bvh.read_text().replace("Frame Time: ", "Frame Time: -")
        bvh = tmp_path / "a.bvh"
        bvh.write_text(text)
    elif kind == "mvnx":
        packed = (shared_data / "mvnx/kicking-003.mvnx.gz").read_bytes()
        (tmp_path / "a.mvnx").write_bytes(gzip.decompress(packed))
    elif kind == "glb":
        bpy = pytest.importorskip("bpy")
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        bpy.ops.import_scene.fbx(filepath=str(fbx))
        bpy.ops.export_scene.gltf(filepath=str(tmp_path / "a.glb"))
        bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
        frames = {"n_frames": w2w.load(fbx)[0].n_frames}
    elif kind == "joints":
        motion = read_amass(shared_cases / "trans_in_cm.npz")
        motion = replace(motion, pelvis=motion.pelvis / 100)
        positions = seen_as(JOINT_SETS["coco-17"], bundled_body, motion)
        np.savez(tmp_path / "a.npz", joints=positions, fps=120.0, up="z")
    path = {
        "fbx": fbx,
        "bvh": bvh,
        "bvh without a rate": bvh,
        "smpl": shared_cases / "lying_yup.smpl",
        "amass": shared_cases / "lying_zup.npz",
        "no rate": shared_cases / "gvhmr_no_rate.npz",
        "joints": tmp_path / "a.npz",
    }.get(kind, tmp_path / f"a.{kind}")
    code, output = cli("inspect", path, "--pose-rate", 37)
    assert (code, "at 37 frames/s" in output) == (0, True), output
    motion = w2w.load(path, pose=w2w.PoseFacts(rate=37.0))[0]
    assert motion.rate == 37
    assert motion.n_frames == frames.get("n_frames", motion.n_frames)


def test_a_pipe_named_like_text_is_never_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.csv")
    os.mkfifo(tmp_path / "b.npz")
    code, output = cli("inspect", tmp_path / "b.npz")
    assert (code, "a named pipe" in output) == (1, True)
    code, output = cli("inspect", tmp_path / "a.csv")
    assert (code, "a named pipe" in output) == (1, True)
    code, output = cli("run", tmp_path, "--out", tmp_path.parent / "out")
    assert code in (1, 2), output


def test_python_loads_them(shared_data, bundled_body, tmp_path):
    motion = on_the_ground(
        bundled_body, read_amass(shared_data / "smpl_poses/nghorbani__amass/amass_sample.npz")
    )
    joint_set = JOINT_SETS["humanml3d-22"]
    np.save(tmp_path / "walk.npy", seen_as(joint_set, bundled_body, motion)[:200])
    motions = w2w.load(tmp_path / "walk.npy", pose=w2w.PoseFacts(rate=motion.rate, up="z"))
    assert motions[0].n_frames == 200
    assert motions[0].clip == "walk"
    with pytest.raises(ValueError, match="does not say its frame rate"):
        w2w.load(tmp_path / "walk.npy")
