# SPDX-License-Identifier: GPL-3.0-or-later
"""A body that is appended or linked into another file brings its study; a linked one is only looked at."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from w2w.ui.files.upkeep import take_up
from w2w.ui.study import state
from w2w.ui.viewport.overlay import is_coloured

from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def bring(library: Path, folder: Path, link: bool) -> bpy.types.Object:
    """A ranked body, appended or linked into an empty file."""
    name = make_study(library).name
    path = folder / "other.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    with bpy.data.libraries.load(str(path), link=link) as (_, brought):
        brought.objects = [name]
    bpy.context.scene.collection.objects.link(brought.objects[0])
    take_up()
    return bpy.context.scene.w2w.body


def test_an_appended_study_comes_up_by_itself_and_goes_on(library: Path, tmp_path: Path) -> None:
    body = bring(library, tmp_path, link=False)
    assert len(state.patches_of(body)) == N_PATCHES
    assert state.outdated(body) == ""
    spaces = [area.spaces.active for area in bpy.context.window.screen.areas]
    assert all(is_coloured(space.shading) for space in spaces if space.type == "VIEW_3D")
    body.w2w.patch_count = N_PATCHES - 4
    assert bpy.ops.w2w.place_patches() == {"FINISHED"}
    assert len(state.patches_of(body)) == N_PATCHES - 4


def test_a_linked_study_is_shown_and_offers_no_change(library: Path, tmp_path: Path) -> None:
    body = bring(library, tmp_path, link=True)
    assert body.library is not None
    assert state.is_ranked(body)
    assert state.missing_for_patches(body) == state.LINKED
    assert state.outdated(body) == ""
    for name in ("run_all", "place_patches", "bake_signals", "rank_patches", "choose_sensors"):
        assert not getattr(bpy.ops.w2w, name).poll()


def test_a_study_linked_as_an_instance_of_its_collection_says_to_append_it(
    library: Path, tmp_path: Path
) -> None:
    home = make_study(library).users_collection[0].name
    path = tmp_path / "other.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert state.missing_body(bpy.context.scene) == "Add a body first"
    with bpy.data.libraries.load(str(path), link=True) as (_, brought):
        brought.collections = [home]
    instance = bpy.data.objects.new(home, None)
    instance.instance_type, instance.instance_collection = "COLLECTION", brought.collections[0]
    bpy.context.scene.collection.objects.link(instance)
    assert state.missing_body(bpy.context.scene) == state.LINKED
