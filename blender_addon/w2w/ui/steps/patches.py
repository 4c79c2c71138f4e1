# SPDX-License-Identifier: GPL-3.0-or-later
"""Patches on the body: spread them, and look at one, from a list or by the pick tool."""

from threading import Lock

import bpy
import numpy as np
from bpy.props import BoolProperty, IntProperty
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ...core.body.body import Body
from ...core.patches.patches import PatchSet
from ...core.ranking.pooling import Pooling
from ...core.study.config import StudyConfig
from ...core.study.signals import place_patches as sample
from ...scene.base.body import select
from ...scene.base.patches import PATCH, empties_by_patch, place_patches, remove_patches
from ...scene.base.playback import spot_at
from ...scene.files.study_file import pack
from ..jobs import jobs
from ..results import own_placements, results
from ..study import operators, state
from ..viewport.framing import fold_soon
from ..viewport.legend import owner_of
from ..viewport.overlay import NO_PICK, cards_at, picks

NO_BODY = "Click on a body that has spots"
NO_TAB = "Open the tab W2W of the sidebar"
CLICK = {"type": "LEFTMOUSE", "value": "PRESS"}

_spread: list[tuple[object, PatchSet]] = []
_spreading = Lock()


def spread(body: Body, config: StudyConfig) -> PatchSet:
    """Patches by a config; the last are kept, and who asks while they are made waits."""
    with _spreading:
        if not _spread or _spread[0][0] != (body, config):
            _spread[:] = [((body, config), sample(body, config))]
            pack(_spread[0][1])
        return _spread[0][1]


def get_ready(body: Body, config: StudyConfig) -> None:
    """Make what Run All will ask for: a library of a bake, patches, the distances between them."""
    import scipy.signal  # noqa: F401

    Pooling.on(body, spread(body, config))


@jobs.on_body
def place_steps(mesh: bpy.types.Object) -> jobs.Steps:
    """Sample in a thread, then replace the empties."""
    body, study, config = state.body_as_run(mesh), mesh.w2w, to_place(mesh.w2w)
    before, key = state.patches_of(mesh), study.patches_key
    own, count, text = config.placements, config.patches, f"spreading {config.patches} spots"
    patches = yield from jobs.in_thread(lambda _: spread(body, config), text, 0.0, 0.8)
    yield jobs.Step(0.8, "placing empties")
    remove_all(mesh)
    study = mesh.w2w
    home = mesh.users_collection[0] if mesh.users_collection else None
    study.patch_collection = place_patches(mesh, patches, f"Patches: {mesh.name}", study.patch_size, home)
    study.patches_text, study.patches_key = pack(patches)
    study.patches_before, study.placed_as = "", state.placing_of(study)
    if before is not None and np.array_equal(before.triangles, patches.triangles[: len(before)]):
        study.patches_before = f"{key} {len(before)}"
    state.keep_own_placed(study, own, count)
    results.hide_patches(study)
    fold_soon()
    text = f"Placed {len(patches)} spots in {len(set(patches.regions))} regions"
    return f"{text}, {len(own)} of them your own" if own else text


def to_place(study: bpy.types.PropertyGroup) -> StudyConfig:
    """What patches are placed by now, as a config."""
    own = tuple(own_placements.by_name(study).items())
    return StudyConfig(patches=study.patch_count, seed=study.patch_seed, placements=own)


def remove_all(mesh: bpy.types.Object) -> None:
    """Remove the body's own empties and what was learned with them."""
    study = mesh.w2w
    results.clear(mesh)
    collection = study.patch_collection
    study.patch_collection = None
    study.patches_text = study.patches_key = study.own_placed = ""
    if collection is not None and all(item.parent is mesh for item in collection.objects):
        remove_patches(collection)


class W2W_OT_place_patches(operators.JobOperator, bpy.types.Operator):
    """Spread spots evenly over the body, an empty on each; replaces those that are there"""

    bl_label = "Place Spots"
    steps = staticmethod(place_steps)


class W2W_OT_remove_patches(operators.OnBody, bpy.types.Operator):
    """Remove the spots, and the ranking that was made with them"""

    bl_label = "Remove Spots"

    missing = operators.needs(lambda body: body.w2w.patch_collection, "There are no spots")

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        remove_all(body)


class W2W_OT_select_patch(operators.OnPatches, bpy.types.Operator):
    """Look at this spot; with Shift, compare it with the one looked at"""

    bl_label = "Look at Spot"
    bl_options = {"UNDO"}

    patch: IntProperty(name="Spot", description="Number of the spot", min=0)
    compare: BoolProperty(name="Compare", description="Keep the spot looked at, and compare with it")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.compare = event.shift
        return self.execute(context)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        count = len(state.placed_patches(body))
        if self.patch >= count:
            raise ValueError(f"The body has {count} spots, no number {self.patch}")
        pick(context, body, self.patch, self.compare)


class W2W_OT_clear_pick(operators.OnBody, bpy.types.Operator):
    """Look at no spot any more"""

    bl_label = "Look at No Spot"

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        if context.screen is not None and context.screen.is_animation_playing:
            return "Stop the clip first"  # by the same key
        return "" if body.w2w.picked >= 0 else "No spot is looked at"

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        body.w2w.picked = body.w2w.compared = body.w2w.picked_vertex = -1
        select(())  # an outline would hide colours
        context.view_layer.objects.active = body


