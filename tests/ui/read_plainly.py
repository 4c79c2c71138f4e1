# SPDX-License-Identifier: GPL-3.0-or-later
"""Open a file in a Blender without W2W and write down its colour attributes; run by test_steps.py."""

from __future__ import annotations

import sys

import bpy
import numpy as np


def main(path: str, report: str) -> None:
    """Read the only mesh of the file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=path)
    (mesh,) = (item.data for item in bpy.data.objects if item.type == "MESH")
    attributes = mesh.color_attributes
    found = {}
    for attribute in attributes:
        found[attribute.name] = np.empty(4 * len(attribute.data), dtype=np.float32)
        attribute.data.foreach_get("color", found[attribute.name])
    np.savez(
        report,
        names=attributes.keys(),
        active=attributes.active_color.name,
        empties=sum(item.type == "EMPTY" for item in bpy.data.objects),
        **found,
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
