# SPDX-License-Identifier: GPL-3.0-or-later
"""The wheel that `pip install .` makes: one top-level name, whole, at work far from the tree."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import pytest

import w2w

ROOT = Path(__file__).resolve().parents[1]
NOT_THE_TREE = "import sys; sys.meta_path[:] = [one for one in sys.meta_path if 'Editable' not in str(one)]"
"""The environment of the tests has this tree installed, and would find in it what a wheel lacks."""
PARTS = ("pyproject.toml", "setup.py", "README.md", "LICENSE", "assets", "blender_addon", "packages")


@pytest.fixture(scope="module")
def wheels(made_once):
    """The product's wheel and that of the studies."""
    made = made_once("wheel", _make)
    return [next(made.glob(f"where_to_wear{name}-*.whl")) for name in ("", "_studies")]


def _make(folder):
    tree = folder / "tree"
    tree.mkdir()
    for part in PARTS:
        if (ROOT / part).is_dir():
            shutil.copytree(ROOT / part, tree / part, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            shutil.copy(ROOT / part, tree)
    pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "--no-build-isolation"]
    for package in (tree, tree / "packages/studies"):
        subprocess.run([*pip, str(package), "-w", str(folder)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def installed(wheels, tmp_path_factory):
    """A folder to import from, with nothing of the tree on the path."""
    folder = tmp_path_factory.mktemp("wheel") / "installed"
    for wheel in wheels:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(folder)
    return folder


def python(installed, *arguments):
    """Python with the wheel before an editable install, from a folder that is not the tree."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=installed.parent,
        env=environment | {"PYTHONPATH": str(installed), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.slow
def test_each_wheel_has_one_name_and_every_file(wheels):
    product, studies = map(_names, wheels)
    assert wheels[0].name.startswith(f"where_to_wear-{w2w.__version__}-")
    for names, package in ((product, "blender_addon/w2w"), (studies, "packages/studies/w2w_studies")):
        tree = (ROOT / package).parent
        assert {name.split("/")[0] for name in names} == {Path(package).name}
        assert {path.relative_to(tree).as_posix() for path in (ROOT / package).rglob("*.py")} <= names
    templates = (
        f"templates/{name}" for name in ("body.npz", "demo.npz", "w2w_windows.py", "parquet_card.md")
    )
    others = ("report/templates/page.html", "py.typed", "__init__.pyi")
    assert {f"w2w/{name}" for name in (*templates, *others)} <= product
    assert {f"w2w_studies/placements/paper_{name}.csv" for name in ("activities", "claims")} <= studies
    assert not [name for name in product if "make_body" in name]


def _names(wheel):
    with zipfile.ZipFile(wheel) as archive:
        return {name for name in archive.namelist() if ".dist-info/" not in name}


def test_the_version_is_written_once_for_all():
    version = w2w.__version__
    assert tomllib.loads((ROOT / "blender_manifest.toml").read_text())["version"] == version
    studies = tomllib.loads((ROOT / "packages/studies/pyproject.toml").read_text())
    assert studies["project"]["version"] == version
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text()
    named = re.findall(r"w2w-(\d[\d.]*)-", (ROOT / "docs" / "engineer.md").read_text(encoding="utf-8"))
    assert set(named) == {version}


def test_a_type_checker_sees_every_public_name():
    lines = [line for line in w2w._STUB.body if isinstance(line, ast.ImportFrom)]
    assert all(each.asname == each.name for line in lines for each in line.names)  # else it is private


FAR_FROM_THE_TREE = """
import pathlib, w2w
from typer.testing import CliRunner
from w2w.headless.app import APP
from w2w.headless.start import main
print(pathlib.Path(w2w.__file__).parts[-3:], len(w2w.sample_patches(w2w.Body.bundled(), 8).names))
for command in ("status", "tables"):  # the second is one of the studies
    done = CliRunner().invoke(APP, [command, "nowhere"])
    print(done.exit_code, "nowhere" in done.output)
main()
"""


@pytest.mark.slow
def test_it_and_its_command_work_far_from_the_tree(installed):
    done = python(installed, "-c", FAR_FROM_THE_TREE, "sensors")
    assert done.returncode == 0, done.stdout + done.stderr
    first, status, tables, *sensors = done.stdout.splitlines()
    assert first == "('installed', 'w2w', '__init__.py') 8"
    assert (status, tables) == ("2 True", "2 True")
    assert any("bmi270" in line for line in sensors)


@pytest.mark.slow
def test_without_the_studies_it_works_and_says_how_to_get_them(installed):
    bare = installed.parent / "without studies"
    shutil.copytree(installed, bare, ignore=shutil.ignore_patterns("w2w_studies", "entry_points.txt"))
    start = f"{NOT_THE_TREE}; from w2w.headless.start import main; main()"
    assert python(bare, "-c", start, "sensors").returncode == 0
    listed = python(bare, "-c", start, "--help").stdout
    assert "calibrate" in listed
    assert "validate" not in listed
    for words in (("tables", "RESULTS"), ("validate", "mhad", "--help"), ("study",), ("demo-library", "-o")):
        done = python(bare, "-c", start, *words)
        assert done.returncode == 2
        assert "W2W's studies are a package of their own" in done.stderr
        assert "pip install" in done.stderr
