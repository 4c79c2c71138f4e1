# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preferences decide."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import pytest

from w2w.core.study import StudyConfig
from w2w.core.threads import n_threads
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


def test_the_gpu_and_threads_are_w2ws_own_affair(monkeypatch: pytest.MonkeyPatch) -> None:
    before, config = dict(os.environ), StudyConfig(classifier="multi3net", seed=3)
    chosen = SimpleNamespace(threads=1, use_gpu=False)
    monkeypatch.setattr(preferences, "_preferences", lambda: chosen)
    kept_off = preferences.classifier_of(config)
    assert (kept_off.name, kept_off.device, kept_off.seed) == ("multi3net", "cpu", 3)
    assert preferences.classifier_of(replace(config, classifier="ridge")) == "ridge"
    chosen.use_gpu = True
    assert preferences.classifier_of(config) == "multi3net"
    usual = n_threads()
    preferences._limit_threads(chosen, bpy.context)
    assert n_threads() == 1
    chosen.threads = 0
    preferences._limit_threads(chosen, bpy.context)
    assert n_threads() == usual
    assert dict(os.environ) == before  # Cycles and other add-ons read it
