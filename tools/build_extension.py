# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the Blender extension: one zip a platform and Python in dist/, W2W itself a wheel among the others.

Run with the Python of an environment that holds the `bpy` package, whose extension tool writes the zip:

    python tools/build_extension.py [--all] [--blender BLENDER] [PLATFORM ...]

Platforms are Blender's names; linux-x64 by default. --blender makes the zip for the Python of that Blender
alone, such as a Linux distribution's that uses the system's Python. Other wheels are downloaded to
.cache/wheels once.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from blender_wheels import PLATFORMS, PROJECT, SPANS, ask_blender, fetch_wheels
from check_zip import LEFT_TO_PIP, problems

MANIFEST = "blender_manifest.toml"
DOOR = ("__init__.py", "LICENSE")

SERIES = {"3.11": ("4.3.0", "5.1.0"), "3.13": ("5.1.0", "")}
"""The first Blender that has a Python, and the first that has a later one."""

EPOCH = 1_767_225_600
"""Time of all files in what is built, 2026-01-01: the same tree gives the same bytes."""

OLDEST = "4.3.0"
"""The oldest Blender that the tests run in."""


def main() -> None:
    """Build the zips that the command line asks for and print their paths."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("platform", nargs="*", help=f"some of {', '.join(PLATFORMS)}; linux-x64 by default")
    parser.add_argument("--all", action="store_true", help="zips for every platform")
    parser.add_argument("--blender", metavar="PROGRAM", help="only for the Python of this Blender program")
    options = parser.parse_args()
    series = {ask_blender(options.blender): (OLDEST, "")} if options.blender else SERIES
    for platform in PLATFORMS if options.all else options.platform or ["linux-x64"]:
        for python, blenders in series.items():
            target = build(platform, python, blenders)
            print(f"{target}  {target.stat().st_size / 1e6:.1f} MB")
            for problem in problems(target):
                raise SystemExit(f"{target.name}: {problem}")


def build(
    platform: str, python: str, blenders: tuple[str, str], destination: Path = PROJECT / "dist"
) -> Path:
    """Build the extension for one platform, one Python and the Blenders that have it.

    Returns
    -------
    Path
        The zip.
    """
    destination.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        stage = Path(folder) / "w2w"
        (stage / "wheels").mkdir(parents=True)
        for part in DOOR:
            shutil.copy(PROJECT / part, stage / part)
        for wheel in (*fetch_wheels(platform, python), own_wheel(Path(folder))):
            shutil.copy(wheel, stage / "wheels")
        wheels = sorted(path.name for path in (stage / "wheels").iterdir())
        (stage / MANIFEST).write_text(manifest(platform, wheels, blenders), encoding="utf-8")
        version = re.search(r'^version = "(.+)"', (stage / MANIFEST).read_text("utf-8"), re.MULTILINE)[1]
        for path in stage.rglob("*"):
            os.utime(path, (EPOCH, EPOCH))
        target = destination / f"w2w-{version}-blender-{span(python, blenders)}-{platform}.zip"
        blender_tool("validate", str(stage))
        blender_tool("build", "--source-dir", str(stage), "--output-filepath", str(target))
    return target


def span(python: str, blenders: tuple[str, str]) -> str:
    """The Blenders that a zip is for, as its name says them."""
    return SPANS[python] if blenders == SERIES.get(python) else f"of-python{python}"


def own_wheel(folder: Path) -> Path:
    """W2W itself as a wheel, without its web app."""
    tree = folder / "tree"
    ignore = shutil.ignore_patterns("__pycache__", "build", "web", ".*", *LEFT_TO_PIP)
    for part in ("assets", "blender_addon"):
        shutil.copytree(PROJECT / part, tree / part, ignore=ignore)
    for part in ("README.md", "LICENSE", "setup.py"):
        shutil.copy(PROJECT / part, tree)
    packaging = (PROJECT / "pyproject.toml").read_text(encoding="utf-8").split("[tool.ruff]")[0]
    lines = packaging.splitlines(keepends=True)
    kept = [line for line in lines if "w2w.web" not in line]
    (tree / "pyproject.toml").write_text("".join(kept), encoding="utf-8")
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    environment = os.environ | {"SOURCE_DATE_EPOCH": str(EPOCH)}
    subprocess.run([*pip, str(tree), "-w", str(folder)], env=environment, check=True)
    return next(folder.glob("where_to_wear-*.whl"))


def manifest(platform: str, wheels: list[str], blenders: tuple[str, str]) -> str:
    """The manifest of one zip: the tree's own, with the wheels and without the build rules."""
    text = (PROJECT / MANIFEST).read_text(encoding="utf-8").split("[build]")[0]
    first, end = blenders
    most = f'blender_version_max = "{end}"\n' if end else ""
    series = f'blender_version_min = "{first}"\n{most}'
    text = re.sub(r"^blender_version_min = .*\n", series, text, flags=re.MULTILINE)
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
