# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo, Edit Mode, deleted empties and deleted bodies leave a study whole, or take it away whole."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.colours import score_range
from w2w.scene.base.patches import PATCH, empties_by_patch, patch_empties
from w2w.scene.heatmap import heatmap_names
from w2w.ui.files import upkeep
from w2w.ui.jobs import jobs
from w2w.ui.study.scores import scale_of
from w2w.ui.study.state import current_body, patches_of, utility_of

from .made_study import make_study, take_through

pytestmark = pytest.mark.usefixtures("blender")


def colours(body: bpy.types.Object) -> np.ndarray:
    """Colours of the heatmap that is shown."""
    attribute = body.data.color_attributes.active_color
    values = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color_srgb", values)
    return values


def edit_mode(body: bpy.types.Object, on: bool) -> None:
    """Go into Edit Mode or leave it."""
    bpy.context.view_layer.objects.active = body
    bpy.ops.object.mode_set(mode="EDIT" if on else "OBJECT")


def test_colours_changed_in_edit_mode_follow_when_it_is_left(library: Path) -> None:
    body = make_study(library)
    body.w2w.colour_map = "magma"
    body.w2w.scores = "ON_THESE"
    expected = colours(body)
    body.w2w.colour_map = "viridis"
    body.w2w.scores = "EXPECTED"
    assert (colours(body) != expected).any()
    edit_mode(body, True)
    body.w2w.colour_map = "magma"
    body.w2w.scores = "ON_THESE"
    assert len(heatmap_names(body)) == 4
    edit_mode(body, False)
    bpy.context.view_layer.update()
    np.testing.assert_array_equal(colours(body), expected)
    assert body.data.color_attributes.active_color.name == "F1 on these clips"


def test_activities_ticked_in_edit_mode_count_at_once(library: Path) -> None:
    body = make_study(library)
    edit_mode(body, True)
    body.w2w.activities[0].part = "LEFT_OUT"
    best = utility_of(body.w2w).expected_f1[:, 1:].mean(axis=1).max()
    assert body.w2w.regions[0].f1 == pytest.approx(best, abs=1e-6)
    edit_mode(body, False)


def test_use_active_mesh_waits_for_object_mode(library: Path) -> None:
    body = make_study(library, "patches")
    edit_mode(body, True)
    assert not bpy.ops.w2w.use_mesh.poll()
    edit_mode(body, False)
    assert bpy.ops.w2w.use_mesh.poll()


def test_undo_and_redo_take_the_message_away_and_fold_patches_that_come_back(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folded: list[bool] = []
    monkeypatch.setattr(upkeep, "fold_soon", lambda: folded.append(True))
    bpy.ops.ed.undo_push(message="before")
    take_through(library, "patches")
    bpy.ops.ed.undo_push(message="Place Patches")
    assert jobs.message.text.startswith("Placed 24 spots")
    bpy.ops.ed.undo()
    assert jobs.message is None
    jobs.message = jobs.Message("Ranked", False)
    assert not folded
    bpy.ops.ed.redo()
    assert jobs.message is None
    assert folded == [True]


def test_a_message_does_not_outlive_its_file(library: Path, tmp_path: Path) -> None:
    make_study(library, "patches")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "study.blend"))
    jobs.message = jobs.Message("Ranked", False)
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "study.blend"))
    assert jobs.message is None


def test_deleted_empties_shift_no_other_patch(library: Path) -> None:
    body = make_study(library)
    study = body.w2w
    for empty in patch_empties(study.patch_collection)[:3]:
        bpy.data.objects.remove(empty)
    last = len(patches_of(body)) - 1
    assert bpy.ops.w2w.select_patch(patch=last) == {"FINISHED"}
    assert study.picked == last
    assert bpy.ops.w2w.select_patch(patch=1) == {"FINISHED"}
    study.target = 1.0
    marked = {item[PATCH] for item in study.chosen_collection.objects}
    assert marked == {row.patch for row in study.chosen} - {0, 1, 2}
    study.patch_size = 0.02
    assert {item[PATCH] for item in study.chosen_collection.objects} == marked


