# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zips: installed into bare Blender modules, and whole for every platform that was built."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
ZIPS = sorted((PROJECT / "dist").glob("w2w-*.zip"))
PYTHONS = {
    "4.5": Path(sys.executable),
    "5.0": Path(os.environ.get("W2W_BPY5_PYTHON", PROJECT / ".venv-blender-5" / "bin" / "python")),
}
"""Pythons that have a Blender module; the extension must bring all else itself."""

TIMEOUT_S = 600
BLENDERS_OWN = {"numpy", "numpy.libs"}
"""What Blender has: all that the bare folder gets besides `bpy`."""

pytestmark = pytest.mark.slow


def bare_folder(python: Path, folder: Path) -> Path:
    """A folder to import from with links to `bpy` and numpy alone, as Blender has them."""
    where = subprocess.run(
        [python, "-c", "import importlib.util as i; print(i.find_spec('bpy').submodule_search_locations[0])"],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.strip()
    folder.mkdir()
    for name in ("bpy", *BLENDERS_OWN):
        if (Path(where).parent / name).exists():
            (folder / name).symlink_to(Path(where).parent / name)
    return folder


@pytest.mark.parametrize("series", PYTHONS)
def test_the_zip_installs_into_a_bare_blender_and_ranks(series: str, tmp_path: Path) -> None:
    zips = [path for path in ZIPS if "linux-x64" in path.name]
    if not zips:
        pytest.skip("no extension here: run 'make extension' first")
    if not PYTHONS[series].exists():
        pytest.skip(f"no Blender {series} module here: run 'make test-blender-5' first")
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    environment |= {
        "BLENDER_USER_RESOURCES": str(tmp_path / "resources"),
        "PYTHONPATH": str(bare_folder(PYTHONS[series], tmp_path / "bare")),
    }
    done = subprocess.run(
        [PYTHONS[series], "-S", Path(__file__).with_name("installed.py"), zips[-1], tmp_path / "report.json"],
        env=environment,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    assert done.returncode == 0, (done.stdout + done.stderr)[-3000:]
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["blender"].startswith(series)
    outside = {name: file for name, file in report["modules"].items() if str(tmp_path) not in file}
    assert not outside
    assert report["baked"] == 6
    assert report["heatmaps"] == 3
    assert report["best_f1"] > 0.9


@pytest.mark.parametrize("path", ZIPS, ids=lambda path: path.stem)
def test_a_zip_holds_every_wheel_for_both_pythons_of_its_platform(path: Path) -> None:
    platform = path.stem.split("-", 2)[2]
    tag = {"linux": "manylinux", "windows": "win_amd64", "macos": "macosx"}[platform.split("-")[0]]
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert len(names) == len(set(names))
    assert manifest["platforms"] == [platform]
    wheels = sorted(Path(name).name for name in names if name.endswith(".whl"))
    assert wheels == sorted(Path(name).name for name in manifest["wheels"])
    for package in ("scipy", "scikit_learn", "pygeodesic"):
        of_package = [wheel for wheel in wheels if wheel.startswith(f"{package}-")]
        assert sorted(re.search(r"-(cp3\d+)-", wheel)[1] for wheel in of_package) == ["cp311", "cp313"]
        assert all(tag in wheel for wheel in of_package)
