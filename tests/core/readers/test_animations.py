# SPDX-License-Identifier: GPL-3.0-or-later
"""Names of the animations in glTF and FBX files, from their bytes alone."""

import json
import struct

import pytest

from w2w.core.readers.animations import animations_in, telling_part

NODES = [{"name": "Hips", "children": [1]}, {"name": "Spine"}, {"name": "Door"}]


def gltf(*names, joints=(0, 1), node=1):
    """A glTF file's content with an animation of a node for each name."""
    channels = [{"sampler": 0, "target": {"node": node, "path": "rotation"}}]
    animations = [
        {"channels": channels, "samplers": [], **({"name": name} if name else {})} for name in names
    ]
    skins = [{"joints": list(joints)}] if joints else []
    return {"asset": {"version": "2.0"}, "nodes": NODES, "skins": skins, "animations": animations}


def binary_fbx(*names, count=None):
    """The parts of a binary FBX file that list its animations."""
    counted = struct.pack("<I", len(names) if count is None else count)
    contents = b"S\x0e\0\0\0AnimationStack" + bytes(12) + b"\x05CountI" + counted
    stack = b"\x0eAnimationStackL" + bytes(8) + b"S"
    records = [
        stack + struct.pack("<I", len(name) + 11) + name + b"\0\x01AnimStackS\0\0\0\0" for name in names
    ]
    return b"Kaydara FBX Binary  \0\x1a\0" + struct.pack("<I", 7400) + contents + b"".join(records)


def text_fbx(*names):
    stacks = "".join(f'\tAnimationStack: 12345, "AnimStack::{name}", "" {{\n\t}}\n' for name in names)
    contents = f'\tObjectType: "AnimationStack" {{\n\t\tCount: {len(names)}\n\t}}\n'
    return f"; FBX 7.4.0 project file\n{contents}{stacks}"


def found_in(folder, name, content):
    (folder / name).write_bytes(content if isinstance(content, bytes) else json.dumps(content).encode())
    return animations_in(folder / name)


@pytest.mark.parametrize(
    ("names", "short"),
    [
        (("Walk", "Run"), ["Walk", "Run"]),
        (("Armature|Walk", "Armature|Run"), ["Walk", "Run"]),
        (("Armature|Walk", "Run"), ["Armature|Walk", "Run"]),
        (("Walk",), []),
        (("Walk", "Take 001", ""), []),
        (("mixamo.com", "Idle", "Walk"), []),
        ((), []),
    ],
)
def test_several_with_telling_names(tmp_path, names, short):
    expected = dict(zip(short, names, strict=False))
    assert found_in(tmp_path, "a.gltf", gltf(*names)) == expected
    assert found_in(tmp_path, "a.fbx", text_fbx(*names).encode()) == expected
    assert found_in(tmp_path, "b.fbx", binary_fbx(*(name.encode() for name in names))) == expected


def test_animations_of_other_things_than_the_skeleton_do_not_count(tmp_path):
    content = gltf("Walk", "Run")
    content["animations"] += gltf("Open", "Close", node=2)["animations"]
    assert list(found_in(tmp_path, "a.gltf", content)) == ["Walk", "Run"]
    assert list(found_in(tmp_path, "a.gltf", gltf("Open", "Close", joints=(), node=2))) == ["Open", "Close"]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"glTF",
        b"[]",
        b"{",
        {"asset": {"version": "2.0"}, "animations": [{}, {"name": "a"}, {"name": "b"}]},
        {**gltf("a", "b"), "skins": [{"joints": 7}]},
        {**gltf("a", "b"), "nodes": "none"},
        binary_fbx(b"Walk", count=3),
        binary_fbx(b"Walk", b"Run")[:-40],
    ],
)
def test_damaged_files_have_none(tmp_path, content):
    for name in ("a.gltf", "a.glb", "a.fbx"):
        assert found_in(tmp_path, name, content) == {}
    assert animations_in(tmp_path / "nowhere.fbx") == {}


def test_the_last_part_that_says_something_tells():
    assert telling_part("Armature|Walk|Layer0") == "Walk"
    assert telling_part("Woman|Walk.001", frozenset({"Woman"})) == "Walk"
    assert telling_part("Armature|mixamo.com|Layer0.001") == ""
