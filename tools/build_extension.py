# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the Blender extension: one zip a platform in dist/, with the wheels for Blender's Pythons.

Run with the Python of an environment that holds the `bpy` package, whose extension tool writes the zip:

    python tools/build_extension.py [--all] [PLATFORM ...]

Platforms are Blender's names; linux-x64 unless told. Wheels are downloaded to .cache/wheels once.
"""

from __future__ import annotations

import argparse
import importlib.util
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PROJECT = Path(__file__).resolve().parents[1]
MANIFEST = "blender_manifest.toml"
PARTS = (MANIFEST, "__init__.py", "LICENSE", "assets", "blender_addon")
NOT_SHIPPED = shutil.ignore_patterns("__pycache__", "build", "make_body", ".*")

PYTHONS = ("3.11", "3.13")
"""Blender 4.2 to 5.0 have Python 3.11, Blender 5.1 and Debian's builds 3.13."""

PURE_WHEELS = ("cloudpickle", "cmap", "joblib", "threadpoolctl", "trimesh")
COMPILED_WHEELS = ("pygeodesic", "scikit-learn", "scipy")
"""What the extension imports beyond numpy, which Blender has, and what these need; the versions stand
in constraints.txt."""

OTHER_VERSIONS = {("pygeodesic", "3.13"): "0.1.11"}
"""Where the constrained version has no wheel for a Python."""

PLATFORMS = {
    "linux-x64": ("manylinux2014_x86_64", "manylinux_2_28_x86_64"),
    "windows-x64": ("win_amd64",),
    "macos-arm64": ("macosx_12_0_arm64", "macosx_11_0_arm64"),
    "macos-x64": ("macosx_10_13_x86_64", "macosx_10_9_x86_64"),
}
"""Blender's name of a platform, and the tags of the wheels that run there."""


def main() -> None:
    """Build the zips that the command line asks for and print their paths."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("platform", nargs="*", help=f"some of {', '.join(PLATFORMS)}; linux-x64 unless told")
    parser.add_argument("--all", action="store_true", help="a zip for every platform")
    options = parser.parse_args()
    for platform in PLATFORMS if options.all else options.platform or ["linux-x64"]:
        target = build(platform)
        print(f"{target}  {target.stat().st_size / 1e6:.0f} MB")


def build(platform: str) -> Path:
    """Build the extension for one platform.

    Returns
    -------
    Path
        The zip.
    """
    wheels = fetch_wheels(platform)
    destination = PROJECT / "dist"
    destination.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / "w2w"
        stage.mkdir()
        for part in PARTS:
            copy = shutil.copytree if (PROJECT / part).is_dir() else shutil.copy
            options = {"ignore": NOT_SHIPPED} if (PROJECT / part).is_dir() else {}
            copy(PROJECT / part, stage / part, **options)
        (stage / "wheels").mkdir()
        for wheel in wheels:
            shutil.copy(wheel, stage / "wheels")
        (stage / MANIFEST).write_text(manifest(platform, [wheel.name for wheel in wheels]), encoding="utf-8")
        version = re.search(r'^version = "(.+)"', (stage / MANIFEST).read_text("utf-8"), re.MULTILINE)[1]
        target = destination / f"w2w-{version}-{platform}.zip"
        blender_tool("validate", str(stage))
        blender_tool("build", "--source-dir", str(stage), "--output-filepath", str(target))
    return target


def manifest(platform: str, wheels: list[str]) -> str:
    """The manifest of one platform's zip: the tree's own, with the wheels and without the build rules."""
    text = (PROJECT / MANIFEST).read_text(encoding="utf-8").split("[build]")[0]
    lines = "".join(f'    "./wheels/{wheel}",\n' for wheel in wheels)
    return text.replace("[permissions]", f'platforms = ["{platform}"]\nwheels = [\n{lines}]\n\n[permissions]')


def fetch_wheels(platform: str) -> list[Path]:
    """Download the wheels that one platform needs, unless they are there, and list them."""
    cache = PROJECT / ".cache" / "wheels" / platform
    wanted = {(name, PYTHONS[0], version_of(name)) for name in PURE_WHEELS}
    for python in PYTHONS:
        wanted |= {
            (name, python, OTHER_VERSIONS.get((name, python), version_of(name))) for name in COMPILED_WHEELS
        }
    return sorted(fetch_wheel(cache, platform, *wheel) for wheel in wanted)


def fetch_wheel(cache: Path, platform: str, name: str, python: str, version: str) -> Path:
    """One wheel, from the cache folder or downloaded to it."""
    cpython = "py3-none-any" if name in PURE_WHEELS else f"cp{python.replace('.', '')}-*"
    pattern = f"{name.replace('-', '_')}-{version}-{cpython}.whl"
    if not list(cache.glob(pattern)):
        tags = [f"--platform={tag}" for tag in PLATFORMS[platform]]
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--only-binary=:all:", *tags]
        subprocess.run(
            [*pip, f"--python-version={python}", f"{name}=={version}", f"--dest={cache}"], check=True
        )
    return next(iter(cache.glob(pattern)))


def version_of(name: str) -> str:
    """Version of a package in constraints.txt."""
    constraints = (PROJECT / "constraints.txt").read_text(encoding="utf-8")
    found = re.search(rf"^{re.escape(name)}==(\S+)", constraints, re.MULTILINE)
    if found is None:
        raise SystemExit(f"constraints.txt has no version of {name}: add one")
    return found[1]


def blender_tool(*arguments: str) -> None:
    """Run Blender's extension tool, which needs no running Blender."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise SystemExit(f"{sys.executable} has no bpy package, whose extension tool builds the zip")
    (tool,) = Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    subprocess.run([sys.executable, str(tool), *arguments], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
