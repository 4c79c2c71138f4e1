# SPDX-License-Identifier: GPL-3.0-or-later
"""A run in a garment out of a .blend file leaves results that everything else reads like the skin's."""

import json
import shutil

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import JOINT_INDEX
from w2w.core.garments.cut import cut
from w2w.core.imu.presets import DEFAULT_SENSOR, preset
from w2w.core.imu.recording import ImuRecording
from w2w.core.study.results import StudyResults
from w2w.scene.base.body import add_body, add_skinned

from ...command_line import cli
from ...sensor_steps import assert_same_to_one_step

pytestmark = [pytest.mark.usefixtures("one_worker", "few_orders"), pytest.mark.slow]


@pytest.fixture(scope="module")
def library(tmp_path_factory, bundled_body):
    """Two motions of each of two activities, and a shirt that an armature moves in a .blend file."""
    folder = tmp_path_factory.mktemp("worn")
    time = np.arange(75) / 30
    for activity, joint in (("kick", "left_hip"), ("wave", "right_shoulder")):
        (folder / "clips" / activity).mkdir(parents=True)
        for number in range(2):
            angles = 0.8 * np.sin(2 * np.pi * (0.8 + 0.3 * number) * time)
            rotations = np.tile(np.eye(3), (75, 24, 1, 1))
            rotations[:, JOINT_INDEX[joint]] = Rotation.from_euler("x", angles[:, None]).as_matrix()
            motion = w2w.Motion(rotations, np.tile(bundled_body.joints[0], (75, 1)), 30.0)
            motion.save(folder / "clips" / activity / f"{activity}{number}.npz")
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    home = bpy.context.scene.collection
    objects = add_body(bundled_body, home)
    add_skinned(cut("tshirt", bundled_body).cloth, objects.armature, home, "Shirt")
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / "my.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    return folder


@pytest.fixture(scope="module")
def results(library):
    options = ("--patches", 24, "--window", 1, "--workers", 1, "--no-pictures", "--sensor", "ideal")
    for out, more in (("skin", ()), ("worn", ("--garment", f"{library}/my.blend:Shirt"))):
        code, output = cli("run", library / "clips", "--out", library / out, *options, *more)
        assert code == 0, output
    return library / "skin", library / "worn"


def test_signals_differ_where_the_garment_is_and_nowhere_else(results):
    skin, worn = results
    summary = json.loads((worn / "summary.json").read_text())
    ((name, content),) = summary["garments"].items()
    covered = np.array(content["patches"])
    assert name.endswith("my.blend:Shirt")
    (said,) = (each["text"] for each in summary["cautions"] if each["text"].startswith("Of 24 patches"))
    assert f"Of 24 patches {len(covered)} on {name}" in said
    assert "not yet been checked against worn garments" in said
    bare = np.setdiff1d(np.arange(24), covered)
    for clip in StudyResults.load(worn).clips:
        on_skin, on_cloth = (ImuRecording.load(out / "signals" / f"{clip.name}.npz") for out in (skin, worn))
        assert_same_to_one_step(on_cloth.at(bare), on_skin.at(bare), preset(DEFAULT_SENSOR))
        assert np.abs(on_cloth.acc[:, covered] - on_skin.acc[:, covered]).max() > 0.05


def test_everything_else_reads_the_results(results):
    _, worn = results
    assert cli("place", worn, "--forbid", "head")[0] == 0
    assert cli("tables", worn)[0] == 0
    assert cli("report", worn)[0] == 0
    study = StudyResults.load(worn)
    assert len(study.config().garments) == 1
    assert "my.blend:Shirt" in (worn / "report.html").read_text(encoding="utf-8")


def test_a_second_run_takes_up_the_first(library, results):
    _, worn = results
    before = (worn / "utility.npz").read_bytes()
    code, _ = cli(
        *("run", library / "clips", "--out", worn, "--patches", 24, "--window", 1, "--workers", 1),
        *("--no-pictures", "--sensor", "ideal", "--garment", f"{library}/my.blend:Shirt"),
    )
    assert code == 0
    assert (worn / "utility.npz").read_bytes() == before


def test_another_shirt_under_the_same_name_is_put_on(library, tmp_path):
    blend = shutil.copy(library / "my.blend", tmp_path)
    options = ("--patches", 12, "--window", 1, "--workers", 1, "--no-pictures", "--no-report")
    command = ("run", library / "clips", "--out", tmp_path / "out", *options, "--garment", f"{blend}:Shirt")
    assert cli(*command)[0] == 0
    signals = min((tmp_path / "out" / "signals").iterdir())
    before = signals.read_bytes()
    bpy.ops.wm.open_mainfile(filepath=str(blend))
    for vertex in bpy.data.objects["Shirt"].data.vertices:
        vertex.co.x *= 1.2
    bpy.ops.wm.save_mainfile()
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    code, output = cli(*command)
    assert code == 0, output
    assert "Nothing has changed" not in output
    assert signals.read_bytes() != before
    assert "Nothing has changed" in cli(*command)[1]


def test_what_cannot_be_worn_ends_the_run_with_a_sentence(library, tmp_path):
    own = f"{library}/my.blend:Coat"
    code, output = cli("run", library / "clips", "--out", tmp_path, "--patches", 12, "--garment", own)
    assert code == 1
    assert "holds no object 'Coat'; its objects are:" in output
    code, output = cli("run", library / "clips", "--out", tmp_path / "b", "--garment", "skirt")
    assert code == 2
    assert "there is no garment called 'skirt'" in output
