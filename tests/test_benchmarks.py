# SPDX-License-Identifier: GPL-3.0-or-later
"""Every benchmark and experiment can still be started: their foundations move, and nothing else runs them."""

from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
EXPERIMENTS = "blender_addon/w2w/studies/experiments"
FOLDERS = {"benchmarks": "benchmarks", EXPERIMENTS: "w2w.studies.experiments"}
MODULES = [f"{name}.{path.stem}" for folder, name in FOLDERS.items() for path in ROOT.glob(f"{folder}/*.py")]


@pytest.mark.parametrize("name", sorted(MODULES))
def test_it_is_imported(name):
    pytest.importorskip("bpy")
    import_module(name)
