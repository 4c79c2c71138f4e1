# SPDX-License-Identifier: GPL-3.0-or-later
"""glTF: a whole file of version 2 comes back as the FBX it was made of; others are refused in a sentence."""

import json
import struct

import numpy as np
import pytest

import w2w
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.import_checks import check_gltf

WHOLE = {
    "asset": {"version": "2.0"}, "animations": [{}], "skins": [{}], "buffers": [{"uri": "data:;base64,AA=="}],
}  # fmt: skip


def glb(content, version=2, length=None, kind=0x4E4F534A):
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    length = 20 + len(text) if length is None else length
    return b"glTF" + struct.pack("<IIII", version, length, len(text), kind) + text


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.glb", glb(WHOLE), ""),
        ("a.gltf", json.dumps(WHOLE).encode(), ""),
        ("a.glb", glb(WHOLE, version=1), "glTF of version 1"),
        ("a.glb", glb(WHOLE, length=10**6), "it is cut short"),
        ("a.glb", glb(WHOLE)[:60], "it is cut short"),
        ("a.glb", glb(WHOLE)[:9], "it ends in its header"),
        ("a.glb", b"nothing of the kind", "it does not begin as one"),
        ("a.glb", glb(WHOLE, kind=7), "it is cut short"),
        ("a.gltf", b"{", "it is damaged or no glTF file"),
        ("a.gltf", b"[" * 100_000, "it is damaged or no glTF file"),
        ("a.gltf", b"[]", "it names no asset"),
        ("a.gltf", json.dumps(WHOLE | {"asset": {"version": "1.0"}}).encode(), "glTF of version 1.0"),
        (
            "a.gltf",
            json.dumps(WHOLE | {"buffers": [{"uri": "../b.bin"}]}).encode(),
            "its buffers lie in other",
        ),
        ("a.glb", glb(WHOLE | {"images": [{"uri": "/dev/zero"}]}), "its images lie in other files"),
        ("a.gltf", json.dumps(WHOLE | {"animations": []}).encode(), "it holds no animation"),
        ("a.gltf", json.dumps(WHOLE | {"skins": 3}).encode(), "its skins are no list"),
        ("a.gltf", json.dumps(WHOLE | {"skins": []}).encode(), "it holds no skeleton"),
        ("a.glb", b"", "empty"),
    ],
)
def test_only_a_whole_file_of_version_two_is_imported(tmp_path, name, data, message):
    (tmp_path / name).write_bytes(data)
    if not message:
        check_gltf(tmp_path / name)
        return
    with pytest.raises(UnusableMotion) as caught:
        check_gltf(tmp_path / name)
    assert message in str(caught.value)


@pytest.mark.later
def test_a_motion_comes_back_as_the_fbx_it_was_made_of(shared_data, bundled_body, tmp_path):
    bpy = pytest.importorskip("bpy")
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "run.glb"))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    expected, found = w2w.load(fbx)[0], w2w.load(tmp_path / "run.glb")[0]
    assert found.rate == 60
    assert found.duration == pytest.approx(expected.duration, abs=1 / 30)
    assert len(bpy.data.objects) == 0
    step = round(found.rate / expected.rate)
    n_frames = min(expected.n_frames, len(found.rotations[::step]))
    a, b = (joint_transforms(bundled_body, motion)[0] for motion in (expected, found))
    np.testing.assert_allclose(a[:n_frames], b[::step][:n_frames], atol=0.02)
    (tmp_path / "cut.glb").write_bytes((tmp_path / "run.glb").read_bytes()[:5000])
    with pytest.raises(ValueError, match="cut short"):
        w2w.load(tmp_path / "cut.glb")
