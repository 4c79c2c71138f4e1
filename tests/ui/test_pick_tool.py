# SPDX-License-Identifier: GPL-3.0-or-later
"""A click on the posed body."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.scene.base.patches import patch_empties
from w2w.scene.base.playback import spot_at
from w2w.ui.study.state import patches_of

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender")


@pytest.mark.slow
def test_a_click_finds_the_patch_of_the_posed_surface(library: Path) -> None:
    body = make_study(library, "motions patches")
    bpy.ops.w2w.preview_clip(index=0)
    bpy.context.scene.frame_set(20)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = body.evaluated_get(depsgraph)
    labels = patches_of(body).labels
    for face in range(0, len(evaluated.data.polygons), 997):
        vertex = evaluated.data.polygons[face].vertices[0]
        place = np.array(evaluated.matrix_world @ evaluated.data.vertices[vertex].co)
        assert spot_at(depsgraph, body, patches_of(body), face, place) == (labels[vertex], vertex)
    # with other vertices than the patches know, the nearest empty decides
    body.modifiers.new("Subdivision", "SUBSURF").levels = 1
    depsgraph.update()
    empty = patch_empties(body.w2w.patch_collection)[7]
    place = np.array(empty.evaluated_get(depsgraph).matrix_world.translation)
    assert spot_at(depsgraph, body, patches_of(body), 0, place) == (7, -1)


def test_a_spot_that_is_looked_at_no_more_leaves_nothing_selected(library: Path) -> None:
    body = make_study(library, "motions patches")
    bpy.ops.w2w.select_patch(patch=3)
    assert body.w2w.picked == 3
    bpy.ops.w2w.clear_pick()
    assert body.w2w.picked == -1
    assert not bpy.context.selected_objects  # an outline would hide colours
    assert bpy.context.view_layer.objects.active == body
