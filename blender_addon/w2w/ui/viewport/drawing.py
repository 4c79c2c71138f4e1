# SPDX-License-Identifier: GPL-3.0-or-later
"""On a 3D view, in pixels and from within a draw handler: shapes and text, and where patches are in it."""

from collections.abc import Sequence

import blf
import bpy
import gpu
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d, region_2d_to_origin_3d, region_2d_to_vector_3d
from gpu_extras.batch import batch_for_shader
from mathutils import Vector

from ...core.motion.skinning import triangle_frames
from ...core.patches.patches import PatchSet
from ...drawing.canvas import Colour
from ...scene.base.patches import empties_by_patch
from ..jobs.text import FONT
from .framing import dressed, surface

SKIN = 0.01
"""Metres that a ray may end before a patch and still see it: triangles lean."""


def rectangle(x: float, y: float, width: float, height: float, colour: Colour) -> None:
    """Fill a rectangle; x and y are its lower left corner."""
    corners = ((x, y), (x + width, y), (x + width, y + height), (x, y + height))
    _fill(corners, ((0, 1, 2), (0, 2, 3)), colour)


def bar_of_colours(x: float, y: float, width: float, height: float, colours: np.ndarray) -> None:
    """Fill a rectangle with colours (K, 3) in sRGB, along its longer side."""
    shares = np.linspace(0, 1, len(colours))[:, None]
    along, across = ((0, height), (width, 0)) if height > width else ((width, 0), (0, height))
    edge = (x, y) + shares * along
    corners = np.concatenate([edge, edge + across]).astype(np.float32)
    shades = np.column_stack([np.tile(colours, (2, 1)), np.ones(2 * len(colours))]).astype(np.float32)
    low = np.arange(len(colours) - 1, dtype=np.int32)
    right = low + len(colours)
    triangles = np.column_stack([low, right, right + 1, low, right + 1, low + 1]).reshape(-1, 3)
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    batch_for_shader(shader, "TRIS", {"pos": corners, "color": shades}, indices=triangles).draw(shader)


def polyline(points: np.ndarray, colour: Colour, width: float) -> None:
    """Draw a line through points (K, 2); NaN breaks it."""
    known = np.isfinite(points).all(axis=1)
    for run in np.split(np.arange(len(points)), np.flatnonzero(np.diff(known)) + 1):
        if len(run) > 1 and known[run[0]]:
            _strip(points[run], colour, width)


def ring(x: float, y: float, radius: float, colour: Colour, width: float) -> None:
    """Draw a circle."""
    _strip(_circle(x, y, radius), colour, width)


def disc(x: float, y: float, radius: float, colour: Colour) -> None:
    """Fill a circle."""
    rim = _circle(x, y, radius)
    corners = np.concatenate([[(x, y)], rim]).astype(np.float32)
    _fill(corners, [(0, number, number + 1) for number in range(1, len(rim))], colour)


def width_of(words: str, size: float) -> float:
    """Width of one line of text, pixels."""
    blf.size(FONT, size)
    return blf.dimensions(FONT, words)[0]


def text(x: float, y: float, words: str, size: float, colour: Colour, align: str = "LEFT") -> float:
    """Write one line with its baseline at y; returns its width."""
    width = width_of(words, size)
    shift = {"LEFT": 0.0, "CENTER": width / 2, "RIGHT": width}[align]
    blf.color(FONT, *colour)
    blf.position(FONT, round(x - shift), round(y), 0)
    blf.draw(FONT, words)
    return width


def dots(places: np.ndarray, colours: np.ndarray, size: float) -> None:
    """Draw points of the world (K, 3), in colours (K, 3) in sRGB with a dark rim, behind what covers them."""
    shader = gpu.shader.from_builtin("FLAT_COLOR")
    gpu.state.depth_test_set("LESS_EQUAL")
    for shades, wide in ((np.full_like(colours, 0.1), 1.6 * size), (colours, size)):
        opaque = np.column_stack([shades, np.ones(len(shades))]).astype(np.float32)
        gpu.state.point_size_set(wide)
        batch_for_shader(shader, "POINTS", {"pos": places.astype(np.float32), "color": opaque}).draw(shader)
    gpu.state.depth_test_set("NONE")


