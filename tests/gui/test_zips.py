# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's zips: installed into bare Blender modules, and whole for every platform that was built."""

from __future__ import annotations

import io
import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tools.check_zip import problems, unpacked

PROJECT = Path(__file__).resolve().parents[2]
ZIPS = sorted((PROJECT / "dist").glob("w2w-*-blender-*.zip"))
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
    show = [python, "-c", "import sys; print(*sys.path[1:], sep='\\n')"]
    places = subprocess.run(show, capture_output=True, text=True, check=True).stdout.splitlines()
    folder.mkdir()
    for name in ("bpy", *BLENDERS_OWN):
        found = [place for place in places if Path(place, name).exists()]
        if found:
            (folder / name).symlink_to(Path(found[0], name))
    return folder


@pytest.mark.parametrize("series", PYTHONS)
def test_the_zip_installs_into_a_bare_blender_and_ranks(series: str, tmp_path: Path) -> None:
    zips = [path for path in ZIPS if path.name.endswith("-blender-4.3-to-5.0-linux-x64.zip")]
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
    assert report["heatmaps"] == 4  # and the mannequin's colours
    assert report["has_preferences"]
    assert report["best_expected_f1"] > 0.65  # of two activities, from six clips


@pytest.mark.parametrize("path", ZIPS, ids=lambda path: path.stem)
def test_a_zip_keeps_the_rules(path: Path) -> None:
    assert problems(path) == []


def packed(content: dict[str, bytes]) -> bytes:
    """A zip of files."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return stream.getvalue()


def spoilt(content: dict[str, bytes], name: str, old: bytes, new: bytes) -> dict[str, bytes]:
    """Files, of which one is changed or, where there is nothing to change, added."""
    return content | {name: content[name].replace(old, new, 1) if old else new}


@pytest.fixture(scope="module")
def content() -> dict[str, bytes]:
    """The files of a zip that keeps the rules."""
    if not ZIPS:
        pytest.skip("no extension here: run 'make extension' first")
    return unpacked(ZIPS[0])


def check(content: dict[str, bytes], folder: Path) -> str:
    """What is wrong with a zip of these files, in one text."""
    path = folder / ZIPS[0].name
    path.write_bytes(packed(content))
    return "; ".join(problems(path))


WHEEL = packed({"lib-1.dist-info/METADATA": b"Name: lib"})


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("blender_manifest.toml", b'platforms = ["', b'platforms = ["solaris-', "names the platforms"),
        ("blender_manifest.toml", b"./wheels/where_to_wear", b"./wheels/another", "names other wheels"),
        ("blender_manifest.toml", b'"2025-2026 ', b'"', "needs copyright"),
        ("blender_manifest.toml", b'"SPDX:CC0-1.0"', b'"SPDX:CC-BY-4.0"', "which the platform does not take"),
        ("blender_manifest.toml", b' works best"', b' works best."', "ends in punctuation"),
        ("__init__.py", b"import sys\n", b"import sys\nsys.path.append('x')\n", "edits sys.path"),
        ("headless/run.py", b"", b"x", "it has, or lacks, headless/run.py"),
        ("wheels/torch-2.13.0-py3-none-any.whl", b"", WHEEL, "stays out of the zip"),
        ("wheels/lib-1-cp39-cp39-win_amd64.whl", b"", WHEEL, "is for another platform"),
    ],
)
def test_a_zip_that_breaks_a_rule_is_told(
    file: str, old: bytes, new: bytes, said: str, content: dict[str, bytes], tmp_path: Path
) -> None:
    assert said in check(spoilt(content, file, old, new), tmp_path)


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("w2w/ui/more.py", b"", b'os.environ["OMP_NUM_THREADS"] = "1"', "the environment of all of Blender"),
        ("w2w/web/app.py", b"", b"x", "belongs to the web app"),
        ("w2w/templates/smpl_numbering.npz", b"", b"x", "whose licence the platform does not take"),
        ("headless/run.py", b"", b"x", "installs other packages"),
        ("METADATA", b"Requires-Dist: loky", b"Requires-Dist: nothere", "need nothere"),
    ],
)
def test_a_wheel_of_ours_that_breaks_a_rule_is_told(
    file: str, old: bytes, new: bytes, said: str, content: dict[str, bytes], tmp_path: Path
) -> None:
    (own,) = [name for name in content if name.startswith("wheels/where_to_wear-")]
    wheel = unpacked(io.BytesIO(content[own]))
    inside = next((name for name in wheel if name.endswith(f".dist-info/{file}")), file)
    changed = content | {own: packed(spoilt(wheel, inside, old, new))}
    assert said in check(changed, tmp_path)