def test_a_copied_empty_stands_for_no_patch(library: Path) -> None:
    body = make_study(library)
    original = patch_empties(body.w2w.patch_collection)[7]
    body.w2w.patch_collection.objects.link(original.copy())
    assert empties_by_patch(body.w2w.patch_collection)[7] is original
    body.w2w.target = 1.0
    marked = [item[PATCH] for item in body.w2w.chosen_collection.objects]
    assert sorted(marked) == sorted(row.patch for row in body.w2w.chosen)


def delete(item: bpy.types.Object) -> None:
    """Delete an object as X does."""
    bpy.context.view_layer.objects.active = item
    for other in bpy.context.selected_objects:
        other.select_set(False)
    item.select_set(True)
    assert bpy.ops.object.delete() == {"FINISHED"}


def remove(item: bpy.types.Object) -> None:
    """Remove an object as a script does."""
    bpy.data.objects.remove(item)


@pytest.mark.parametrize("how", [delete, remove])
def test_a_deleted_body_takes_its_patches_along_and_no_others(library: Path, how: object) -> None:
    body = make_study(library)
    other = make_study(library, "patches")
    bpy.context.scene.w2w.body = body
    own = bpy.data.objects.new("mine", None)
    bpy.context.scene.collection.objects.link(own)
    kept = {item.name for item in other.w2w.patch_collection.objects}
    bpy.context.view_layer.update()
    how(body)
    bpy.context.view_layer.update()
    assert bpy.app.timers.is_registered(upkeep.take_along)
    assert upkeep.take_along() is None
    assert {item.name for item in bpy.data.objects if PATCH in item} == kept
    assert "mine" in bpy.data.objects
    assert len(bpy.data.collections) == 3  # two bodies, one with patches
    assert bpy.context.scene.w2w.body is None


@pytest.mark.parametrize("beside", [False, True])
def test_unlinking_the_collection_of_a_body_deletes_nothing(library: Path, beside: bool) -> None:
    body = make_study(library)
    if beside:
        assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
    before, chosen = sorted(bpy.data.objects.keys()), bpy.context.scene.collection.children
    (home,) = body.users_collection
    bpy.context.view_layer.update()
    chosen.unlink(home)
    bpy.context.view_layer.update()
    assert upkeep.take_along() is None
    assert sorted(bpy.data.objects.keys()) == before
    assert current_body(bpy.context) is None
    chosen.link(home)
    bpy.context.view_layer.update()
    assert current_body(bpy.context) is body
    assert len(body.w2w.patch_collection.objects) == 24


def test_a_body_in_an_unlinked_collection_is_deleted_all_the_same(library: Path) -> None:
    body = make_study(library, "patches")
    (home,) = body.users_collection
    bpy.context.scene.collection.children.unlink(home)
    home.objects.unlink(body)
    upkeep.take_along()
    assert not [item for item in bpy.data.objects if PATCH in item]


def test_an_empty_that_was_set_free_stays(library: Path) -> None:
    body = make_study(library, "patches")
    free = patch_empties(body.w2w.patch_collection)[5]
    free.parent, free.parent_type = None, "OBJECT"
    delete(body)
    upkeep.take_along()
    assert [item for item in bpy.data.objects if PATCH in item] == [free]


def test_patches_stay_where_nothing_was_deleted(library: Path) -> None:
    body = make_study(library)
    assert upkeep.take_along() is None
    assert len(body.w2w.patch_collection.objects) == 24
    assert bpy.context.scene.w2w.body is body


def ends(body: bpy.types.Object) -> tuple[float, float]:
    """F1 at the ends of the colours."""
    scale = scale_of(body.w2w, utility_of(body.w2w))
    return scale.low, scale.high


def test_a_fixed_range_begins_as_the_range_of_the_scores(library: Path) -> None:
    body = make_study(library)
    utility = utility_of(body.w2w)
    scores = utility.expected_f1
    body.w2w.fix_range = True
    assert ends(body) == pytest.approx(score_range(scores), abs=1e-6)
    body.w2w.range_low, body.w2w.range_high = 0.2, 0.9
    body.w2w.fix_range = False
    body.w2w.fix_range = True
    assert ends(body) == pytest.approx((0.2, 0.9))


def test_patches_are_folded_where_a_file_is_opened_into_other_windows(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folded: list[str] = []
    monkeypatch.setattr(upkeep, "fold_soon", lambda: folded.append("folded"))
    make_study(library, "motions patches")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "mine.blend"))
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    folded.clear()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "mine.blend"), load_ui=False)
    assert folded == ["folded"]
