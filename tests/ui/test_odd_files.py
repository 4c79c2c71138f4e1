# SPDX-License-Identifier: GPL-3.0-or-later
"""Links, pipes, devices and names of any bytes through the panel's import: none hangs Blender."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import bpy
import pytest

from w2w.ui.jobs import jobs

pytestmark = [
    pytest.mark.usefixtures("blender"),
    pytest.mark.skipif(os.name == "nt", reason="Windows has no such files and names"),
]

PROBLEMS = {
    "loop.fbx": "it is a symbolic link that leads back to itself",
    "endless.bvh": "it is a link to a device, not a file",
    "pipe.npz": "it is a named pipe, not a file",
}


def test_a_folder_of_them_is_imported_and_says_why_not(library: Path, tmp_path: Path) -> None:
    folder = tmp_path / "library"
    shutil.copytree(library / "waving", folder / os.fsdecode(b"gr\xfc\xdfen"))
    moved = next((folder / os.fsdecode(b"gr\xfc\xdfen")).iterdir())
    moved.rename(moved.with_name(os.fsdecode(b"\xe9.npz")))
    (folder / os.fsdecode(b"\xe9.fbx")).touch()
    (folder / "loop.fbx").symlink_to("loop.fbx")
    (folder / "endless.bvh").symlink_to("/dev/zero")
    os.mkfifo(folder / "pipe.npz")
    assert bpy.ops.w2w.add_body() == {"FINISHED"}
    body = bpy.context.scene.w2w.body
    assert bpy.ops.w2w.import_folder(directory=str(folder)) == {"FINISHED"}
    clips = {clip.name: clip for clip in body.w2w.clips}
    assert {name: clips[name].problem for name in PROBLEMS} == PROBLEMS
    assert clips["%E9.fbx"].problem == "the file is empty (0 bytes)"
    used = [clip for clip in body.w2w.clips if not clip.problem]
    assert [clip.activity for clip in used] == ["gr%fc%dfen"] * 3
    assert all(Path(clip.file).is_file() for clip in used)
    assert "4 files cannot be used" in jobs.message.text
