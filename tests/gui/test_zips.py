# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zips: installed into bare Blender modules, and whole for every platform that was built."""

from __future__ import annotations

import email
import io
import json
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PROJECT = Path(__file__).resolve().parents[2]
ZIPS = sorted((PROJECT / "dist").glob("w2w-*.zip"))
PYTHONS = {
    "4.5": Path(sys.executable),
    "5.0": Path(os.environ.get("W2W_BPY5_PYTHON", PROJECT / ".venv-blender-5" / "bin" / "python")),
}
"""Pythons that have a Blender module; the extension must bring all else itself."""

TIMEOUT_S = 600
PIP_ONLY = {"scikit-learn"}
"""What W2W's own metadata asks for and the extension does without."""

LARGEST = 60e6
"""Bytes of a zip: who tries the extension waits for its download."""

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
    zips = [path for path in ZIPS if path.name.endswith("-linux-x64-python3.11.zip")]
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
    assert report["has_preferences"]
    assert report["best_expected_f1"] > 0.65  # of two activities, from six clips


@pytest.mark.parametrize("path", ZIPS, ids=lambda path: path.stem)
def test_a_zip_holds_every_wheel_for_the_pythons_of_its_platform(path: Path) -> None:
    platform, _, python = path.stem.split("-", 2)[2].partition("-python")
    pythons = [f"cp{python.replace('.', '')}"]
    tag = {"linux": "manylinux", "windows": "win_amd64", "macos": "macosx"}[platform.split("-")[0]]
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    assert len(names) == len(set(names))
    assert manifest["platforms"] == [platform]
    wheels = sorted(Path(name).name for name in names if name.endswith(".whl"))
    assert wheels == sorted(Path(name).name for name in manifest["wheels"])
    compiled = [wheel for wheel in wheels if "-none-any" not in wheel]
    for package in {"scipy", "matplotlib", *(wheel.split("-")[0] for wheel in compiled)}:
        of_package = [wheel for wheel in compiled if wheel.startswith(f"{package}-")]
        assert [re.search(r"-(cp3\d+)-", wheel)[1] for wheel in of_package] == pythons
        assert all(tag in wheel for wheel in of_package)
    others = {Path(name).name for name in names if not name.startswith("wheels/")}
    assert others == {"blender_manifest.toml", "__init__.py", "LICENSE"}
    assert path.stat().st_size < LARGEST
    left_out = ("scikit_learn", "trimesh", "pydantic", "cmap", "pygeodesic", "torch")
    assert not [wheel for wheel in wheels if wheel.lower().startswith(left_out)]


@pytest.mark.parametrize("path", ZIPS, ids=lambda path: path.stem)
def test_w2w_is_a_wheel_among_them_without_its_studies(path: Path) -> None:
    with zipfile.ZipFile(path) as archive:
        (own,) = [name for name in archive.namelist() if name.startswith("wheels/where_to_wear-")]
        with zipfile.ZipFile(io.BytesIO(archive.read(own))) as wheel:
            names = wheel.namelist()
            data = [wheel.read(name).decode() for name in names if name.endswith("entry_points.txt")]
    tops = {name.split("/")[0] for name in names if ".dist-info/" not in name}
    assert tops == {"w2w"}
    page, demo = "w2w/headless/reports/report_page/page.html", "w2w/templates/demo.npz"
    assert {page, demo, "w2w/command_line.py", "w2w/ui/panels/presets/w2w/study/watch.py"} & {*names} >= {
        page,
        demo,
    }
    assert not [name for name in names if name.startswith("w2w/studies")]
    assert not [text for text in data if "studies" in text]


@pytest.mark.parametrize("path", ZIPS, ids=lambda path: path.stem)
def test_the_wheels_of_a_zip_need_nothing_that_is_not_in_it_but_numpy(path: Path) -> None:
    needed, there = set(), {"numpy"}
    system = "Windows" if "windows" in path.stem else "Linux"
    with zipfile.ZipFile(path) as archive:
        for wheel in (name for name in archive.namelist() if name.endswith(".whl")):
            with zipfile.ZipFile(io.BytesIO(archive.read(wheel))) as content:
                (about,) = [name for name in content.namelist() if name.endswith(".dist-info/METADATA")]
                metadata = email.message_from_bytes(content.read(about))
            there.add(canonicalize_name(metadata["Name"]))
            for line in metadata.get_all("Requires-Dist", []):
                requirement = Requirement(line)
                given = {"extra": "", "platform_system": system}
                if requirement.marker is None or requirement.marker.evaluate(given):
                    needed.add(canonicalize_name(requirement.name))
    assert needed - PIP_ONLY <= there
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    own = {canonicalize_name(Requirement(line).name) for line in project["dependencies"]}
    assert own - PIP_ONLY <= there
