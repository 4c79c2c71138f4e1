# SPDX-License-Identifier: GPL-3.0-or-later
"""`import w2w`: what it costs, the motions it reads, and the examples of its documents."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.motion.motion import Motion
from w2w.core.reading import guard

from ..hostile_c3d import KINDS, plant, write_hostile
from ..made_door import ARM, LEG, moving

pytestmark = pytest.mark.usefixtures("few_orders")

ROOT = Path(__file__).resolve().parents[2]


def test_every_public_name_is_there():
    for name in w2w.__all__:
        assert getattr(w2w, name) is not None
    assert set(w2w.__all__) <= set(dir(w2w))
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = w2w.nothing


def test_the_version_is_the_extensions():
    manifest = (ROOT / "blender_manifest.toml").read_text(encoding="utf-8")
    assert f'\nversion = "{w2w.__version__}"' in manifest


def test_importing_it_imports_nothing_heavy():
    code = "import w2w, sys; assert not {'numpy', 'scipy', 'bpy', 'matplotlib', 'typer'} & sys.modules.keys()"
    done = subprocess.run(
        [sys.executable, "-c", code], env={"PYTHONPATH": str(ROOT / "blender_addon")}, check=False
    )
    assert done.returncode == 0


def test_a_motion_loads_what_it_saves(tmp_path):
    motion = moving(ARM, 1.0, 2).labelled("Größe messen", "person 7", "clip 3")
    motion.save(tmp_path / "one.npz")
    again = Motion.load(tmp_path / "one.npz")
    assert (again.activity, again.subject, again.clip) == ("Größe messen", "person 7", "clip 3")
    np.testing.assert_allclose(again.rotations, motion.rotations, atol=1e-12)
    np.testing.assert_allclose(again.pelvis, motion.pelvis, atol=1e-12)
    (loaded,) = w2w.load(tmp_path / "one.npz")
    assert loaded.activity == "Größe messen"


def test_a_lying_body_stays_down(tmp_path):
    """A body that lies along y is not taken for one that stands in a y-up world."""
    lying = moving(ARM, 1.0, 0)
    turns = lying.rotations.copy()
    turns[:, 0] = Rotation.from_rotvec([-np.pi / 2, 0.0, 0.0]).as_matrix()
    Motion(turns, lying.pelvis, 30.0).save(tmp_path / "lying.npz")
    np.testing.assert_allclose(Motion.load(tmp_path / "lying.npz").rotations, turns, atol=1e-12)


@pytest.mark.later
def test_files_that_kill_outlast_or_overfill_their_reader_are_skipped(tmp_path, monkeypatch):
    monkeypatch.setattr(guard, "LIMIT_S", 5.0)
    monkeypatch.setattr(guard, "MEMORY", 2**31)
    begun = plant(tmp_path / "planted", monkeypatch)
    files = write_hostile(tmp_path / "library" / "waving")
    moving(ARM, 1.0, 2).save(tmp_path / "library" / "waving" / "good.npz")
    motions = w2w.load(tmp_path / "library")
    assert begun.exists()
    assert [motion.clip for motion in motions] == ["waving_good"]
    assert {file for file, _ in motions.skipped} == {f"waving/{kind}.c3d" for kind in KINDS}
    assert dict(motions.skipped)["waving/hangs.c3d"].startswith("the program that reads it crashed, or took")
    with pytest.raises(ValueError, match="the program that reads it crashed"):
        w2w.load(files[0])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda folder: w2w.load(folder / "nowhere"), "is not a folder"),
        (lambda folder: Motion.load(folder / "text.npz"), "text.npz cannot be read as a motion"),
        (lambda folder: w2w.load(folder / "bad"), r"no motion in .*bad can be used; text\.npz: "),
        (lambda folder: w2w.open_results(folder), "is not the results folder of a finished run"),
    ],
)
def test_errors_are_sentences(tmp_path, call, sentence):
    (tmp_path / "bad").mkdir()
    for file in (tmp_path / "text.npz", tmp_path / "bad" / "text.npz"):
        file.write_text("no npz")
    with pytest.raises(ValueError, match=sentence):
        call(tmp_path)


def test_labels_of_one_file_are_refused(library):
    with pytest.raises(ValueError, match="give the folder"):
        w2w.load(library / "waving" / "waving 0.npz", labels=library.parent / "labels.csv")


def test_a_rate_in_the_labels_goes_before_all_others(tmp_path):
    turns = np.zeros((90, 72))
    turns[:, 48] = np.sin(np.arange(90) / 5)
    for name, rate in (("right", 30.0), ("wrong", 1.0), ("none", 0.0)):
        facts = {"mocap_framerate": rate} if rate else {}
        np.savez(tmp_path / f"{name}.npz", poses=turns, trans=np.zeros((90, 3)), **facts)
    reasons = dict(w2w.load(tmp_path).skipped)
    assert reasons["wrong.npz"].startswith(
        "it says 1 frames a second; motions have 5 to 2,000: give the true"
    )
    (tmp_path / "labels.csv").write_text(
        "file,activity,rate\nright.npz,wave,\nwrong.npz,wave,60\nnone.npz,wave,25\n"
    )
    rates = {motion.clip: motion.rate for motion in w2w.load(tmp_path)}
    assert rates == {"right": 30, "wrong": 60, "none": 25}
    rates = {motion.clip: motion.rate for motion in w2w.load(tmp_path, pose=w2w.PoseFacts(rate=10))}
    assert rates == {"right": 10, "wrong": 60, "none": 25}


@pytest.mark.slow
def test_beside_a_clone_the_package_is_found(tmp_path):
    """And not the folder, whose own `__init__.py` is the extension's door."""
    (tmp_path / "w2w").symlink_to(ROOT, target_is_directory=True)
    code = "import w2w; from w2w.api.loading import load; assert load is w2w.load; w2w.Body.bundled()"
    run = [sys.executable, "-c", code]
    done = subprocess.run(run, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def run_without_blender(folder, code, *arguments):
    """What Python does in a process whose `bpy` cannot be imported."""
    (folder / "bpy.py").write_text("raise ModuleNotFoundError(\"No module named 'bpy'\", name='bpy')\n")
    return subprocess.run(
        [sys.executable, "-c", code, *arguments], cwd=folder, capture_output=True, text=True, check=True,
        env={"PYTHONPATH": f"{folder}:{ROOT / 'blender_addon'}"},
    )  # fmt: skip


def test_fbx_comes_in_through_blender(shared_data):
    pytest.importorskip("bpy")
    (motion,) = w2w.load(shared_data / "mixamo" / "Conv-AI__ThreeJs-World-Tutorial" / "TalkingMale.fbx")
    assert (motion.clip, motion.n_frames) == ("TalkingMale", 298)


@pytest.mark.slow
def test_bvh_comes_in_without_blender_and_for_fbx_a_sentence_says_how_to_get_it(shared_data, tmp_path):
    folder = shared_data / "bvh" / "cmu_DragonForged"
    (tmp_path / "walk.fbx").write_text("; FBX 7.3.0 project file\n")
    code = (
        "import sys, w2w\ntry: w2w.load('walk.fbx')\nexcept ValueError as error: said = error\n"
        "for m in w2w.load(sys.argv[1]): print(m.clip, m.n_frames)\nprint(said)"
    )
    *bvh, said = run_without_blender(tmp_path, code, str(folder)).stdout.splitlines()
    assert bvh == ["002_03 86", "007_12 131"]
    assert "walk.fbx is read through Blender's Python module, which is missing" in said
    assert "pip install '.[blender]'" in said


@pytest.mark.slow
def test_the_documents_examples_run(library, monkeypatch):
    monkeypatch.chdir(library.parent)
    text = (ROOT / "docs" / "python.md").read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 13
    names: dict = {}
    own = re.findall(r"```python\n(.*?)```", (ROOT / "docs" / "own_sensors.md").read_text("utf-8"), re.DOTALL)
    for block in [*own, *blocks]:
        exec(compile(block, "docs/python.md", "exec"), names)
    assert (library.parent / "best.png").stat().st_size > 10_000
    head = "patch,name,region,expected_mean,expected_low,expected_high,kicking,stirring,waving,mean,"
    assert (library.parent / "f1.csv").read_text().startswith(head)
    assert names["ranking"].utility.mean.shape == (24,)


def test_labels_of_several_spellings_are_one_with_a_warning(few):
    made = [moving(ARM, 1.5, 0), moving(ARM, 0.7, 1), moving(LEG, 1.0, 2), moving(LEG, 1.6, 3)]
    labels = [("Walk", "Anna"), ("walk", "bob"), ("run", "ANNA"), ("Run", "Bob")]
    motions = [one.labelled(*label, f"{label}") for one, label in zip(made, labels, strict=True)]
    with pytest.warns(
        UserWarning, match="'run' and 'Run' count as one activity, 'run'; .* one subject, 'ANNA'"
    ):
        ranking = w2w.rank(w2w.synthesize(motions, few, sensor="ideal"), by_subject=True)
    assert ranking.utility.activities == ("run", "walk")
    assert ranking.utility.protocol == "leave one of 2 subjects out"


def test_arrays_give_the_motion_of_their_file(tmp_path):
    poses = np.zeros((60, 72))
    poses[:, 48] = np.sin(np.arange(60) / 5)
    np.savez(tmp_path / "wave.npz", poses=poses, trans=np.zeros((60, 3)), mocap_framerate=30.0)
    read = w2w.load(tmp_path / "wave.npz", pose=w2w.PoseFacts(up="y"))[0]
    made = w2w.from_smpl(poses, np.zeros((60, 3)), 30, "y")
    np.testing.assert_array_equal(made.rotations, read.rotations)
    np.testing.assert_array_equal(made.pelvis, read.pelvis)
    assert made.labelled("waving", "Ada", "one").clip == "one"

    joints = w2w.Body.bundled().joints + 0.02 * np.sin(np.arange(60) / 5)[:, None, None]
    np.save(tmp_path / "sway.npy", joints)
    facts = w2w.PoseFacts(rate=30, up="z")
    read = w2w.load(tmp_path / "sway.npy", pose=facts)[0]
    np.testing.assert_array_equal(w2w.from_joints(joints, facts).rotations, read.rotations)
    both = np.stack([np.where(np.arange(60)[:, None, None] < 20, np.nan, joints), joints])
    np.testing.assert_array_equal(w2w.from_joints(both, facts).rotations, read.rotations)


@pytest.mark.parametrize(
    ("make", "why"),
    [
        (lambda: w2w.from_joints(np.zeros((60, 24, 3)), {"rate": 30}), "must be PoseFacts"),
        (lambda: w2w.from_joints(np.zeros((60, 24, 3)), w2w.PoseFacts()), r"give pose=PoseFacts\(rate="),
        (lambda: w2w.from_joints(np.zeros((60, 24)), w2w.PoseFacts(rate=30)), "8 joints, and no joint set"),
        (lambda: w2w.from_joints(np.zeros((60, 23, 3)), w2w.PoseFacts(rate=30)), "23 joints"),
        (lambda: w2w.from_smpl(np.zeros((60, 70)), np.zeros((60, 3)), 30), "70"),
        (lambda: w2w.from_smpl(np.zeros((60, 72)), np.zeros((50, 3)), 30), "60 frames but"),
        (lambda: w2w.from_smpl("poses.npz", np.zeros((60, 3)), 30), "poses must be an array of numbers"),
    ],
)
def test_arrays_that_are_no_motion_are_refused(make, why):
    with pytest.raises(ValueError, match=why) as told:
        make()
    assert "--" not in str(told.value)
