# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preferences decide."""

from __future__ import annotations

import os
from types import SimpleNamespace

import bpy
import pytest

from w2w.core.threads import n_threads
from w2w.ui.jobs import preferences

pytestmark = pytest.mark.usefixtures("blender")


def test_threads_are_w2ws_own_affair(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    before, chosen = dict(os.environ), SimpleNamespace(threads=1)
    assert n_threads() == 2
    preferences._limit_threads(chosen, bpy.context)
    assert n_threads() == 1
    chosen.threads = 0
    preferences._limit_threads(chosen, bpy.context)
    assert n_threads() == 2
    assert dict(os.environ) == before  # Cycles and other add-ons read it
