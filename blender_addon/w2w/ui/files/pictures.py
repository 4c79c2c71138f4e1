# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture: the body with its map for a slide; it opens when it is done."""

from collections.abc import Callable
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any

import bpy
import numpy as np
from bpy.props import EnumProperty

from ...scene.base.playback import EvaluatedVertices
from ...scene.presentation import facing, posed, show_picture, shown_surface
from ..jobs.jobs import Step, Steps, in_thread, on_body, views
from ..study import lists, scores, state
from ..viewport.framing import DRAWN_AFTER, dressed
from ..viewport.legend import legend
from .exports import Export, heading

MARGIN = 1.06
"""How much larger than the body the part of the scene is that is shown."""

LARGEST = 2.0
"""Most pixels across, in those of an upright body's height: one that lies is drawn coarser."""


@on_body
def picture_steps(
    mesh: bpy.types.Object, path: Path, pose: str, seen: str, content: str, shape: str, light: str
) -> Steps:
    """Draw the body from the front and from behind, or as the view sees it; lay a page around it."""
    yield from in_thread(load_drawing, "preparing", 0.0, 0.2)
    from ...drawing.body import Surface, ViewFrame, locate
    from ...drawing.heatmap import VIEW_PIXELS, draw_slide

    words = words_on(mesh)
    with posed(mesh) if pose == "NEUTRAL" else nullcontext():
        yield Step(0.3, "posing")
        spots = chosen_spots(mesh)()
        surface = Surface(*shown_surface([mesh] if pose == "NEUTRAL" else [*dressed(mesh)]))
        turns = _turns(mesh, seen)
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    width = MARGIN * float(np.linalg.norm(high - low) if seen == "THIS_VIEW" else (high - low).max())
    size = round(VIEW_PIXELS * min(width / (high[2] - low[2]), LARGEST))
    frames = [ViewFrame(turn, (low + high) / 2, width, size) for turn in turns]

    def draw(progress: Callable[[float], None]) -> None:
        pictures = []
        for number, frame in enumerate(frames):
            progress(number / 3)
            pictures.append(surface.picture(frame, light == "STUDIO"))
        progress(2 / 3)
        page = {"markers": locate(frames, *spots), **words} if content == "PAGE" else None
        draw_slide(path, pictures, shape, page)

    yield from in_thread(draw, f"drawing {path.name}", 0.3, 1.0)
    open_soon(path)
    return f"Saved the picture: {path}"


def load_drawing(_: object) -> None:
    """Import what draws pages, which takes a second: for a thread."""
    from ...drawing import heatmap  # noqa: F401


def words_on(mesh: bpy.types.Object) -> dict[str, Any]:
    """Title, subtitle, scale and list of sensors of a page of the map that is shown."""
    from ...drawing.page import SensorList

    study, rows = mesh.w2w, list(lists.leading(mesh.w2w))
    advice = lists.advice_of(study) or {}
    words = {card["patch"]: card["in_words"] for card in advice.get("cards") or ()}
    cards = [words.get(row.patch, "") for row in rows]
    title, subtitle = heading(mesh)
    if scores.view_index(study) == 0 and scores.minus_index(study) < 0:  # the badges are of this answer
        subtitle = lists.answer_of(study).get("sentence", subtitle)
    sensors = SensorList([row.label for row in rows], [row.f1 for row in rows], cards)
    scale = legend(study, state.ranking_of(mesh))
    return {"title": title, "subtitle": subtitle, "scale": scale, "sensors": sensors}


def chosen_spots(mesh: bpy.types.Object) -> Callable[[], tuple[np.ndarray, np.ndarray]]:
    """A function that reads points and normals (N, 3) of the chosen sensors, in the order of their choice."""
    chosen = [row.patch for row in lists.leading(mesh.w2w)]
    return EvaluatedVertices(mesh, state.placed_patches(mesh).triangles[chosen]).of_triangles


def _turns(mesh: bpy.types.Object, seen: str) -> list[float]:
    """Turns about z of the cameras: from before and behind the body, or as the first 3D view looks."""
    spaces = [area.spaces.active for area in views(bpy.context)]
    if seen == "THIS_VIEW" and spaces:
        x, y, _ = spaces[0].region_3d.view_rotation.to_matrix().col[2]
        return [float(np.arctan2(x, -y))]
    return [facing(mesh), facing(mesh) + np.pi]


def open_soon(path: Path) -> None:
    """Show a picture in a window of its own, once the job is over: a new window takes its context."""
    if not bpy.app.background:
        bpy.app.timers.register(partial(show_picture, path, DRAWN_AFTER), first_interval=DRAWN_AFTER)


def choice(name: str, about: str, **items: str) -> Any:
    """A menu of items, each called like its key, with what it means."""
    shown = [(key, key.replace("_", " ").title(), text) for key, text in items.items()]
    return EnumProperty(name=name, description=about, items=shown)


SHAPE = choice("Shape", "Width and height", WIDE="16:9, for a slide", SQUARE="For a post")
LIGHT = choice("Light", "How the body is lit", STUDIO="With shades", FLAT="As the legend")


class W2W_OT_export_presentation(Export, bpy.types.Operator):
    """Save the body with its map as a picture for a slide; how it looks is asked with the file's name"""

    bl_label = "Picture"

    usual = "picture.png"
    pose: choice(
        "Pose", "How the body stands", NEUTRAL="Upright, the arms down", THIS_FRAME="As now, in what it wears"
    )
    seen: choice(
        "Seen From", "From where", FRONT_AND_BACK="Both sides", THIS_VIEW="As the 3D view, at its own height"
    )
    content: choice(
        "Content",
        "What is in it",
        PAGE="With title and legend, on white",
        BODY_ALONE="On nothing",
    )
    shape: SHAPE
    light: LIGHT

    def write(self, body: bpy.types.Object, path: Path) -> Steps:
        return picture_steps(body, path, self.pose, self.seen, self.content, self.shape, self.light)
