# SPDX-License-Identifier: GPL-3.0-or-later
"""Check glTF and VRM files before Blender imports them, and make plain glTF of VRM."""

import json
import struct
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from ..motion.source import HIGHEST_RATE, LOWEST_RATE, UnusableMotion, reading, size_and_head

MAGIC = b"glTF"
JSON_CHUNK = 0x4E4F534A
MAX_JSON_BYTES = 256 * 2**20
MAX_NAMES_BYTES = 2**25
"""Largest glTF text that is read for names alone, as every file of a library is."""


class GltfFacts(NamedTuple):
    """Facts that a glTF file gives before it is imported."""

    keys_a_second: float  # of its densest animated channel
    keys: int  # of that channel
    skin: bool  # whether it names a skeleton's nodes, or leaves it to their motion to say which those are


def animation_names(path: Path) -> list[str]:
    """Names of a glTF file's animations that move its skeleton, if it names one.

    Raises UnusableMotion if it is damaged.
    """
    content = _gltf_content(path, MAX_NAMES_BYTES)
    joints = _moving_joints(content)
    named = []
    for animation in _items(content, "animations"):
        moved = _moving_nodes({"nodes": content.get("nodes", []), "animations": [animation]}).keys()
        if moved & joints if joints else moved:
            named.append(str(animation.get("name", "")))
    return named


def _moving_joints(content: dict[str, Any]) -> set[int]:
    """Nodes of its skins that move; none where it has a skin of something else than the body that moves."""
    joints = {joint for skin in _items(content, "skins") for joint in skin.get("joints", ())}
    return joints & _moving_nodes(content).keys()


def _has_skin(content: dict[str, Any]) -> bool:
    return bool(_moving_joints(content) or (content.get("skins") and not _moving_nodes(content)))


def check_gltf(path: Path, animation: str = "") -> GltfFacts:
    """Facts of a glTF file, or of one animation in it; one that is damaged or moves nothing is refused.

    Raises UnusableMotion, with the reason, also if it reads other files.
    """
    content = _gltf_content(path)
    for kind in ("buffers", "images"):
        if not all(str(item.get("uri", "data:")).startswith("data:") for item in _items(content, kind)):
            raise UnusableMotion(f"its {kind} lie in other files: save it as one file, .glb")
    if not _items(content, "animations"):
        raise UnusableMotion("it holds no animation")
    skin = _has_skin(content)
    if not (skin or _moving_nodes(content) or path.suffix.lower() in VRM_SUFFIXES):
        raise UnusableMotion("it holds no skeleton (skin), and moves no node with a name")
    return GltfFacts(*max(_key_rates(_with_animation(content, animation)), default=(1.0, 0)), skin)


def _gltf_content(path: Path, most: int = MAX_JSON_BYTES) -> dict[str, Any]:
    """The JSON of a glTF file of version 2; any other is refused."""
    size, head = size_and_head(path)
    try:
        with reading():
            content = json.loads(_json_of(path, size, head, most))
        version = str(content["asset"].get("version", ""))
    except (ValueError, RecursionError) as error:
        raise UnusableMotion(f"it is damaged or no glTF file: {error}") from error
    except (KeyError, TypeError, AttributeError) as error:
        raise UnusableMotion("it is damaged or no glTF file: it names no asset") from error
    if not version.startswith("2"):
        raise UnusableMotion(f"it is glTF of version {version[:20] or 'unknown'}; Blender reads version 2")
    return content


def _with_animation(content: dict[str, Any], animation: str) -> dict[str, Any]:
    """The content with one animation, by its name, and no other; with all if the name is ""."""
    if not animation:
        return content
    own = [item for item in _items(content, "animations") if item.get("name") == animation][:1]
    if not own:
        raise UnusableMotion(f"it holds no animation '{animation}'")
    return content | {"animations": own}


def _moving_nodes(content: dict[str, Any]) -> dict[int, str]:
    """Node -> name, of the nodes that the animations turn or move."""
    name_of = {}
    for animation in _items(content, "animations"):
        for channel in _items(animation, "channels"):
            with suppress(KeyError, TypeError, IndexError):
                number = channel["target"]["node"]
                name_of[number] = str(content["nodes"][number]["name"])
    return name_of


