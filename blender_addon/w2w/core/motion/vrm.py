# SPDX-License-Identifier: GPL-3.0-or-later
"""VRM avatars and VRM animations as plain glTF, whose bones bear the names that VRM gives them.

Both are binary glTF with an extension that says which node is which bone; an animation (.vrma) has no skin.
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

from .gltf_check import JSON_CHUNK, MAGIC
from .source import UnusableMotion

VRM_SUFFIXES = (".vrm", ".vrma")

EXTENSIONS = ("VRMC_vrm", "VRMC_vrm_animation", "VRM")
"""VRM 1.0, its animations, VRM 0."""


def as_plain_glb(path: Path) -> bytes:
    """A VRM file as a binary glTF that any importer reads.

    Parameters
    ----------
    path : Path
        A file that `check_gltf` lets pass.

    Raises
    ------
    UnusableMotion
        If it does not say which node is which bone.
    """
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise UnusableMotion("it is damaged or no VRM file: it does not begin as binary glTF")
    length = struct.unpack_from("<I", data, 12)[0]
    content, rest = json.loads(data[20 : 20 + length]), data[20 + length :]
    bones = _bones(content)
    _name(content["nodes"], bones)
    if not content.get("skins"):
        content["skins"] = [{"joints": _joints(content["nodes"], bones)}]
    text = json.dumps(content).encode()
    text += b" " * (-len(text) % 4)
    total = 20 + len(text) + len(rest)
    return MAGIC + struct.pack("<IIII", 2, total, len(text), JSON_CHUNK) + text + rest


def _bones(content: dict[str, Any]) -> dict[int, str]:
    """Node -> name of the bone that it is."""
    nodes: Any = content.get("nodes")
    extensions: Any = content.get("extensions")
    found: dict[int, str] = {}
    for name in EXTENSIONS:
        try:
            humans = extensions[name]["humanoid"]["humanBones"]
            pairs = [(each["bone"], each["node"]) for each in humans] if isinstance(humans, list) else [
                (bone, each["node"]) for bone, each in humans.items()
            ]  # fmt: skip
            found = {node: str(bone) for bone, node in pairs if isinstance(nodes[node], dict)}
            break
        except (KeyError, TypeError, IndexError, AttributeError):
            continue
    if not found:
        raise UnusableMotion(
            "it does not say which of its nodes are a body's bones: it is damaged, or no VRM"
        )
    return found


def _name(nodes: list[dict[str, Any]], bones: dict[int, str]) -> None:
    """Give bones their names, and nodes that bear one of those another."""
    taken = set(bones.values())
    for number, node in enumerate(nodes):
        if number in bones:
            node["name"] = bones[number]
        elif isinstance(node, dict) and node.get("name") in taken:
            node["name"] = f"{node['name']} node {number}"


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
