# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes of a file whose keys lie at times that are none."""

import json
import struct

import bpy
import numpy as np
import pytest

import w2w
from w2w.core.motion.source import UnusableMotion
from w2w.scene.motion.takes import read_clip

BONES = ("Hips", "Spine", "Head")
TIMES = np.arange(31, dtype=np.float32) / 30


@pytest.fixture(autouse=True)
def empty_scene():
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)


def turning(times: np.ndarray) -> bytes:
    """A glb of a chain of bones, each turning about z, with a key at each of the times (T,) in seconds."""
    angles = np.linspace(0, 1, len(times)) / 2
    turns = np.stack([0 * angles, 0 * angles, np.sin(angles), np.cos(angles)], axis=1)
    places = np.tile([0, 0.3, 0], (len(BONES), 1))
    arrays = [times, turns, np.tile(np.eye(4).ravel(), (len(BONES), 1))]
    data = [np.asarray(array, "<f4").tobytes() for array in arrays]
    starts = np.cumsum([0, *map(len, data)])
    kinds = ("SCALAR", "VEC4", "MAT4")
    numbers = range(len(BONES))
    content = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": int(starts[-1])}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": int(start), "byteLength": len(part)}
            for start, part in zip(starts, data, strict=False)
        ],
        "accessors": [
            {"bufferView": number, "componentType": 5126, "count": len(array), "type": kind}
            | ({"min": [0], "max": [1]} if kind == "SCALAR" else {})
            for number, (array, kind) in enumerate(zip(arrays, kinds, strict=True))
        ],
        "nodes": [
            {"name": name, "translation": place.tolist()} | ({"children": [number + 1]} if number < 2 else {})
            for number, (name, place) in enumerate(zip(BONES, places, strict=True))
        ],
        "skins": [{"joints": [*numbers], "inverseBindMatrices": 2}],
        "scenes": [{"nodes": [0]}],
        "animations": [
            {
                "samplers": [{"input": 0, "output": 1}],
                "channels": [
                    {"sampler": 0, "target": {"node": number, "path": "rotation"}} for number in numbers
                ],
            }
        ],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(data)
    chunks = [
        struct.pack("<II", len(text), 0x4E4F534A),
        text,
        struct.pack("<II", len(binary), 0x4E4942),
        binary,
    ]
    body = b"".join(chunks)
    return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def at(place: int, time: float) -> np.ndarray:
    """The times, of which one is another."""
    times = TIMES.copy()
    times[place] = time
    return times


@pytest.mark.parametrize("rate", [None, 30.0])
def test_keys_at_regular_times_are_read(tmp_path, rate):
    (tmp_path / "a.glb").write_bytes(turning(TIMES))
    assert read_clip(tmp_path / "a.glb", rate).n_frames == (61 if rate is None else 31)


@pytest.mark.parametrize("rate", [None, 30.0])
@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf, 3e38, -3e38, 1e30, 1e6])
@pytest.mark.parametrize("place", [0, 12, -1])
def test_keys_at_no_time_of_a_motion_are_refused(tmp_path, place, time, rate):
    (tmp_path / "a.glb").write_bytes(turning(at(place, time)))
    with pytest.raises(UnusableMotion, match=r"values that no body has|too long to be read at once"):
        read_clip(tmp_path / "a.glb", rate)


@pytest.mark.parametrize("time", [0.0, 1e-30, 1.0])
def test_keys_all_at_one_time_are_no_motion(tmp_path, time):
    (tmp_path / "a.glb").write_bytes(turning(np.full(31, time, np.float32)))
    with pytest.raises(UnusableMotion):
        read_clip(tmp_path / "a.glb")


def test_a_real_file_of_such_times_is_refused(shared_cases):
    with pytest.raises(ValueError, match="values that no body has"):
        w2w.load(shared_cases / "second/glb_time_inf.glb")
