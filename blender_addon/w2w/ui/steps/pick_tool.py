# SPDX-License-Identifier: GPL-3.0-or-later
"""The pick tool: click a spot on a body to look at its patch, Shift-click another to compare."""

from __future__ import annotations

import bpy
import numpy as np
from bpy.props import BoolProperty
from bpy_extras.view3d_utils import region_2d_to_origin_3d, region_2d_to_vector_3d

from ...scene.base.evaluated import EvaluatedVertices
from ..study.state import current_body, patches_of
from ..viewport.legend import owner_of
from .picking import pick

TOOL = "w2w.pick_tool"


class W2W_OT_pick_patch(bpy.types.Operator):
    """Look at the patch under the mouse; with Shift, compare it with the one looked at"""

    bl_idname = "w2w.pick_patch"
    bl_label = "Pick Patch"
    bl_options = {"UNDO"}

    compare: BoolProperty(name="Compare", description="Keep the patch looked at, and compare with it")

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cls.poll_message_set("Add a body first")
        return (
            context.mode == "OBJECT"
            and current_body(context) is not None
            and context.area is not None
            and context.area.type == "VIEW_3D"
        )

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        mouse = (event.mouse_region_x, event.mouse_region_y)
        origin = region_2d_to_origin_3d(context.region, context.region_data, mouse)
        direction = region_2d_to_vector_3d(context.region, context.region_data, mouse)
        depsgraph = context.evaluated_depsgraph_get()
        hit, point, _, face, item, _ = context.scene.ray_cast(depsgraph, origin, direction)
        shown, item = item, (owner_of(item) or item) if hit else None
        if not hit or item.type != "MESH" or not item.w2w.is_body:
            self.report({"INFO"}, "Click on a body that has patches")
            return {"CANCELLED"}
        if patches_of(item) is None:
            self.report({"WARNING"}, f"'{item.name}' has no patches: place them first (step 3)")
            return {"CANCELLED"}
        context.scene.w2w.body = item
        patch, vertex = spot_at(depsgraph, item, face, np.array(point), shown)
        pick(context, item, patch, self.compare, vertex)
        return {"FINISHED"}


class W2W_WT_pick(bpy.types.WorkSpaceTool):
    """The tool in the toolbar."""

    bl_space_type = "VIEW_3D"
    bl_context_mode = "OBJECT"
    bl_idname = TOOL
    bl_label = "Pick Patch"
    bl_description = "Click a body to see how well a sensor works there; Shift-click to compare"
    bl_icon = "ops.paint.eyedropper_add"
    bl_cursor = "EYEDROPPER"
    bl_keymap = (
        ("w2w.pick_patch", {"type": "LEFTMOUSE", "value": "PRESS"}, None),
        (
            "w2w.pick_patch",
            {"type": "LEFTMOUSE", "value": "PRESS", "shift": True},
            {"properties": [("compare", True)]},
        ),
    )


def spot_at(
    depsgraph: bpy.types.Depsgraph,
    body: bpy.types.Object,
    face: int,
    point: np.ndarray,
    shown: bpy.types.Object | None = None,
) -> tuple[int, int]:
    """Patch of a point in the world, on this face of the evaluated body, and the vertex nearest to it.

    `shown` is what was clicked where it is a copy of the body; the vertex is -1 where a modifier has made
    others than the body has.
    """
    patches = patches_of(body)
    evaluated = (shown or body).evaluated_get(depsgraph)
    mesh, world = evaluated.data, np.array(evaluated.matrix_world)
    if len(mesh.vertices) == len(patches.labels):
        corners = list(mesh.polygons[face].vertices)
        points = np.array([mesh.vertices[corner].co for corner in corners]) @ world[:3, :3].T + world[:3, 3]
        vertex = corners[int(np.linalg.norm(points - point, axis=1).argmin())]
        return int(patches.labels[vertex]), vertex
    # a modifier has made other vertices: the nearest carrier triangle stands for its patch
    points = EvaluatedVertices(body, patches.triangles).positions().mean(axis=1)
    return int(np.linalg.norm(points - point, axis=1).argmin()), -1


def register() -> None:
    """Register the tool where there are toolbars."""
    if not bpy.app.background:
        bpy.utils.register_tool(W2W_WT_pick, after={"builtin.cursor"}, separator=True)


def unregister() -> None:
    """Take back what `register` did."""
    if not bpy.app.background:
        bpy.utils.unregister_tool(W2W_WT_pick)
