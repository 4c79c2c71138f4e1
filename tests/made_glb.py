# SPDX-License-Identifier: GPL-3.0-or-later
"""Small glTF files of a person who waves and bends a knee, made without Blender."""

import json
import struct
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

# Mixamo's names -> parent and offset from it, m: y up, the left side along +x
SKELETON: dict[str, tuple[str, tuple[float, float, float]]] = {
    "Hips": ("", (0, 0.95, 0)),
    "Spine": ("Hips", (0, 0.12, 0)),
    "Spine1": ("Spine", (0, 0.14, 0)),
    "Spine2": ("Spine1", (0, 0.14, 0)),
    "Neck": ("Spine2", (0, 0.14, 0)),
    "Head": ("Neck", (0, 0.1, 0)),
}
for side, sign in (("Left", 1), ("Right", -1)):
    SKELETON |= {
        f"{side}Shoulder": ("Spine2", (sign * 0.06, 0.1, 0)),
        f"{side}Arm": (f"{side}Shoulder", (sign * 0.12, 0, 0)),
        f"{side}ForeArm": (f"{side}Arm", (sign * 0.27, 0, 0)),
        f"{side}Hand": (f"{side}ForeArm", (sign * 0.25, 0, 0)),
        f"{side}UpLeg": ("Hips", (sign * 0.09, -0.05, 0)),
        f"{side}Leg": (f"{side}UpLeg", (0, -0.42, 0)),
        f"{side}Foot": (f"{side}Leg", (0, -0.4, 0)),
        f"{side}ToeBase": (f"{side}Foot", (0, -0.06, 0.13)),
    }

BODY = tuple(name for name in SKELETON if "Toe" not in name)


def turns(times: np.ndarray, moved: tuple[str, ...] = BODY) -> dict[str, np.ndarray]:
    """Quaternions (T, 4), w last, of bones that turn by times (T,) in seconds."""
    ways = {"LeftArm": ([0, 0, 1], 1.2), "LeftForeArm": ([0, 0, 1], 0.8), "RightLeg": ([1, 0, 0], 0.9)}
    found = {}
    for name in moved:
        axis, size = ways.get(name, ([0, 1, 0], 0.02))
        angle = size * (0.5 - 0.5 * np.cos(4 * times))
        found[name] = Rotation.from_rotvec(angle[:, None] * axis).as_quat()
    return found


def write_glb(
    path: Path,
    animations: Mapping[str, Mapping[str, np.ndarray]],
    times: np.ndarray,
    extra: int = 0,
    scales: Mapping[str, tuple[float, float, float]] | None = None,
) -> Path:
    """Write a skeleton with `extra` bones that no animation moves, and animations by name: bone -> turns."""
    names = [*SKELETON, *(f"Hair{number}" for number in range(extra))]
    nodes, data = [], bytearray()
    views: list[dict] = []
    accessors: list[dict] = []

    def stored(values: np.ndarray, kind: str, bounds: bool = False) -> int:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.size * 4})
        data.extend(values.astype("<f4").tobytes())
        accessor = {"bufferView": len(views) - 1, "componentType": 5126, "count": len(values), "type": kind}
        if bounds:
            accessor |= {"min": [float(values.min())], "max": [float(values.max())]}
        accessors.append(accessor)
        return len(accessors) - 1

    for name in names:
        _, offset = SKELETON.get(name, ("Head", (0, 0.02, 0)))
        node = {"name": name, "translation": list(offset)}
        node |= {"scale": list(scales[name])} if scales and name in scales else {}
        children = [n for n in names if SKELETON.get(n, ("Head",))[0] == name]
        node |= {"children": [names.index(child) for child in children]} if children else {}
        nodes.append(node)
    time = stored(times, "SCALAR", bounds=True)
    written = []
    for name, bones in animations.items():
        samplers = [
            {"input": time, "output": stored(values, "VEC4"), "interpolation": "LINEAR"}
            for values in bones.values()
        ]
        channels = [
            {"sampler": number, "target": {"node": names.index(bone), "path": "rotation"}}
            for number, bone in enumerate(bones)
        ]
        written.append({"name": name, "samplers": samplers, "channels": channels})
    content = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": nodes,
        "skins": [{"joints": list(range(len(names)))}],
        "animations": written,
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(data)}],
    }
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<IIII", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
    path.write_bytes(b"glTF" + head + text + struct.pack("<II", len(data), 0x004E4942) + bytes(data))
    return path
