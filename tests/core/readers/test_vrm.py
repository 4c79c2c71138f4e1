# SPDX-License-Identifier: GPL-3.0-or-later
"""VRM: bones are known by what the file says of them, whatever its nodes are called; with a skin or not."""

import json
import struct

import numpy as np
import pytest

import w2w
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.import_checks import with_skin
from w2w.core.retargeting.bone_maps import BONE_MAPS

from ...rings import by_day

NODES = [
    {"name": "root", "children": [1]},
    {"name": "b1", "children": [2]},
    {"name": "twist", "children": [3]},
    {},
]
BONES = {"hips": 1, "spine": 3}
HUMAN = {bone: {"node": node} for bone, node in BONES.items()}
FORMS = {
    "VRMC_vrm": HUMAN,
    "VRMC_vrm_animation": HUMAN,
    "VRM": [{"bone": bone, "node": node} for bone, node in BONES.items()],
}


def glb(content, binary=b""):
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    total = 20 + len(text) + len(binary)
    return b"glTF" + struct.pack("<IIII", 2, total, len(text), 0x4E4F534A) + text + binary


def parts(data):
    length = struct.unpack_from("<I", data, 12)[0]
    return json.loads(data[20 : 20 + length]), data[20 + length :]


@pytest.mark.parametrize("name", FORMS)
def test_nodes_get_the_names_of_the_bones_that_they_are(tmp_path, name):
    path = tmp_path / "a.vrm"
    content = {"nodes": NODES, "extensions": {name: {"humanoid": {"humanBones": FORMS[name]}}}}
    path.write_bytes(glb(content, b"binary chunk"))
    found, rest = parts(with_skin(path))
    assert rest == b"binary chunk"
    assert [node.get("name") for node in found["nodes"]] == ["root", "hips", "twist", "spine"]
    assert found["skins"] == [{"joints": [1, 2, 3]}]
    assert struct.unpack_from("<I", with_skin(path), 8)[0] == len(with_skin(path))


def test_another_node_of_a_bones_name_makes_way_and_a_skin_stays(tmp_path):
    nodes = [{"name": "hips"}, {"name": "x"}, {"name": "y"}, {"name": "z"}]
    skins = [{"joints": [1, 3]}]
    path = tmp_path / "a.vrm"
    path.write_bytes(
        glb(
            {
                "nodes": nodes,
                "skins": skins,
                "extensions": {"VRM": {"humanoid": {"humanBones": FORMS["VRM"]}}},
            }
        )
    )
    found = parts(with_skin(path))[0]
    assert [node["name"] for node in found["nodes"]] == ["hips node 0", "hips", "y", "spine"]
    assert found["skins"] == skins


@pytest.mark.parametrize(
    "content",
    [
        {"nodes": NODES},
        {"nodes": NODES, "extensions": 3},
        {"nodes": NODES, "extensions": {"VRMC_vrm": {"humanoid": {"humanBones": {"hips": 1}}}}},
        {"nodes": NODES, "extensions": {"VRM": {"humanoid": {"humanBones": [{"bone": "hips", "node": 99}]}}}},
        {"extensions": {"VRM": {"humanoid": {"humanBones": FORMS["VRM"]}}}},
    ],
)
def test_a_file_that_names_no_bones_is_refused(tmp_path, content):
    path = tmp_path / "a.vrm"
    path.write_bytes(glb(content))
    with pytest.raises(UnusableMotion, match="which of its nodes are a body's bones"):
        with_skin(path)


def test_text_is_no_vrm(tmp_path):
    (tmp_path / "a.vrm").write_text('{"asset": {"version": "2.0"}, "animations": [{}]}')
    with pytest.raises(ValueError, match="it does not begin as"):
        w2w.load(tmp_path / "a.vrm")


@pytest.mark.later
@pytest.mark.parametrize("suffix", by_day(["vrm"], ["vrm", "vrma"]))
def test_a_motion_comes_back_as_the_fbx_it_was_made_of(shared_data, bundled_body, tmp_path, suffix):
    bpy = pytest.importorskip("bpy")
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "run.glb"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    content, binary = parts((tmp_path / "run.glb").read_bytes())
    (tmp_path / f"run.{suffix}").write_bytes(glb(_as_vrm(content, suffix), binary))
    expected, found = w2w.load(fbx)[0], w2w.load(tmp_path / f"run.{suffix}")[0]
    step = round(found.rate / expected.rate)
    a, b = (joint_transforms(bundled_body, motion)[0] for motion in (expected, found))
    n_frames = min(len(a), len(b[::step]))
    np.testing.assert_allclose(a[:n_frames], b[::step][:n_frames], atol=0.05)


def _as_vrm(content, suffix):
    """The glTF with VRM's extension and meaningless names; of an animation without meshes and skins."""
    mixamo, vrm = (
        json.loads((BONE_MAPS / f"{name}.json").read_text())["joints"] for name in ("mixamo", "vrm")
    )
    names = {mixamo[joint][0]: vrm[joint][1] for joint in vrm if len(vrm[joint]) > 1}
    humans = {}
    for number, node in enumerate(content["nodes"]):
        plain = node.get("name", "").rpartition(":")[2]
        if plain in names:
            humans[names[plain]] = {"node": number}
        node["name"] = f"n{number}"
    extension = "VRMC_vrm" if suffix == "vrm" else "VRMC_vrm_animation"
    content["extensions"] = {extension: {"humanoid": {"humanBones": humans}}}
    if suffix == "vrma":
        content.pop("skins")
        content.pop("meshes", None)
        for node in content["nodes"]:
            node.pop("mesh", None)
            node.pop("skin", None)
    return content