def close_card(context: bpy.types.Context, event: bpy.types.Event) -> bool:
    """Whether a card was clicked, which is closed by its corner."""
    mouse, study = (event.mouse_region_x, event.mouse_region_y), state.polled_body(context).w2w
    hit = [each for each in cards_at.get(context.region.as_pointer(), ()) if each[1].holds(*mouse)]
    for patch, _, corner in hit:
        if corner.holds(*mouse):
            if patch == study.picked:
                study.picked = study.compared
            study.compared = study.picked_vertex = -1
            select(item for item in context.selected_objects if item.get(PATCH, patch) != patch)
    return bool(hit)


class W2W_OT_fit_range(operators.OnRanking, bpy.types.Operator):
    """Let the fixed colour range span the F1 of all activities"""

    bl_label = "Fit Range to All"

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        results.fit_range(body)


def missing_pick(context: bpy.types.Context, body: bpy.types.Object) -> str:
    """What prevents working on the spot that is looked at, as a sentence, or ""."""
    return operators.OnPatches.missing(context, body) or ("" if picks(context, body) else NO_PICK)


def pick(
    context: bpy.types.Context, body: bpy.types.Object, patch: int, compare: bool = False, vertex: int = -1
) -> None:
    """Look at a patch, and select its empty if visible; `vertex` is the clicked one."""
    study = body.w2w
    study.picked_vertex = vertex
    compare = compare and study.picked >= 0 and study.picked != patch
    if compare:
        study.compared = patch
    else:
        study.picked, study.compared = patch, -1
        select(())
    empty = empties_by_patch(study.patch_collection).get(patch)
    if empty is not None and empty.visible_get():
        empty.select_set(True)
        context.view_layer.objects.active = empty
    elif not compare:
        context.view_layer.objects.active = body


class W2W_OT_pick_patch(operators.OnBody, bpy.types.Operator):
    """Look at the spot under the mouse; with Shift, compare it with the one looked at"""

    bl_options = {"UNDO"}

    compare: BoolProperty(name="Compare", description="Keep the spot looked at, and compare with it")

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        return "" if context.area is not None and context.area.type == "VIEW_3D" else "Click in a 3D view"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if close_card(context, event):
            return {"FINISHED"}
        point, face, shown = under_mouse(context, event)
        item = None if shown is None else owner_of(shown) or shown
        if item is None or item.type != "MESH" or not item.w2w.is_body:
            text = f"'{item.name}' is no body: hide it (H) if it covers one" if item else NO_BODY
            self.report({"INFO"}, text)
            return {"CANCELLED"}
        if state.patches_of(item) is None:
            self.report({"WARNING"}, f"'{item.name}' has no spots: place them first (page Details)")
            return {"CANCELLED"}
        context.scene.w2w.body = item
        pick_spot(context, item, point, face, shown, self.compare)
        return {"FINISHED"}


class W2W_OT_click_body(operators.OnRanking, bpy.types.Operator):
    """Look at the spot that was clicked, while the tab W2W is open; any other click is Blender's own"""

    bl_options = {"UNDO"}

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        return operators.OnRanking.missing(context, body) or ("" if is_tab_open(context.area) else NO_TAB)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        if close_card(context, event):
            return {"FINISHED"}
        point, face, shown = under_mouse(context, event)
        body = state.polled_body(context)
        if shown is None or (owner_of(shown) or shown) is not body:
            return {"PASS_THROUGH"}
        pick_spot(context, body, point, face, shown)
        return {"FINISHED"}


def pick_spot(
    context: bpy.types.Context,
    body: bpy.types.Object,
    point: np.ndarray,
    face: int,
    shown: bpy.types.Object,
    compare: bool = False,
) -> None:
    """Look at the patch of a point (3,) that was clicked on a face of a body, or of what shows it."""
    patches = state.placed_patches(body)
    patch, vertex = spot_at(context.evaluated_depsgraph_get(), body, patches, face, point, shown)
    pick(context, body, patch, compare, vertex)


def is_tab_open(area: bpy.types.Area | None) -> bool:
    """Whether the sidebar of a 3D view shows W2W's tab."""
    regions = area.regions if area is not None and area.type == "VIEW_3D" else ()
    return any(
        each.type == "UI" and each.width > 1 and each.active_panel_category == "W2W" for each in regions
    )


def under_mouse(
    context: bpy.types.Context, event: bpy.types.Event
) -> tuple[np.ndarray, int, bpy.types.Object | None]:
    """The point (3,) in the world, the face and the object that a 3D view shows under the mouse."""
    mouse = (event.mouse_region_x, event.mouse_region_y)
    origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
    direction = region_2d_to_vector_3d(context.region, context.region_data, mouse)
    found = context.scene.ray_cast(context.evaluated_depsgraph_get(), origin, direction)
    return np.array(found[1]), found[3], found[4]


class W2W_WT_pick(bpy.types.WorkSpaceTool):
    """The tool in the toolbar."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = "w2w.pick_tool"
    bl_label = "Pick Spot"
    bl_description = "Click a body to see how well a sensor works there; Shift-click to compare"
    bl_icon = "ops.paint.eyedropper_add"
    bl_cursor = "EYEDROPPER"
    bl_keymap = (
        ("w2w.pick_patch", CLICK, None),
        ("w2w.pick_patch", {**CLICK, "shift": True}, {"properties": [("compare", True)]}),
    )


def register() -> None:
    """Register the tool if there are toolbars."""
    if not bpy.app.background:
        bpy.utils.register_tool(W2W_WT_pick, after={"builtin.cursor"}, separator=True)


def unregister() -> None:
    """Take back what `register` did."""
    if not bpy.app.background:
        bpy.utils.unregister_tool(W2W_WT_pick)
