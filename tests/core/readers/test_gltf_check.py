# SPDX-License-Identifier: GPL-3.0-or-later
"""glTF: a whole file of version 2 comes back as the FBX it was made of; others are refused in a sentence."""

import json
import struct
from functools import partial

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w
from w2w.core.body.body import JOINT_INDEX, Y_UP_TO_Z_UP
from w2w.core.motion.skinning import joint_transforms
from w2w.core.motion.source import UnusableMotion
from w2w.core.readers.import_checks import check_gltf
from w2w.core.reading import reader

from ...made_glb import turns, write_glb

WHOLE = {
    "asset": {"version": "2.0"}, "animations": [{}], "skins": [{}], "buffers": [{"uri": "data:;base64,AA=="}],
}  # fmt: skip

MOVING = {
    "skins": [],
    "nodes": [{"name": "Hips"}],
    "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "rotation"}}]}],
}


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
        ("a.glb", glb(WHOLE | MOVING | {"nodes": [{"mesh": 0}]}), "moves no node with a name"),
        ("a.glb", glb(WHOLE | MOVING | {"animations": [{"channels": [{"target": 3}]}]}), "moves no node"),
        ("a.glb", glb(WHOLE | MOVING), ""),
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


@pytest.mark.parametrize(
    "times", [{"count": 10**400, "max": [1], "min": [0]}, {"count": 9, "max": [10**400], "min": [0]}]
)
def test_numbers_beyond_all_give_no_rate(tmp_path, times):
    animations = [{"samplers": [{"input": 0}]}]
    (tmp_path / "a.glb").write_bytes(glb(WHOLE | {"animations": animations, "accessors": [times]}))
    assert check_gltf(tmp_path / "a.glb").keys_a_second == 1.0


def limb_directions(positions):
    """Unit vectors (T, 8, 3) along the limbs, of positions (T, 3) by SMPL's names."""
    bones = [
        positions(f"{side}_{end}") - positions(f"{side}_{start}")
        for side in ("left", "right")
        for start, end in (("hip", "knee"), ("knee", "ankle"), ("shoulder", "elbow"), ("elbow", "wrist"))
    ]
    bones = np.stack(bones, axis=1)
    return bones / np.linalg.norm(bones, axis=-1, keepdims=True)


def angles(a, b):
    return np.degrees(np.arccos(np.clip((a * b).sum(axis=-1), -1, 1)))


