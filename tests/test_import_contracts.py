# SPDX-License-Identifier: GPL-3.0-or-later
"""The linter refuses an import that leads up or sideways, and names its file and line."""

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PLANTED = {
    "Data flows one way": ("w2w/headless/runs/study.py", "w2w.ui.study.state"),
    "core, drawing and the report never see Blender": ("w2w/drawing/page.py", "bpy"),
    "core knows no console": ("w2w/core/findings/notes.py", "rich.console"),
    "The web app reaches Blender": ("w2w/web/uploads.py", "w2w.scene.heatmap"),
    "core's rooms follow the data": ("w2w/core/body/body.py", "w2w.core.findings.notes"),
    "selection": ("w2w/core/selection/headline.py", "w2w.core.selection.advice"),
    "study": ("w2w/core/study/variants.py", "w2w.core.study.needs"),
    "api": ("w2w/api/ranked.py", "w2w.api.rank"),
    "scene": ("w2w/scene/motion/takes.py", "w2w.scene.heatmap"),
    "ui": ("w2w/ui/jobs/text.py", "w2w.ui.panels.menus"),
    "headless": ("w2w/headless/stopping.py", "w2w.headless.app"),
    "web": ("w2w/web/guard.py", "w2w.web.serve"),
    "Studies stand on the product": ("w2w/api/ranking.py", "w2w_studies.paper.sets"),
    "Studies need no window": ("w2w_studies/paper/sets.py", "w2w.ui.study.state"),
    "studies": ("w2w_studies/rehab/curves.py", "w2w_studies.sweep.cases"),
}
"""Each contract by the beginning of its name, a module, and one that it must not import by that contract."""

CIRCLE = "w2w/drawing/body.py", "w2w.drawing.heatmap"
"""A module, and one that imports it."""

ROOTS = ("blender_addon/w2w", "packages/studies/w2w_studies")


@pytest.fixture(scope="module")
def said(tmp_path_factory) -> str:
    """What the linter says of a copy of the tree in which each module imports what it must not."""
    tree = tmp_path_factory.mktemp("planted")
    for root in ROOTS:
        shutil.copytree(ROOT / root, tree / Path(root).name, ignore=shutil.ignore_patterns("__pycache__"))
    for file, module in (*PLANTED.values(), CIRCLE):
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


def broken(said: str, contract: str) -> str:
    """What the linter says of one contract that is not kept."""
    parts = re.split(r"\n(?=[^\n]+\n-{4,}\n)", said)
    return next((part for part in parts if part.startswith(contract)), "")


@pytest.mark.parametrize(("contract", "planted"), PLANTED.items())
def test_a_forbidden_import_is_refused_by_file_and_line(said, contract, planted):
    file, module = planted
    importer = file.removesuffix(".py").replace("/", ".")
    (path,) = (
        ROOT / root / Path(file).relative_to(Path(root).name)
        for root in ROOTS
        if file.startswith(f"{Path(root).name}/")
    )
    line = len(path.read_text(encoding="utf-8").splitlines()) + 2
    assert f"{importer} -> {module.partition('.console')[0]} (l.{line})" in broken(said, contract)


def test_every_contract_is_tried():
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    names = {contract["name"] for contract in settings["tool"]["importlinter"]["contracts"]}
    tried = {name for name in names if any(name.startswith(known) for known in (*PLANTED, "No circle"))}
    assert names == tried


def test_a_circle_is_refused(said):
    assert "No circle, in any room BROKEN" in said
    assert "w2w.drawing" in said.partition("No circle, in any room\n")[2]
