# SPDX-License-Identifier: GPL-3.0-or-later
"""Saved files: complete with the extension, plain without it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.ranking.utility import UtilityMap
from w2w.scene.files import study_file
from w2w.ui.study import signal_cache
from w2w.ui.study.state import BAKED, bake_settings, patches_of, state_of, utility_of

from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender")


def test_a_saved_file_reopens_complete(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    utility, triangles = utility_of(body.w2w), patches_of(body).triangles
    chosen = [(place.patch, place.label) for place in body.w2w.chosen]
    path = str(tmp_path / "study.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    study_file._unpacked.clear()
    bpy.ops.wm.open_mainfile(filepath=path)
    body = bpy.context.scene.w2w.body
    np.testing.assert_array_equal(utility_of(body.w2w).f1, utility.f1)
    np.testing.assert_array_equal(patches_of(body).triangles, triangles)
    assert [(place.patch, place.label) for place in body.w2w.chosen] == chosen
    assert all(signal_cache.has(clip) for clip in body.w2w.clips)


@pytest.mark.slow
def test_baking_anew_after_save_as_leaves_the_first_file_its_signals(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "motions patches signals")
    first, second = str(tmp_path / "first.blend"), str(tmp_path / "second.blend")
    bpy.ops.wm.save_as_mainfile(filepath=first)
    before = signal_cache.recording(body.w2w.clips[4]).acc
    bpy.ops.wm.save_as_mainfile(filepath=second)
    body.w2w.sensor = "watch"
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    after = signal_cache.recording(body.w2w.clips[4]).acc
    assert not np.array_equal(after, before)
    bpy.ops.wm.save_mainfile()
    for path, expected in ((first, before), (second, after)):
        signal_cache._recordings.clear()
        bpy.ops.wm.open_mainfile(filepath=path)
        study = bpy.context.scene.w2w.body.w2w
        assert all(state_of(clip, bake_settings(study)) == BAKED for clip in study.clips)
        np.testing.assert_array_equal(signal_cache.recording(study.clips[4]).acc, expected)


@pytest.mark.slow
def test_without_the_extension_heatmaps_are_plain_colour_attributes(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    body.w2w.view = "A2"
    expected = {attribute.name: pixels(attribute) for attribute in body.data.color_attributes}
    path = tmp_path / "study.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    plain = subprocess.run(
        [sys.executable, Path(__file__).with_name("read_plainly.py"), path, tmp_path / "found.npz"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert plain.returncode == 0, plain.stderr
    with np.load(tmp_path / "found.npz") as found:
        assert found["active"] == f"Expected F1: {body.w2w.activities[1].name}"
        assert found["empties"] == N_PATCHES
        assert set(found["names"]) == set(expected)
        for name, colours in expected.items():
            np.testing.assert_array_equal(found[name], colours)


def test_damaged_results_are_refused(library: Path) -> None:
    text = make_study(library).w2w.utility_text
    for damaged in (text[:-400], "eJ" + text[6:], "nothing of the kind", ""):
        with pytest.raises(ValueError, match="packed results are damaged"):
            study_file.unpack(damaged, damaged.__str__, UtilityMap.load)


def pixels(attribute: bpy.types.Attribute) -> np.ndarray:
    """Colours of an attribute."""
    values = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color", values)
    return values
