# SPDX-License-Identifier: GPL-3.0-or-later
"""FBX files that Blender's importers refuse: a true sentence for each, old ones not called damaged."""

import struct
from functools import partial

import bpy
import numpy as np
import pytest

from w2w.core.body.body import Y_UP_TO_Z_UP
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.library.library import Clip
from w2w.core.motion.sight import TO_Z, UPS
from w2w.core.motion.source import UnusableMotion
from w2w.core.reading import formats
from w2w.headless.runs.clip import load_clip
from w2w.scene.motion.importers import SAVE_ANEW, check_fbx, fbx_up, import_fault
from w2w.scene.motion.load import read_by_blender
from w2w.scene.motion.takes import read_clip

read_motion = partial(formats.read_motion, blender=read_by_blender)

WALKING = "mixamo/Conqster__TheBarMan/Walking.fbx"
TEXT_OF_2010 = "mixamo/Uncleared__RootMotionNavMesh/Soccer Kick.fbx"
"""A real file of FBX 6.1, in text form."""

needs_cpp_importer = pytest.mark.skipif(
    "fbx_import" not in dir(bpy.ops.wm), reason="this Blender has only the Python importer"
)


@pytest.fixture(autouse=True)
def empty_scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def of_version(source, target, version):
    data = bytearray(source.read_bytes())
    struct.pack_into("<I", data, 23, version)
    target.write_bytes(data)
    return target


def reason(path, **options):
    with pytest.raises(UnusableMotion) as said:
        check_fbx(path, **options)
    return str(said.value)


@needs_cpp_importer
def test_fbx_6_1_is_read_where_blender_reads_it(shared_data):
    assert read_clip(shared_data / TEXT_OF_2010).n_frames == 73


def test_the_axis_that_is_up_is_counted_as_the_file_s_header_does(shared_data, tmp_path):
    walking = (shared_data / WALKING).read_bytes()
    number = walking.index(b"UpAxisS") + len(b"UpAxisS\x03\0\0\0intS\x07\0\0\0IntegerS\0\0\0\0I")
    for axis, name in enumerate("xyz"):
        (tmp_path / "a.fbx").write_bytes(walking[:number] + bytes([axis]) + walking[number + 1 :])
        assert fbx_up(tmp_path / "a.fbx") == name
    assert fbx_up(shared_data / TEXT_OF_2010) == "y"
    (tmp_path / "a.fbx").write_text('Property: "UpAxis", "int", "",2\nProperty: "UpAxisSign", "int", "",1\n')
    assert fbx_up(tmp_path / "a.fbx") == "z"


def test_all_six_axes_can_be_given_for_fbx(shared_data):
    as_it_is = read_motion(shared_data / WALKING).matrices[:, :, :3, 3]
    for up in UPS:
        found = read_motion(shared_data / WALKING, PoseFacts(up=up)).matrices[:, :, :3, 3]
        np.testing.assert_allclose(found, as_it_is @ Y_UP_TO_Z_UP @ TO_Z[up].T, atol=1e-9, err_msg=up)


def test_the_python_importer_reads_no_text_and_nothing_before_2011(shared_data, tmp_path):
    assert reason(shared_data / TEXT_OF_2010, python_importer=True) == (
        f"it is an FBX of version 6.1 in text form, which Blender reads from 4.5 on: {SAVE_ANEW}"
    )
    old = of_version(shared_data / WALKING, tmp_path / "old.fbx", 6100)
    assert reason(old, python_importer=True) == (
        f"it is an FBX of version 6.1, which Blender reads from 4.5 on: {SAVE_ANEW}"
    )
    check_fbx(shared_data / WALKING, python_importer=True)


@needs_cpp_importer
def test_an_old_file_that_cannot_be_read_is_called_old(shared_data, tmp_path):
    old = of_version(shared_data / WALKING, tmp_path / "old.fbx", 6100)
    with pytest.raises(UnusableMotion) as said:
        read_clip(old)
    assert str(said.value) == (
        "Blender cannot import it: it is an FBX of version 6.1, from before 2011, or it is damaged; if it "
        f"opens elsewhere, {SAVE_ANEW}"
    )


@pytest.mark.parametrize(("version", "spoken"), [(0, "0.0"), (2500, "2.5")])
def test_a_version_that_no_importer_reads(shared_data, tmp_path, version, spoken):
    old = of_version(shared_data / WALKING, tmp_path / "old.fbx", version)
    assert reason(old).startswith(f"its header says FBX version {spoken}, and Blender reads 3.0 and later")


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ("Error: FBX Import: Cannot import file '{}': 'Truncated file'\n", "it is cut short, or a record"),
        ("Error: FBX Import: Cannot import file '{}': 'Failed to load'\n", "it is damaged"),
        ("Error: FBX Import: Cannot import file '{}': 'Bad DEFLATE data'\n", "a packed part of it cannot"),
        ("Error: Couldn't open file '{}' (failed to read complete nested block, expected 9)", "cut short"),
        ("Error: Python: Traceback ...\nKeyError: b'Vertices'\nLocation: import_fbx.py:1\n", "it is damaged"),
        ("Error: Out of memory", "it unpacks to more than fits in memory"),
        ("", "it is damaged"),
    ],
)
def test_what_importers_say_becomes_a_sentence(shared_data, tmp_path, said, told):
    path = tmp_path / "memory games.fbx"  # a name that says what importers say
    path.write_bytes((shared_data / WALKING).read_bytes())
    fault = import_fault(path, RuntimeError(said.format(path)))
    assert fault.startswith("Blender cannot import it: ")
    assert told in fault
    assert "b'" not in fault


@needs_cpp_importer
def test_a_leading_t_pose_is_dropped_as_from_bvh(shared_cases, bundled_body):
    file = "cmu_07_01.fbx"
    _, motion, details = load_clip(Clip(shared_cases / file, file, "walk", "walking"), bundled_body)
    assert motion.n_frames == 316
    assert details["cut"] == "frame 0 cut off: a rest pose"
