# SPDX-License-Identifier: GPL-3.0-or-later
"""Two maps side by side: on one scale, named in one legend, saved with the file, gone with the body."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.colours import LEAST_SPAN, Scale
from w2w.scene.base.playback import spot_at
from w2w.scene.heatmap import BESIDE, DIFFERENCE
from w2w.ui.files import upkeep
from w2w.ui.panels import results as panel
from w2w.ui.study.scores import beside_of
from w2w.ui.study.state import patches_of, utility_of
from w2w.ui.viewport.framing import surface
from w2w.ui.viewport.legend import legend, owner_of

from .made_study import make_study
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

STEP = 1.1 / 255


def colours(item: bpy.types.Object) -> np.ndarray:
    """Colours that an object shows."""
    attribute = item.data.color_attributes.active_color
    values = np.empty(4 * len(attribute.data), dtype=np.float32)
    attribute.data.foreach_get("color_srgb", values)
    return values.reshape(-1, 4)[:, :3]


def copies() -> list[bpy.types.Object]:
    return [item for item in bpy.data.objects if BESIDE in item]


def test_two_activities_stand_side_by_side_on_one_scale(library: Path) -> None:
    body = make_study(library)
    study, utility, patches = body.w2w, utility_of(body.w2w), patches_of(body)
    alone = colours(body)
    assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
    study.view, study.beside_view = "A1", "A3"
    first, third = utility.expected_f1[:, 0], utility.expected_f1[:, 2]
    shared = Scale.of(np.concatenate([first, third]), LEAST_SPAN)
    np.testing.assert_allclose(colours(body), shared.colours(patches, first), atol=STEP)
    np.testing.assert_allclose(colours(study.beside), shared.colours(patches, third), atol=STEP)
    shown = legend(study, utility)
    assert (shown.name, shown.beside) == (utility.activities[0], utility.activities[2])
    assert (shown.low, shown.high) == pytest.approx((shared.low, shared.high))
    study.scores, study.colour_map = "ON_THESE", "magma"
    shared = Scale.of(utility.f1[:, [0, 2]], LEAST_SPAN, colour_map="magma")
    expected = shared.colours(patches, utility.f1[:, 2])
    np.testing.assert_allclose(colours(study.beside), expected, atol=STEP)
    study.scores, study.colour_map, study.view = "EXPECTED", "viridis", "MEAN"
    assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
    assert not copies()
    assert legend(study, utility).beside == ""
    np.testing.assert_allclose(colours(body), alone, atol=STEP)


def test_the_copy_stands_in_its_place_when_both_are_framed(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body, framed = make_study(library), []
    monkeypatch.setattr(panel, "frame", lambda items: framed.extend(map(surface, items)))
    assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
    np.testing.assert_array_equal(framed[1], surface(body.w2w.beside))


def test_it_follows_weights_and_takes_a_difference_s_place(library: Path) -> None:
    body = make_study(library)
    study = body.w2w
    study.view, study.minus = "A1", "A2"
    bpy.ops.w2w.side_by_side()
    assert study.minus == "NOTHING"
    assert DIFFERENCE not in body.data.color_attributes
    assert study.beside_view == "MEAN"
    before = colours(study.beside)
    study.activities[0].part = "BACKGROUND"
    assert (colours(study.beside) != before).any()
    bpy.ops.w2w.remove_patches()
    assert not copies()


def test_another_body_s_result_stands_beside_on_the_same_body(library: Path, finished_run: Path) -> None:
    body = make_study(library)
    assert bpy.ops.w2w.open_results(filepath=str(finished_run)) == {"FINISHED"}
    other = bpy.context.scene.w2w.body
    bpy.context.scene.w2w.body = body
    bpy.ops.w2w.side_by_side()
    study = body.w2w
    study.beside_body, study.beside_view = other, "A2"
    utility, theirs = utility_of(study), utility_of(other.w2w)
    assert legend(study, utility).beside == f"{theirs.activities[1]} ({other.name})"
    both = np.concatenate([utility.expected_mean, theirs.expected_f1[:, 1]])
    shared = Scale.of(both, LEAST_SPAN)
    expected = shared.colours(patches_of(other), theirs.expected_f1[:, 1])
    np.testing.assert_allclose(colours(study.beside), expected, atol=STEP)
    other.w2w.scores = "ON_THESE"  # its own colours only: what is compared is of one kind
    np.testing.assert_allclose(colours(study.beside), expected, atol=STEP)
    bpy.data.objects.remove(other)
    assert beside_of(study) == study
    study.view = "A1"
    assert legend(study, utility).beside == utility.activities[1]


def test_it_survives_saving_and_goes_with_the_body(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    bpy.ops.w2w.side_by_side()
    body.w2w.beside_view = "A2"
    shown = colours(body.w2w.beside)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "two.blend"))
    body = open_file(tmp_path / "two.blend")
    assert [body.w2w.beside] == copies()
    np.testing.assert_array_equal(colours(body.w2w.beside), shown)
    assert legend(body.w2w, utility_of(body.w2w)).beside == body.w2w.activities[1].name
    assert upkeep.take_along() is None
    assert copies()
    with bpy.context.temp_override(selected_objects=[body]):
        bpy.ops.object.delete()
    assert upkeep.take_along() is None
    assert not copies()


def test_a_spot_on_the_copy_is_the_same_spot_of_the_body(library: Path) -> None:
    body = make_study(library)
    bpy.ops.w2w.side_by_side()
    copy = body.w2w.beside
    assert owner_of(copy) == body
    assert owner_of(body) is None
    depsgraph = bpy.context.evaluated_depsgraph_get()
    face = 900
    corner = copy.data.polygons[face].vertices[0]
    evaluated = copy.evaluated_get(depsgraph)
    place = np.array(evaluated.matrix_world @ evaluated.data.vertices[corner].co)
    assert spot_at(depsgraph, body, patches_of(body), face, place, copy) == (
        int(patches_of(body).labels[corner]),
        corner,
    )


def test_taken_out_by_hand_it_is_off_and_can_be_shown_again(library: Path) -> None:
    body = make_study(library)
    bpy.ops.w2w.side_by_side()
    bpy.data.objects.remove(body.w2w.beside)
    assert beside_of(body.w2w) is None
    body.w2w.view = "A1"
    assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
    assert len(copies()) == 1
