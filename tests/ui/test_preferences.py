# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preferences decide."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

from w2w.ui.jobs import preferences

pytestmark = pytest.mark.usefixtures("blender")


def test_pytorch_is_found_in_a_folder_of_one_s_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "elsewhere"
    (folder / "torch").mkdir(parents=True)
    (folder / "torch" / "__init__.py").touch()
    (folder / "torch-9.8.7.dist-info").mkdir()
    (folder / "torch-9.8.7.dist-info" / "METADATA").write_text("Name: torch\nVersion: 9.8.7\n")
    monkeypatch.setattr(sys, "path", [path for path in sys.path if not (Path(path) / "torch").exists()])
    monkeypatch.delitem(sys.modules, "torch", raising=False)
    assert preferences.torch_status()[0] is False
    assert "pip install --target" in preferences.torch_status()[1]
    chosen = SimpleNamespace(torch_folder=str(folder), use_gpu=False)
    preferences._find_torch(chosen, bpy.context)
    assert preferences.torch_status() == (True, f"PyTorch 9.8.7 in {folder / 'torch'}")
    preferences.leave_torch_folders()
    assert preferences.torch_status()[0] is False


def test_the_gpu_can_be_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(preferences.GPU_VARIABLE, raising=False)
    preferences._choose_gpu(SimpleNamespace(use_gpu=False), bpy.context)
    assert os.environ[preferences.GPU_VARIABLE] == ""
    preferences._choose_gpu(SimpleNamespace(use_gpu=True), bpy.context)
    assert preferences.GPU_VARIABLE not in os.environ
