# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind poses of FBX files that are in another size than the world of their bones, as in some Unity packs.

Blender's C++ importer takes a bone's place at rest from its bind pose and leaves out the size of that: limbs
keep their length, but keyed places count as many times too much as the bind pose is smaller.
"""

import re
import struct
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

import numpy as np

from ..base.body import read_values
from ..base.fcurves import action_curves, curves_by_owner, rescale, slot_named_for
from ..base.module import bpy

LEAST = 0.01
"""Smallest relative difference in size that counts."""

SCALING = re.compile(
    rb'Lcl Scaling(?:"(?:,\s*"[^"\n]*"){1,3},(?P<numbers>[-+.,\deE\s]{5,200})|'
    rb"S\x0b\0\0\0Lcl Scaling(?:S.\0\0\0[A-Z+]{0,3}){1,2}(?P<doubles>D.{8}D.{8}D.{8}))",
    re.DOTALL,
)
"""The scale of a node against its parent, as text or binary; it begins as fast searches want."""

TEXT_NAME = re.compile(rb'Model:\s*(?:\d+,\s*)?"(?:Model::)?([^"\n]{1,500})"')
BINARY_NAME = re.compile(rb"\x05Model(?:L.{8})?S.{4}([^\x00]{1,500})\x00\x01Model", re.DOTALL)
"""Where a node begins, with its name."""


def node_sizes(path: Path) -> dict[str, float]:
    """The scale of each node of an FBX file against its parent, by its name, where it has one."""
    sizes: dict[str, float] = {}
    content = path.read_bytes()
    for found in SCALING.finditer(content):
        doubles, numbers = found["doubles"], (found["numbers"] or b"").split(b",")
        if not doubles and len(numbers) != 3:
            continue
        scale = struct.unpack("<xdxdxd", doubles) if doubles else [float(number) for number in numbers]
        size = float(_sizes(np.array([scale]))[0])
        if abs(size - 1) > LEAST:
            start = content.rfind(b"\x05Model" if doubles else b"Model: ", 0, found.start())
            if start >= 0 and (name := (BINARY_NAME if doubles else TEXT_NAME).match(content, start)):
                sizes[name[1].decode("utf-8", "replace")] = size
    return sizes


def are_scaled(imported: Iterable[bpy.types.ID], nodes: Mapping[str, float]) -> bool:
    """Whether bones of what came from a file are scaled, by their poses or their nodes."""
    return any(
        not nodes.keys().isdisjoint(armature.pose.bones.keys())
        or bool((np.abs(_pose_sizes(armature) - 1) > LEAST).any())
        for armature in _armatures(imported)
    )


def bind_sizes(still: Iterable[bpy.types.ID], nodes: Mapping[str, float]) -> dict[str, float]:
    """The size of each bone's bind pose in its armature, by its name, from an import without animation."""
    sizes = {"": 1.0}
    for armature in _armatures(still):
        for bone, pose in zip(armature.pose.bones, _pose_sizes(armature).tolist(), strict=True):
            parent = sizes[bone.parent.name if bone.parent else ""]  # which comes before its children
            sizes[bone.name] = parent * nodes.get(bone.name, 1.0) / pose
    return sizes


def mend_places(imported: Iterable[bpy.types.ID], sizes: Mapping[str, float]) -> None:
    """Put the places to which bones are keyed in the size of their bind poses."""
    imported = list(imported)
    actions = [item for item in imported if isinstance(item, bpy.types.Action)]
    for armature in _armatures(imported):
        for action in actions:
            slot = slot_named_for(armature, action)
            curves = next(action_curves(action, slot), []) if slot else []
            for bone, own_curves in curves_by_owner(armature, curves).items():
                for (channel, _), curve in own_curves.items():
                    if bone and channel == "location" and abs(sizes[bone] - 1) > LEAST:
                        rescale(curve, 1, sizes[bone], 0.0)


def _armatures(items: Iterable[bpy.types.ID]) -> Iterator[bpy.types.Object]:
    return (item for item in items if isinstance(item, bpy.types.Object) and item.type == "ARMATURE")


def _pose_sizes(armature: bpy.types.Object) -> np.ndarray:
    bones = armature.pose.bones
    return _sizes(read_values(bones, "scale", 3 * len(bones), np.float32).reshape(-1, 3))


def _sizes(scales: np.ndarray) -> np.ndarray:
    """One size (B,) for scales (B, 3) along three axes; 1 where there is none."""
    product = np.abs(scales.astype(np.float64)).prod(axis=1)
    return np.where((product > 0) & (product < np.inf), np.cbrt(product), 1.0)