def _circle(x: float, y: float, radius: float) -> np.ndarray:
    angles = np.linspace(0, 2 * np.pi, 33)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


def _fill(corners: Sequence | np.ndarray, triangles: Sequence, colour: Colour) -> None:
    shader = gpu.shader.from_builtin("UNIFORM_COLOR")
    batch = batch_for_shader(shader, "TRIS", {"pos": corners}, indices=triangles)
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("color", colour)
    batch.draw(shader)


def _strip(points: Sequence | np.ndarray, colour: Colour, width: float) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_UNIFORM_COLOR")
    corners = np.column_stack([points, np.zeros(len(points))]).astype(np.float32)
    batch = batch_for_shader(shader, "LINE_STRIP", {"pos": corners})
    gpu.state.blend_set("ALPHA")
    shader.uniform_float("viewportSize", gpu.state.viewport_get()[2:])
    shader.uniform_float("lineWidth", width)
    shader.uniform_float("color", colour)
    batch.draw(shader)


class Surface:
    """A body's evaluated surface in the 3D view that is being drawn."""

    def __init__(self, context: bpy.types.Context, body: bpy.types.Object, patches: PatchSet) -> None:
        self._region, self._view = context.region, context.region_data
        self._scene, self._depsgraph = context.scene, context.view_layer.depsgraph
        self._body, self._patches = body, patches
        self._evaluated = body.evaluated_get(self._depsgraph)
        self._whole = len(self._evaluated.data.vertices) == len(patches.labels)
        """Whether the mesh has the vertices that patches know; modifiers may have made others."""

    def on_screen(self, patch: int) -> Vector | None:
        """Point of a patch in the region, pixels; None behind the viewer, or if unknown."""
        return self.project(self._place(patch))

    def in_sight(self, patch: int) -> bool:
        """Whether neither the body nor another object stands between the viewer and the patch."""
        return self._in_sight(self._place(patch))

    def spot(self, vertex: int) -> Vector | None:
        """Point of a vertex in the region, pixels; None if it is out of sight, or unknown."""
        if not (self._whole and 0 <= vertex < len(self._patches.labels)):
            return None
        place = self._evaluated.matrix_world @ self._evaluated.data.vertices[vertex].co
        return self.project(place) if self._in_sight(place) else None

    def above(self, height: float) -> np.ndarray:
        """Points of the world (N, 3) so many metres over all patches; (0, 3) if unknown."""
        if not self._whole:
            return np.empty((0, 3))
        frames = triangle_frames(surface(self._body)[self._patches.triangles])
        return frames[:, :3, 3] + height * frames[:, :3, 2]

    def project(self, place: Vector | None) -> Vector | None:
        """A point of the world in the region, pixels; None behind the viewer."""
        return None if place is None else location_3d_to_region_2d(self._region, self._view, place)

    def _in_sight(self, place: Vector | None) -> bool:
        point = self.project(place)
        if place is None or point is None:
            return False
        origin = region_2d_to_origin_3d(self._region, self._view, point)
        direction = region_2d_to_vector_3d(self._region, self._view, point)
        inverse = self._evaluated.matrix_world.inverted_safe()
        start = inverse @ origin
        hit, found, _, _ = self._evaluated.ray_cast(start, (inverse @ (origin + direction)) - start)
        if hit and ((self._evaluated.matrix_world @ found) - place).dot(direction) <= -SKIN:
            return False
        reach = (place - origin).length - SKIN
        hit, *_, item, _ = self._scene.ray_cast(self._depsgraph, origin, direction, distance=reach)
        return not hit or item in dressed(self._body)

    def _place(self, patch: int) -> Vector | None:
        """Point of a patch in the world."""
        if self._whole:
            vertices = self._evaluated.data.vertices
            corners = [vertices[vertex].co for vertex in self._patches.triangles[patch].tolist()]
            return self._evaluated.matrix_world @ (sum(corners, Vector()) / 3)
        collection = self._body.w2w.patch_collection
        empty = None if collection is None else empties_by_patch(collection).get(patch)
        if empty is None or not empty.visible_get():
            return None
        return empty.evaluated_get(self._depsgraph).matrix_world.translation.copy()
