# SPDX-License-Identifier: GPL-3.0-or-later
"""Which versions of W2W and its libraries made a result."""

from __future__ import annotations

import hashlib
import platform
import sys
import tomllib
from functools import cache
from importlib import metadata
from pathlib import Path

LIBRARIES = ("numpy", "scipy", "scikit-learn", "trimesh", "pygeodesic", "potpourri3d", "bpy")
ROOT = Path(__file__).resolve().parents[1]


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


@cache
def code_sha256() -> str:
    """Hash of the code and templates that results depend on."""
    digest = hashlib.sha256()
    files = [*ROOT.glob("blender_addon/w2w/core/**/*.py"), *ROOT.glob("blender_addon/w2w/scene/*.py")]
    files += [*ROOT.glob("assets/templates/bone_maps/*.json"), *ROOT.glob("headless/clip_*.py")]
    files += [ROOT / "headless" / name for name in ("job.py", "load_clip.py")]
    for path in sorted(files):
        digest.update(path.relative_to(ROOT).as_posix().encode())
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _own_version() -> str:
    """W2W's version, as an installed extension or a tree says it, else as pip does."""
    try:
        return tomllib.loads((ROOT / "blender_manifest.toml").read_text(encoding="utf-8"))["version"]
    except OSError:
        return _version("where-to-wear")


def _version(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""
