# SPDX-License-Identifier: GPL-3.0-or-later
"""The versions of the programs that results depend on."""

from __future__ import annotations

import platform
import sys
import tomllib
from importlib import metadata

from ..body.body import PACKAGE

LIBRARIES = ("numpy", "scipy", "scikit-learn", "trimesh", "bpy")


def versions() -> dict[str, str]:
    """Version of W2W, of Python, of Blender and of each library that results depend on."""
    found = {"w2w": _own_version(), "python": platform.python_version()}
    for name in LIBRARIES:
        version = _version(name)
        if version:
            found[name] = version
    if "bpy" not in found and "bpy" in sys.modules:  # the Blender program
        found["bpy"] = sys.modules["bpy"].app.version_string
    return found


def _own_version() -> str:
    """W2W's version, as an installed extension or a tree says it, else as pip does."""
    try:
        manifest = (PACKAGE.parents[1] / "blender_manifest.toml").read_text(encoding="utf-8")
        return tomllib.loads(manifest)["version"]
    except OSError:
        return _version("where-to-wear")


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
