# SPDX-License-Identifier: GPL-3.0-or-later
"""Without the library of exact distances patches are placed all the same, and the run says how."""

import io

import pytest
from rich.console import Console

from w2w.core.study import StudyConfig, place_patches
from w2w.headless.runs import patch_mode


@pytest.mark.parametrize(("is_there", "mode"), [(True, "exact"), (False, "fast")])
def test_patches_are_placed_as_the_libraries_allow(is_there, mode, monkeypatch, bundled_body):
    monkeypatch.setattr(patch_mode, "exact_is_available", lambda: is_there)
    said = io.StringIO()
    config = patch_mode.placeable(StudyConfig(patches=6), Console(file=said))
    assert config.patch_mode == config.as_dict()["patch_mode"] == mode
    assert ("pygeodesic" in said.getvalue()) is not is_there
    assert len(place_patches(bundled_body, config)) == 6
