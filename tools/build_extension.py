# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the Blender extension: one zip a platform in dist/, with the wheels for Blender's Pythons.

Run with the Python of an environment that holds the `bpy` package, whose extension tool writes the zip:

    python tools/build_extension.py [--all] [--blender BLENDER] [PLATFORM ...]

Platforms are Blender's names; linux-x64 by default. --blender makes the zip for the Python of that Blender
alone, such as a Linux distribution's that uses the system's Python. Wheels are downloaded to .cache/wheels
once.
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

from blender_wheels import PLATFORMS, PROJECT, ask_blender, fetch_wheels, shipped_name

MANIFEST = "blender_manifest.toml"
PARTS = (MANIFEST, "__init__.py", "LICENSE", "assets", "blender_addon", "headless")
NOT_SHIPPED = shutil.ignore_patterns("__pycache__", "build", ".*")

PYTHONS = ("3.11", "3.13")
"""Blender 4.2 to 5.0 have Python 3.11, Blender 5.1 and Debian 13's 4.3 have 3.13."""


def main() -> None:
    """Build the zips that the command line asks for and print their paths."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("platform", nargs="*", help=f"some of {', '.join(PLATFORMS)}; linux-x64 by default")
    parser.add_argument("--all", action="store_true", help="a zip for every platform")
    parser.add_argument("--blender", metavar="PROGRAM", help="only for the Python of this Blender program")
    options = parser.parse_args()
    pythons = (ask_blender(options.blender),) if options.blender else PYTHONS
    for platform in PLATFORMS if options.all else options.platform or ["linux-x64"]:
        target = build(platform, pythons)
        print(f"{target}  {target.stat().st_size / 1e6:.0f} MB")


def build(platform: str, pythons: tuple[str, ...] = PYTHONS) -> Path:
    """Build the extension for one platform and some Pythons.

    Returns
    -------
    Path
        The zip.
    """
    wheels = {shipped_name(wheel.name, pythons[0]): wheel for wheel in fetch_wheels(platform, pythons)}
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
        for name, wheel in wheels.items():
            shutil.copy(wheel, stage / "wheels" / name)
        (stage / MANIFEST).write_text(manifest(platform, [*wheels]), encoding="utf-8")
        version = re.search(r'^version = "(.+)"', (stage / MANIFEST).read_text("utf-8"), re.MULTILINE)[1]
        only = "" if pythons == PYTHONS else "".join(f"-python{python}" for python in pythons)
        target = destination / f"w2w-{version}-{platform}{only}.zip"
        blender_tool("validate", str(stage))
        blender_tool("build", "--source-dir", str(stage), "--output-filepath", str(target))
    return target


def manifest(platform: str, wheels: list[str]) -> str:
    """The manifest of one platform's zip: the tree's own, with the wheels and without the build rules."""
    text = (PROJECT / MANIFEST).read_text(encoding="utf-8").split("[build]")[0]
    lines = "".join(f'    "./wheels/{wheel}",\n' for wheel in wheels)
    return text.replace("[permissions]", f'platforms = ["{platform}"]\nwheels = [\n{lines}]\n\n[permissions]')


def blender_tool(*arguments: str) -> None:
    """Run Blender's extension tool, which needs no running Blender."""
    spec = importlib.util.find_spec("bpy")
    if spec is None or spec.origin is None:
        raise SystemExit(f"{sys.executable} has no bpy package, whose extension tool builds the zip")
    (tool,) = Path(spec.origin).parent.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py")
    subprocess.run([sys.executable, str(tool), *arguments], check=True, stdout=subprocess.DEVNULL)


if __name__ == "__main__":
    main()