def _key_rates(content: dict[str, Any]) -> Iterator[tuple[float, int]]:
    """Keys per second, and keys, of each channel that says how many it has, from when to when."""
    for animation in _items(content, "animations"):
        for sampler in _items(animation, "samplers"):
            with suppress(KeyError, TypeError, IndexError, ValueError, ArithmeticError):
                times = content["accessors"][sampler["input"]]
                rate = (times["count"] - 1) / float(times["max"][0] - times["min"][0])
                if LOWEST_RATE <= rate <= HIGHEST_RATE:
                    yield rate, times["count"]


def _items(content: dict[str, Any], kind: str) -> list[dict[str, Any]]:
    items = content.get(kind, [])
    if not (isinstance(items, list) and all(isinstance(item, dict) for item in items)):
        raise UnusableMotion(f"it is damaged: its {kind} are no list")
    return items


def _json_of(path: Path, size: int, head: bytes, most: int) -> bytes:
    """The JSON of a .gltf, or of the first chunk of a .glb."""
    if not head.startswith(MAGIC):
        if path.suffix.lower() != ".gltf":
            raise ValueError("it does not begin as one")
        if size > most:
            raise ValueError("it is too large")
        return path.read_bytes()
    if len(head) < 20:
        raise ValueError("it ends in its header")
    version, length, chunk, kind = struct.unpack_from("<IIII", head, 4)
    if version != 2:
        raise UnusableMotion(f"it is glTF of version {version}; Blender reads version 2")
    if length > size or kind != JSON_CHUNK or chunk > min(size - 20, most):
        raise ValueError(f"it is cut short: it has {size} bytes of {length}")
    with path.open("rb") as stream:
        stream.seek(20)
        return stream.read(chunk)


PLAIN_GLTF, VRM_SUFFIXES = (".glb", ".gltf"), (".vrm", ".vrma")

EXTENSIONS = ("VRMC_vrm", "VRMC_vrm_animation", "VRM")
"""VRM 1.0, its animations, VRM 0."""


def with_skin(path: Path, animation: str = "") -> bytes:
    """A VRM or glTF file that `check_gltf` lets pass, with a skin and one of its animations or all.

    Raises UnusableMotion if a VRM file does not say which node is which bone.
    """
    data, is_vrm = path.read_bytes(), path.suffix.lower() in VRM_SUFFIXES
    binary = data.startswith(MAGIC)
    if is_vrm and not binary:
        raise UnusableMotion("it is damaged or no VRM file: it does not begin as binary glTF")
    length = struct.unpack_from("<I", data, 12)[0] if binary else 0
    content, rest = json.loads(data[20 : 20 + length] if binary else data), data[20 + length :]
    has_skin = bool(content.get("skins")) if is_vrm else _has_skin(content)
    bones = _bones(content) if is_vrm else {} if has_skin else _moving_nodes(content)
    taken = set(bones.values())
    for number, node in enumerate(content["nodes"]):
        if number in bones:
            node["name"] = bones[number]
        elif isinstance(node, dict) and node.get("name") in taken:
            node["name"] = f"{node['name']} node {number}"
    if not has_skin:
        content["skins"] = [*content.get("skins", []), {"joints": _joints(content["nodes"], bones)}]
    text = json.dumps(_with_animation(content, animation)).encode()
    if not binary:
        return text
    text += b" " * (-len(text) % 4)
    total = 20 + len(text) + len(rest)
    return MAGIC + struct.pack("<IIII", 2, total, len(text), JSON_CHUNK) + text + rest


def _bones(content: dict[str, Any]) -> dict[int, str]:
    """Node -> name of the bone that it is."""
    for name in EXTENSIONS:
        with suppress(KeyError, TypeError, IndexError, AttributeError):
            nodes, humans = content["nodes"], content["extensions"][name]["humanoid"]["humanBones"]
            pairs = [(each["bone"], each) for each in humans] if isinstance(humans, list) else humans.items()
            bone_of = {
                each["node"]: str(bone) for bone, each in pairs if isinstance(nodes[each["node"]], dict)
            }
            if bone_of:
                return bone_of
    raise UnusableMotion("it does not say which of its nodes are a body's bones: it is damaged, or no VRM")


def _joints(nodes: list[dict[str, Any]], bones: dict[int, str]) -> list[int]:
    """The bones, and the nodes between them."""
    parent = {child: number for number, node in enumerate(nodes) for child in node.get("children", [])}
    joints = set(bones)
    for bone in bones:
        between, node = list[int](), parent.get(bone)
        while node is not None and node not in bones and len(between) < len(nodes):
            between.append(node)
            node = parent.get(node)
        if node is not None:
            joints.update(between)
    return sorted(joints)


USD_SUFFIXES = (".usd", ".usda", ".usdc", ".usdz")
