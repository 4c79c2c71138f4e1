# SPDX-License-Identifier: GPL-3.0-or-later
"""A parameter declared in one file is known at every door, and at none once its declaration is taken out."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("bpy")
pytest.importorskip("starlette")

ROOT = Path(__file__).resolve().parents[1]
NAME = "trial_number"
DECLARATION = f"""
    {NAME}: float = parameter(
        1.0, "A number that is tried.", title="Trial", least=0, most=4, group=SIGNALS, web=True, panel="bands"
    )
"""
BEFORE = "\n    def __post_init__(self)"


@pytest.mark.later
def test_one_declaration_opens_every_door(tmp_path):
    shutil.copytree(
        ROOT / "blender_addon", tmp_path / "blender_addon", ignore=shutil.ignore_patterns("__pycache__")
    )
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    config = tmp_path / "blender_addon/w2w/core/study/config.py"
    as_it_is = config.read_text(encoding="utf-8")
    config.write_text(as_it_is.replace(BEFORE, DECLARATION + BEFORE, 1), encoding="utf-8")
    assert doors(tmp_path) == ["command_line", "file_of_options", "panel", "web", "python", "signals_key"]
    config.write_text(as_it_is, encoding="utf-8")
    assert doors(tmp_path) == []


def doors(tree: Path) -> list[str]:
    """Doors of a copy of the tree that know the parameter."""
    path = os.pathsep.join((str(tree / "blender_addon"), str(ROOT)))
    done = subprocess.run(
        [sys.executable, "-m", "tests.doors", NAME],
        cwd=tree, env=os.environ | {"PYTHONPATH": path}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode in (0, -6, -11), done.stderr  # Blender's module may stumble as it leaves
    found = json.loads(done.stdout.strip().splitlines()[-1])
    assert found["from"].startswith(str(tree))
    return found["known"]
