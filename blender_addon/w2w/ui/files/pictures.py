# SPDX-License-Identifier: GPL-3.0-or-later
"""Picture: the body with its map as Blender renders it, for a slide; it opens when it is done."""

from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import bpy
import numpy as np
from bpy.props import EnumProperty
from PIL import Image

from ...core.files import atomic_write
from ...scene.base.playback import EvaluatedVertices
from ...scene.presentation import facing, neutral, stage
from ..jobs.jobs import Step, Steps, in_thread, on_body, views
from ..study import lists, scores, state
from ..viewport.framing import DRAWN_AFTER, dressed, extent
from ..viewport.legend import legend
from .exports import Export, heading

MARGIN = 1.06
"""How much larger than the body the rendered part of the scene is."""

SHAPES = {"WIDE": 16 / 9, "SQUARE": 1.0}
"""Widths of pictures, in their heights."""


class Look(NamedTuple):
    """How a picture shows the body."""

    pose: str = "NEUTRAL"
    seen: str = "FRONT_AND_BACK"
    content: str = "PAGE"
    shape: str = "WIDE"
    light: str = "STUDIO"


@on_body
def picture_steps(mesh: bpy.types.Object, path: Path, look: Look) -> Steps:
    """Render the body from the front and from behind, or as the view sees it; lay a page around it."""
    from ...drawing.body import ViewFrame, common_crop
    from ...drawing.heatmap import VIEW_PIXELS, subset_figure  # matplotlib is slow to import
    from ...drawing.page import SensorList

    study, patches = mesh.w2w, state.placed_patches(mesh)
    rows, pictures = list(lists.leading(study)), []
    with neutral(mesh) if look.pose == "NEUTRAL" else nullcontext():
        yield Step(0.1, "posing")
        corners = EvaluatedVertices(mesh, patches.triangles[[row.patch for row in rows]]).positions()
        low, high = extent([mesh])
        width = MARGIN * float(np.linalg.norm(high - low) if look.seen == "THIS_VIEW" else (high - low).max())
        size = round(VIEW_PIXELS * width / (high[2] - low[2]))
        frames = [ViewFrame(turn, (low + high) / 2, width, size) for turn in _turns(mesh, look)]
        shown_with = [mesh] if look.pose == "NEUTRAL" else [*dressed(mesh)]
        with stage(shown_with, size, look.light) as picture:
            for number, frame in enumerate(frames):
                yield Step(0.2 + 0.3 * number, "rendering")
                pictures.append(picture(frame.towards_camera, frame.centre, frame.width))
        yield Step(0.8, "drawing")
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing_us = normals @ np.stack([frame.towards_camera for frame in frames], axis=1)
    markers = []
    for view, spot, seen in zip(facing_us.argmax(axis=1), corners.mean(axis=1), facing_us, strict=True):
        if seen[view] > 0:
            column, row = frames[view].to_pixels(spot)
            markers.append((int(view), float(column), float(row)))
    shown, advice = legend(study, state.ranking_of(mesh)), lists.advice_of(study) or {}
    words = {card["patch"]: card["in_words"] for card in advice.get("cards") or ()}
    cards = [words.get(row.patch, "") for row in rows]
    sensors = SensorList([row.label for row in rows], [row.f1 for row in rows], cards)
    title, subtitle = heading(mesh)
    if scores.view_index(study) == 0 and scores.minus_index(study) < 0:  # the badges are of this answer
        subtitle = lists.answer_of(study).get("sentence", subtitle)

    def draw(_: object) -> None:
        if look.content == "PAGE":
            subset_figure(path, pictures, title, shown, markers, sensors, subtitle)
            with Image.open(path) as page:
                save_shaped(path, page.convert("RGBA"), look.shape, "white")
        else:
            top, bottom, first, last = common_crop(pictures)
            alone = np.concatenate([each[top:bottom, first:last] for each in pictures], axis=1)
            save_shaped(path, Image.fromarray(alone), look.shape, "#ffffff00")

    yield from in_thread(draw, f"drawing {path.name}", 0.8, 1.0)
    open_soon(path)
    return f"Saved the picture: {path}"


def _turns(mesh: bpy.types.Object, look: Look) -> list[float]:
    """Turns about z of the cameras: from before and behind the body, or as the first 3D view looks."""
    spaces = [area.spaces.active for area in views(bpy.context)]
    if look.seen == "THIS_VIEW" and spaces:
        x, y, _ = spaces[0].region_3d.view_rotation.to_matrix().col[2]
        return [float(np.arctan2(x, -y))]
    return [facing(mesh), facing(mesh) + np.pi]


def save_shaped(path: Path, picture: Image.Image, shape: str, around: str) -> None:
    """Write a picture, with room of a colour around it where its shape is another."""
    (width, height), ratio = picture.size, SHAPES[shape]
    size = max(width, round(height * ratio)), max(height, round(width / ratio))
    whole = Image.new("RGBA", size, around)
    whole.paste(picture, ((size[0] - width) // 2, (size[1] - height) // 2))
    with atomic_write(path) as stream:
        whole.save(stream, format="png")


def open_soon(path: Path) -> None:
    """Show a picture in a window of its own, once the job is over: a new window takes its context."""
    if not bpy.app.background:
        bpy.app.timers.register(partial(_open, path), first_interval=DRAWN_AFTER)


def _open(path: Path) -> None:
    windows = bpy.context.window_manager.windows
    image = bpy.data.images.load(str(path), check_existing=True)
    image.reload()
    with bpy.context.temp_override(window=windows[0]):
        bpy.ops.wm.window_new()
    window = windows[-1]
    area = window.screen.areas[0]
    area.type = "IMAGE_EDITOR"
    area.spaces.active.image = image

    def show_whole() -> None:
        if window in windows[:]:
            region = next(each for each in area.regions if each.type == "WINDOW")
            with bpy.context.temp_override(window=window, area=area, region=region):
                bpy.ops.image.view_all(fit_view=True)

    bpy.app.timers.register(show_whole, first_interval=DRAWN_AFTER)


def _choice(name: str, about: str, **items: str) -> Any:
    """A menu of items, each called like its key, with what it means."""
    shown = [(key, key.replace("_", " ").title(), text) for key, text in items.items()]
    return EnumProperty(name=name, description=about, items=shown)


class W2W_OT_export_presentation(Export, bpy.types.Operator):
    """Save the body with its map as a picture for a slide; how it looks is asked with the file's name"""

    bl_label = "Picture"

    usual = "picture.png"
    pose: _choice(
        "Pose", "How the body stands", NEUTRAL="Upright, the arms down", THIS_FRAME="As now, in what it wears"
    )
    seen: _choice(
        "Seen From", "From where", FRONT_AND_BACK="Both sides", THIS_VIEW="As the 3D view, at its own height"
    )
    content: _choice(
        "Content",
        "What is in it",
        PAGE="With title and legend, on white",
        BODY_ALONE="On nothing",
    )
    shape: _choice("Shape", "Width and height", WIDE="16:9, for a slide", SQUARE="For a post")
    light: _choice("Light", "How the body is lit", STUDIO="With shades", FLAT="As the legend")

    def steps(self, body: bpy.types.Object) -> Steps:
        path = Path(bpy.path.ensure_ext(str(self.path()), ".png"))
        return picture_steps(body, path, Look(self.pose, self.seen, self.content, self.shape, self.light))
