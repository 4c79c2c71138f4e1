# SPDX-License-Identifier: GPL-3.0-or-later
"""A new body stands clear of what is there; for its map other things are hidden, and the message says so."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from mathutils import Vector

from w2w.core.body.body import first_turn
from w2w.scene.base.body import body_of
from w2w.ui.jobs import jobs
from w2w.ui.steps import patches
from w2w.ui.viewport import framing
from w2w.ui.viewport.framing import SENSOR, extent, frame, frame_answer, go_with, hidden_ones, surface

pytestmark = pytest.mark.usefixtures("blender")


def add_box(size: float, place: tuple[float, float, float]) -> bpy.types.Object:
    """A cube of this width."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=place)
    return bpy.context.object


def overlaps(one: bpy.types.Object, other: bpy.types.Object) -> bool:
    """Whether the boxes around two objects have points in common."""
    (low, high), (begin, end) = extent([one]), extent([other])
    return bool((low < end).all() and (begin < high).all())


def add_body() -> bpy.types.Object:
    """A new body."""
    bpy.ops.w2w.add_body()
    return bpy.context.scene.w2w.body


def test_a_body_stands_next_to_the_default_cube_and_the_next_next_to_that() -> None:
    cube = add_box(2.0, (0, 0, 0))
    first, second = add_body(), add_body()
    pairs = [(cube, first), (cube, second), (first, second)]
    assert not any(overlaps(*pair) for pair in pairs)
    assert not cube.hide_get()


def test_a_body_stands_on_a_floor_and_in_a_room_where_the_cursor_is() -> None:
    add_box(40.0, (0, 0, 15))
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.scene.cursor.location = (1.0, 0.5, 0.0)
    np.testing.assert_allclose(add_body().parent.location, (1.0, 0.5, 0.0))


def test_other_things_are_hidden_for_the_map_and_come_back_by_one_button() -> None:
    body = add_body()
    wall, behind = add_box(1.0, (0, -1.5, 1)), add_box(1.0, (0, 2, 1))
    second = add_body()
    frame_answer(body)
    assert [item.name for item in hidden_ones()] == ["Cube", "Cube.001"]
    assert wall.hide_get()
    assert behind.hide_get()
    assert not second.hide_get()
    assert not bpy.context.selected_objects  # an outline would hide colours
    bpy.ops.w2w.show_others()
    assert not wall.hide_get()
    assert not behind.hide_get()
    assert hidden_ones() == []


def test_a_body_in_a_hidden_collection_comes_into_sight() -> None:
    body = add_body()
    (home,) = body.users_collection
    (layer,) = bpy.context.view_layer.layer_collection.children
    layer.exclude = home.hide_viewport = True
    frame_answer(body)
    assert body.visible_get()


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_spot_is_looked_at_as_the_report_does(side: float) -> None:
    body = add_body()
    normals = body_of(body).vertex_normals
    vertex = int((side * normals[:, 1]).argmax())
    frame([body], vertex)
    view = jobs.views(bpy.context)[0].spaces.active.region_3d
    eye = view.view_location + view.view_rotation @ Vector((0, 0, view.view_distance))
    x, y, _ = np.array(eye) - surface(body).mean(axis=0)
    away = np.arctan2(x, -y) - first_turn(body_of(body), vertex)
    assert np.sin(away) == pytest.approx(0, abs=0.03)  # though the body is beside the middle of the view
    assert np.sign(y) == side


def test_a_view_through_the_camera_is_left() -> None:
    view = jobs.views(bpy.context)[0].spaces.active.region_3d
    view.view_perspective = "CAMERA"
    add_body()
    assert view.view_perspective == "PERSP"


def test_views_go_along_the_ground_with_a_body_that_plays() -> None:
    body = add_body()
    view = jobs.views(bpy.context)[0].spaces.active.region_3d
    before, hips = Vector(view.view_location), body.parent.pose.bones["pelvis"]
    go_with(body, move=False)
    hips.location = hips.bone.matrix_local.inverted().to_3x3() @ Vector((1.0, -2.0, 0.5))
    bpy.context.view_layer.update()
    go_with(body, move=True)
    np.testing.assert_allclose(view.view_location - before, (1.0, -2.0, 0.0), atol=1e-5)


def seen_at(body: bpy.types.Object) -> np.ndarray:
    """Where a body's surface is in the 3D view's region, shape (V, 2), pixels."""
    (area,) = jobs.views(bpy.context)
    region = next(part for part in area.regions if part.type == "WINDOW")
    space, points = area.spaces.active, surface(body)
    view = space.region_3d
    seen = (points - np.array(view.view_location)) @ np.array(view.view_rotation.to_matrix())
    size = np.array([region.width, region.height])
    return size / 2 + seen[:, :2] / (view.view_distance - seen[:, 2:]) * size.max() * space.lens / SENSOR


@pytest.mark.parametrize(("units", "length"), [("METRIC", 1.0), ("METRIC", 0.01), ("IMPERIAL", 0.3048)])
@pytest.mark.parametrize("sidebar", [0, 700])
def test_bodies_are_shown_whole_beside_a_large_sidebar_whatever_the_units(
    monkeypatch: pytest.MonkeyPatch, units: str, length: float, sidebar: int
) -> None:
    free_area = framing.free_area

    def beside_sidebar(*given: object) -> framing.FreeArea:
        free = free_area(*given)
        return free._replace(right=free.right - sidebar)

    monkeypatch.setattr(framing, "free_area", beside_sidebar)
    (area,) = jobs.views(bpy.context)
    free = beside_sidebar(area, next(part for part in area.regions if part.type == "WINDOW"))
    unit = bpy.context.scene.unit_settings
    unit.system, unit.scale_length = units, length
    first, second = add_body(), add_body()
    for bodies in ([second], [first, second]):
        frame(bodies)
        spots = np.concatenate([seen_at(body) for body in bodies])
        assert (spots > (free.left, free.bottom)).all()
        assert (spots < (free.right, free.top)).all()
        wide, tall = np.ptp(spots, axis=0)  # as large as fits beside the legend
        assert (
            max(wide / (free.right - free.left), tall / (free.top - free.bottom)) > 0.7
        )  # as large as fits beside the legend


def test_a_click_on_what_covers_a_body_says_what_that_is(monkeypatch: pytest.MonkeyPatch) -> None:
    add_body()
    add_box(1.0, (0, -1.5, 1))
    bpy.context.view_layer.update()
    monkeypatch.setattr(patches, "region_2d_to_origin_3d", lambda *_: Vector((0, -9, 1)))
    monkeypatch.setattr(patches, "region_2d_to_vector_3d", lambda *_: Vector((0, 1, 0)))
    said: list[str] = []
    context = SimpleNamespace(
        region=SimpleNamespace(as_pointer=lambda: 0), region_data=None, scene=bpy.context.scene,
        evaluated_depsgraph_get=bpy.context.evaluated_depsgraph_get,
    )  # fmt: skip
    operator = SimpleNamespace(report=lambda _, text: said.append(text))
    event = SimpleNamespace(mouse_region_x=0, mouse_region_y=0)
    assert patches.W2W_OT_pick_patch.invoke(operator, context, event) == {"CANCELLED"}
    assert said == ["'Cube' is no body: hide it (H) if it covers one"]
