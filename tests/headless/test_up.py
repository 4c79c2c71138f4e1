# SPDX-License-Identifier: GPL-3.0-or-later
"""A run says which axis is up, keeps to one, and refuses people who hang head down."""

import json
from dataclasses import replace

import numpy as np
import pytest

from w2w.core.library.library import Clip
from w2w.core.motion.motion import LABELS, Motion
from w2w.core.motion.up import Ups
from w2w.core.study.config import StudyConfig
from w2w.headless.runs.clip_task import ClipTask, Engine

from ..command_line import cli

pytestmark = pytest.mark.usefixtures("one_worker", "few_orders")

OPTIONS = (
    "--patches",
    "8",
    "--folds",
    "2",
    "--no-pictures",
    "--no-report",
    "--workers",
    "1",
    "--window",
    "1",
)


def rewrite(path, flip):
    """A motion's file without W2W's labels, head down if so wished."""
    motion = Motion.load(path)
    rotations = motion.rotations.copy()
    if flip:
        rotations[:, 0] = np.diag([1.0, -1.0, -1.0]) @ rotations[:, 0]
    replace(motion, rotations=rotations).save(path)
    with np.load(path) as data:
        arrays = {name: data[name] for name in data.files if name not in LABELS}
    with path.open("wb") as stream:
        np.savez(stream, **arrays)


@pytest.mark.slow
def test_a_library_head_down_is_refused_and_turned_when_told(motions, tmp_path):
    files = sorted(motions.rglob("*.npz"))
    for number, path in enumerate(files):
        rewrite(path, flip=number % 4 < 3)
    code, output = cli("run", motions, "--out", tmp_path / "out", *OPTIONS)
    assert code == 1
    assert "people may stand along -z in 6, z in 2: give --pose-up" in output
    assert not (tmp_path / "out").exists()  # before any signals
    code, output = cli("run", motions, "--out", tmp_path / "out", *OPTIONS, "--pose-up", "-z")
    assert code == 0, output
    turned = [Motion.load(path) for path in sorted((tmp_path / "out" / "motions").glob("*.npz"))]
    assert [motion.head_down for motion in turned] == [number % 4 == 3 for number in range(8)]
    before = (tmp_path / "out" / "utility.csv").read_bytes()
    code, output = cli("run", motions, "--out", tmp_path / "out", *OPTIONS, "--pose-up", "x")
    assert code == 0, output
    assert "Nothing has changed" not in output
    assert (tmp_path / "out" / "utility.csv").read_bytes() != before


@pytest.mark.slow
def test_a_few_clips_head_down_are_motions(motions, tmp_path):
    for number, path in enumerate(sorted(motions.rglob("*.npz"))):
        rewrite(path, flip=number == 1)
    code, output = cli("run", motions, "--out", tmp_path / "out", *OPTIONS)
    assert code == 0, output
    assert json.loads((tmp_path / "out" / "summary.json").read_text())["clips"]["used"] == 8


def test_inspect_says_what_is_up(motions):
    upside, other = sorted(motions.rglob("*.npz"))[:2]
    for path in motions.rglob("*.npz"):
        rewrite(path, flip=path == upside)
    assert cli("inspect", upside)[0] == 1
    assert "may stand along -z: give --pose-up" in cli("inspect", upside)[1]
    code, output = cli("inspect", upside, "--pose-up", "-z")
    assert (code, "up -z, as given" in output) == (0, True)
    assert "up z, 1 file of AMASS" in cli("inspect", other)[1]
    code, output = cli("inspect", upside, "--library", motions)
    assert (code, "up z, 8 files of AMASS" in output) == (0, True)


@pytest.mark.parametrize(
    ("file", "differs"), [("a.npz", True), ("a.npy", True), ("a.bvh", True), ("a.fbx", False)]
)
def test_a_library_s_axis_is_in_the_key_of_clips_that_it_is_for(tmp_path, file, differs):
    clip = Clip(tmp_path / file, file, name="a", activity="walk")
    task = ClipTask(clip, tmp_path, StudyConfig(), "inputs")
    other = replace(task, engine=Engine(ups=Ups((("AMASS", "y"),))))
    assert (other.key("0") != task.key("0")) is differs
