# SPDX-License-Identifier: GPL-3.0-or-later
"""Bone maps of the user's own: edited at a clip, given as a file, used from then on."""

from __future__ import annotations

import json
import re
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.body.body import JOINT_NAMES
from w2w.core.files import file_sha256
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.bone_maps import BoneMap
from w2w.core.retargeting.retarget import matched_joints
from w2w.scene.base.actions import read_action
from w2w.scene.base.body import armature_of
from w2w.ui.jobs import jobs
from w2w.ui.steps.motion_import import map_folder, saved_maps

pytestmark = pytest.mark.usefixtures("blender")


@pytest.fixture(scope="module")
def plain(shared_data: Path) -> Path:
    """A real BVH whose bones the bundled maps know."""
    return sorted((shared_data / "bvh").rglob("*.bvh"))[0]


@pytest.fixture
def odd(plain: Path, tmp_path: Path) -> Path:
    """The same motion, its joints named by number, in a chain that says nothing of arms and legs."""
    names = iter(range(1000))
    path = tmp_path / "odd" / "odd.bvh"
    path.parent.mkdir()
    path.write_text(re.sub(r"(ROOT|JOINT) \S+", lambda m: f"{m[1]} n{next(names):03d}", plain.read_text()))
    return path


def joints_of(path: Path) -> list[str]:
    return re.findall(r"(?:ROOT|JOINT) (\S+)", path.read_text())


def named(plain: Path, odd: Path) -> dict[str, str]:
    """Joint of the body to bone of the odd file, by the known one."""
    bpy.ops.w2w.import_motions(directory=str(plain.parent), files=[{"name": plain.name}])
    other = dict(zip(joints_of(plain), joints_of(odd), strict=True))
    return {joint: other[bone] for joint, bone in matched(plain).items()}


def matched(path: Path) -> dict[str, str]:
    """Joint of the body to bone of a file."""
    source = read_bvh(path)
    return {JOINT_NAMES[joint]: source.bones[bone] for joint, bone in matched_joints(source)[1].items()}


def map_bones(rig: str, joints: dict[str, str]) -> set[str]:
    rows = [{"name": joint, "bone": bone} for joint, bone in joints.items()]
    return bpy.ops.w2w.map_bones(rig=rig, joints=rows)


def motion_of(number: int) -> np.ndarray:
    body = bpy.context.scene.w2w.body
    return read_action(armature_of(body), body.w2w.clips[number].action).rotations


@pytest.mark.slow
def test_a_map_given_at_a_clip_reads_it_and_the_next_file_of_the_rig(plain: Path, odd: Path) -> None:
    bpy.ops.w2w.add_body()
    study = bpy.context.scene.w2w.body.w2w
    joints = named(plain, odd)
    bpy.ops.w2w.import_motions(directory=str(odd.parent), files=[{"name": odd.name}])
    study.clip_index = 1
    actions = len(bpy.data.actions)
    assert map_bones("by number", joints) == {"FINISHED"}
    assert len(bpy.data.actions) <= actions + 1
    assert study.clips[1].skeleton == "by number"
    assert study.clips[1].source_sha256 == file_sha256(odd)
    np.testing.assert_allclose(motion_of(1), motion_of(0), atol=1e-5)
    bpy.ops.w2w.import_motions(directory=str(odd.parent), files=[{"name": odd.name}])
    assert study.clips[2].skeleton == "by number"
    np.testing.assert_array_equal(motion_of(2), motion_of(1))
    assert [found.name for found in saved_maps()] == ["by number"]


def test_a_map_without_a_needed_joint_is_refused_and_not_kept(plain: Path) -> None:
    bpy.ops.w2w.add_body()
    bpy.ops.w2w.import_motions(directory=str(plain.parent), files=[{"name": plain.name}])
    joints = matched(plain)
    del joints["left_knee"]
    with pytest.raises(RuntimeError, match="left knee"):
        map_bones("half", joints)
    assert not saved_maps()


def test_a_damaged_map_is_named(plain: Path) -> None:
    bpy.ops.w2w.add_body()
    (map_folder() / "broken.json").write_text("{}")
    with pytest.raises(RuntimeError, match=r"broken\.json is not a bone map"):
        bpy.ops.w2w.import_motions(directory=str(plain.parent), files=[{"name": plain.name}])


def test_a_map_from_a_file_is_kept_and_a_damaged_one_is_not(plain: Path, tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"name": "../mine", "joints": {j: [b] for j, b in matched(plain).items()}}))
    assert bpy.ops.w2w.load_bone_map(filepath=str(path)) == {"FINISHED"}
    assert [item.parent for item in map_folder().iterdir()] == [map_folder()]
    assert saved_maps() == [BoneMap.load(path)]
    kept = next(map_folder().iterdir())
    assert bpy.ops.w2w.load_bone_map(filepath=str(kept)) == {"FINISHED"}  # the kept one itself
    assert saved_maps() == [BoneMap.load(path)]
    path.write_text("{}")
    with pytest.raises(RuntimeError, match="not a bone map"):
        bpy.ops.w2w.load_bone_map(filepath=str(path))
    assert jobs.message.is_error