def node_positions(path):
    """World positions of the nodes at the first channel's keys, by name, z up: glTF read without Blender."""
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    content, buffer = json.loads(data[20 : 20 + length]), data[28 + length :]

    def array(number):
        accessor = content["accessors"][number]
        view = content["bufferViews"][accessor["bufferView"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(buffer, "<f4", accessor["count"] * width, start).reshape(-1, width)

    animation = content["animations"][0]
    samplers = animation["samplers"]
    times = array(samplers[0]["input"])[:, 0]
    local = {}
    for channel in animation["channels"]:
        sampler, target = samplers[channel["sampler"]], channel["target"]
        own = array(sampler["input"])[:, 0]
        values = array(sampler["output"])
        local[target["node"], target["path"]] = np.stack(
            [np.interp(times, own, values[:, axis]) for axis in range(values.shape[1])], axis=1
        )
    found = {}

    def walk(number, turns, places):
        node = content["nodes"][number]
        shift = local.get((number, "translation"), np.array(node.get("translation", [0, 0, 0.0])))
        turn = local.get((number, "rotation"), np.array(node.get("rotation", [0, 0, 0, 1.0])))
        places = places + np.einsum("tab,tb->ta", turns, np.broadcast_to(shift, places.shape))
        turns = turns @ Rotation.from_quat(np.broadcast_to(turn, (len(times), 4))).as_matrix()
        found[node.get("name")] = places @ Y_UP_TO_Z_UP.T
        for child in node.get("children", ()):
            walk(child, turns, places)

    for root in content["scenes"][0]["nodes"]:
        walk(root, np.tile(np.eye(3), (len(times), 1, 1)), np.zeros((len(times), 3)))
    return found


RPM_BONES = {
    "hip": "UpLeg",
    "knee": "Leg",
    "ankle": "Foot",
    "shoulder": "Arm",
    "elbow": "ForeArm",
    "wrist": "Hand",
}


@pytest.mark.later
def test_nodes_that_move_are_the_bones_of_a_file_without_a_skin(shared_cases, bundled_body):
    pytest.importorskip("bpy")
    path = shared_cases / "rpm_no_skin_walk.glb"
    motion = w2w.load(path, pose=w2w.PoseFacts(rate=24.0))[0]
    nodes = node_positions(path)
    _, joints = joint_transforms(bundled_body, motion)
    assert motion.n_frames == len(nodes["Hips"])

    def node(name):
        side, part = name.split("_")
        return nodes[f"{side.title()}{RPM_BONES[part]}"]

    off = angles(limb_directions(lambda name: joints[:, JOINT_INDEX[name]]), limb_directions(node))
    assert np.median(off, axis=0).max() < 2


@pytest.mark.slow
def test_a_motion_comes_back_as_the_fbx_it_was_made_of(shared_data, bundled_body, tmp_path):
    bpy = pytest.importorskip("bpy")
    fbx = shared_data / "mixamo/kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx"
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    bpy.ops.import_scene.fbx(filepath=str(fbx))
    bpy.ops.export_scene.gltf(filepath=str(tmp_path / "run.glb"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
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


TIMES = np.arange(60) / 30


def loaded(path, **options):
    """Motions of a file of ours, read here: a worker takes seconds to start."""
    pytest.importorskip("bpy")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(reader, "RISKY", ())
        return w2w.load(path, **options)


def write_waves(folder, times=TIMES, **options):
    waves = {name: turns(times) for name in ("Idle", "Wave", "Hail")}
    return write_glb(folder / "waves.glb", waves, times, **options)


@pytest.fixture
def written(tmp_path):
    """A function that writes three waves with further bones, scales or times."""
    return partial(write_waves, tmp_path)


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """The motions of three waves as they are."""
    return loaded(write_waves(tmp_path_factory.mktemp("plain")))


def arm(motion):
    return motion.rotations[:, JOINT_INDEX["left_shoulder"]]


def test_bones_that_no_animation_moves_do_not_count_among_a_body_s(plain, written):
    assert len(plain) == 3
    np.testing.assert_allclose(arm(loaded(written(extra=80))[0]), arm(plain[0]), atol=1e-6)


def test_a_skin_of_something_else_leaves_a_body_of_stiff_parts_its_animations(plain, written):
    path = written()
    data = path.read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    content, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    content["skins"] = [{"joints": [len(content["nodes"])]}]
    content["nodes"][0]["children"].append(len(content["nodes"]))
    content["nodes"].append({"name": "Cape"})
    head = glb(content)
    path.write_bytes(b"glTF" + struct.pack("<II", 2, len(head) + len(rest)) + head[12:] + rest)
    found = loaded(path)
    assert len(found) == 3
    np.testing.assert_allclose(arm(found[0]), arm(plain[0]), atol=1e-6)


@pytest.mark.filterwarnings("error::RuntimeWarning")
@pytest.mark.parametrize(
    ("bone", "scale"),
    [("Head", (0, 0, 0)), ("Head", (1, 0, 1)), ("LeftToeBase", (0, 0, 0)), ("LeftArm", (0, 0, 0))],
)
def test_bones_hidden_by_a_scale_of_nothing_turn_as_they_do(plain, written, bone, scale):
    hidden = loaded(written(scales={bone: scale}))
    np.testing.assert_allclose(hidden[0].rotations, plain[0].rotations, atol=1e-5)


def test_keys_a_second_apart_are_frames_whose_rate_is_asked_for(written):
    path = written(times=np.arange(60.0))
    with pytest.raises(ValueError, match="its 60 keys are a second apart, which looks like frames without"):
        loaded(path)
    motion = loaded(path, pose=w2w.PoseFacts(rate=30.0))[0]
    assert (motion.n_frames, motion.rate) == (60, 30)
    assert loaded(written(times=np.arange(12.0)))[0].rate == 60  # poses that somebody set
