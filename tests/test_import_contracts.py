# SPDX-License-Identifier: GPL-3.0-or-later
"""The linter refuses an import that leads up or sideways, and names its file and line."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PLANTED = {
    "w2w/ui/jobs/text.py": "w2w.headless.commands.report",
    "w2w/core/wording.py": "w2w.scene.heatmap",
    "w2w/scene/heatmap.py": "w2w.ui.study.state",
    "w2w/api/ranking.py": "w2w_studies.paper.sets",
    "w2w/headless/runs/study.py": "w2w.ui.study.state",
    "w2w/drawing/page.py": "bpy",
}
"""Modules, each with one that it must not import."""

CIRCLE = "w2w/drawing/body.py", "w2w.drawing.heatmap"
"""A module, and one that imports it."""


@pytest.fixture(scope="module")
def said(tmp_path_factory) -> str:
    """What the linter says of a copy of the tree in which each module imports what it must not."""
    tree = tmp_path_factory.mktemp("planted")
    for package in (ROOT / "blender_addon/w2w", ROOT / "packages/studies/w2w_studies"):
        shutil.copytree(package, tree / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    for file, module in (*PLANTED.items(), CIRCLE):
        with (tree / file).open("a", encoding="utf-8") as stream:
            stream.write(f"\nimport {module}\n")
    lint = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    done = subprocess.run(
        [sys.executable, "-c", lint, "--config", ROOT / "pyproject.toml", "--no-cache"],
        cwd=tree,
        env=os.environ | {"PYTHONPATH": str(tree), "COLUMNS": "200"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize(("file", "module"), PLANTED.items())
def test_a_forbidden_import_is_refused_by_file_and_line(said, file, module):
    importer = file.removesuffix(".py").replace("/", ".")
    line = len((ROOT / "blender_addon" / file).read_text(encoding="utf-8").splitlines()) + 2
    assert f"{importer} -> {module} (l.{line})" in said


def test_a_circle_is_refused(said):
    assert "No circle, in any room BROKEN" in said
    assert "w2w.drawing" in said.partition("No circle, in any room\n")[2]
