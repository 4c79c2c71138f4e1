# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a coloured body from several sides, by a depth buffer in NumPy: no Blender, no window."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from PIL import Image, ImageDraw
from scipy.ndimage import distance_transform_edt, gaussian_filter
from scipy.sparse import csr_array

from ..core.body.body import Body, vertex_normals

VIEW_TURNS = {"front": 0.0, "left": np.pi / 2, "back": np.pi, "right": -np.pi / 2}
"""Turn of the camera about the body for each view; the body faces -y."""

MARGIN = 1.04

SAMPLES = 4
"""Samples of the outline across a pixel."""

LIGHTS = (((-0.45, -0.55, 0.7), 0.62), ((0.75, -0.5, 0.1), 0.2), ((0.0, -1.0, 0.0), 0.28))
"""Directions towards lights as the front's camera sees them, x to the right and z up, and their strengths."""

CREASE, CREASE_M = 12.0, 0.01
"""Darkening of a place a metre deeper than its surroundings, and the radius of these."""

SHADE_DEPTH = 0.5
"""Darkening of the darkest places of the body."""

GLEAM = 0.06
"""How far the brightest parts are lifted towards white: else dark colours would hide the shape."""


@dataclass(frozen=True)
class ViewFrame:
    """Maps points of the world to a square picture of `size` pixels, `width` metres across.

    The camera is turned by `turn` radians about z (0 looks along +y) and looks at `centre`, shape (3,).
    """

    turn: float
    centre: np.ndarray
    width: float
    size: int

    @classmethod
    def of(cls, body: Body, view: str, size: int) -> ViewFrame:
        """The whole body with a narrow margin."""
        low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
        return cls(VIEW_TURNS[view], (low + high) / 2, float((high - low).max()) * MARGIN, size)

    @property
    def right(self) -> np.ndarray:
        """Unit vector to the right of the picture."""
        return np.array([np.cos(self.turn), np.sin(self.turn), 0.0])

    @property
    def towards_camera(self) -> np.ndarray:
        """Unit vector from the body to the camera."""
        return np.array([np.sin(self.turn), -np.cos(self.turn), 0.0])

    def to_pixels(self, points: np.ndarray) -> np.ndarray:
        """Column and row (..., 2) of points (..., 3), metres, from the upper left corner."""
        offsets = np.asarray(points, dtype=np.float64) - self.centre
        scale = self.size / self.width
        return np.stack([offsets @ self.right, -offsets[..., 2]], axis=-1) * scale + self.size / 2


@dataclass(frozen=True, eq=False)
class Surface:
    """A posed surface: points (V, 3), metres, outward triangles (F, 3), sRGB colours of the points (V, 3)."""

    vertices: np.ndarray
    faces: np.ndarray
    colours: np.ndarray

    @cached_property
    def vertex_normals(self) -> np.ndarray:
        """Area-weighted outward unit normals, shape (V, 3)."""
        return vertex_normals(self.vertices, self.faces)

    def picture(self, frame: ViewFrame, lit: bool = True) -> np.ndarray:
        """A picture like those of `BodyPictures.coloured`, shaded if it is `lit`."""
        return _Shade(self, frame, lit).over(self.colours, frame.size)


class _Shade:
    """Light and outline of one view: all of a picture but its colours.

    `shown` are the flat indices of the K pixels that are not transparent. `share`, shape (K, V), is how much
    of each vertex's colour they show, `gleam`, shape (K, 1), the white that is added, and `alpha`, shape
    (K,), uint8, their opacity.
    """

    def __init__(self, body: Body | Surface, frame: ViewFrame, lit: bool = True) -> None:
        seen, weights, depth = _nearest(body, frame)
        covered = _covered(body, frame).ravel()
        self.shown = shown = np.flatnonzero(covered > 0)
        self.alpha = _bytes(covered[shown])
        # pixels of the soft outline whose middle shows nothing take the nearest one that does
        nearest = distance_transform_edt(seen < 0, return_distances=False, return_indices=True)
        place = np.ravel_multi_index(nearest, seen.shape).ravel()[shown]
        corners, weights = body.faces[seen.ravel()[place]], weights.reshape(-1, 3)[place]
        bright = _brightness(body, frame, corners, weights, _depth_below(depth, frame).ravel()[place])
        light = 1 - SHADE_DEPTH * (1 - bright) * lit
        gleam = GLEAM * np.clip(2 * bright - 1, 0, 1) ** 2 * lit
        shining = (weights * (light - gleam)[:, None]).astype(np.float32)
        starts = np.arange(0, shining.size + 1, 3)
        size = (len(shown), len(body.vertices))
        self.share = csr_array((shining.ravel(), corners.ravel(), starts), size)
        self.gleam = gleam.astype(np.float32)[:, None]

    def over(self, colours: np.ndarray, size: int) -> np.ndarray:
        """A picture in these colours of the vertices, shape (V, 3)."""
        drawn = np.empty((len(self.shown), 4), dtype=np.uint8)
        drawn[:, :3] = _bytes(self.share @ colours.astype(np.float32) + self.gleam)
        drawn[:, 3] = self.alpha
        picture = np.zeros(size * size, dtype=np.uint32)  # moves a pixel's four bytes at once
        picture[self.shown] = drawn.view(np.uint32)[:, 0]
        return picture.view(np.uint8).reshape(size, size, 4)


def _nearest(body: Body | Surface, frame: ViewFrame) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Triangle (S, S) at each pixel's centre or -1, its corners' weights (S, S, 3), its depth (S, S)."""
    size = frame.size
    points = frame.to_pixels(body.vertices)[body.faces]
    depths = ((body.vertices - frame.centre) @ -frame.towards_camera)[body.faces]
    edges = points[:, 1:] - points[:, :1]
    areas = edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]
    facing = np.flatnonzero(areas < -1e-9)  # rows count downwards: triangles that face the camera turn left
    low = np.ceil(points[facing].min(axis=1) - 0.5).astype(np.intp)
    spans = np.maximum(np.floor(points[facing].max(axis=1) - 0.5).astype(np.intp) - low + 1, 0)
    counts = spans.prod(axis=1)
    box = np.repeat(np.arange(len(facing)), counts)
    starts = np.repeat(np.cumsum(counts) - counts, counts)
    rows, columns = np.divmod(np.arange(len(box)) - starts, spans[box, 0])
    pixels = low[box] + np.stack([columns, rows], axis=1)
    away = pixels + 0.5 - points[facing[box], 0]
    (x1, y1), (x2, y2) = (edges[facing[box], side].T for side in (0, 1))
    second = (away[:, 0] * y2 - away[:, 1] * x2) / areas[facing[box]]
    third = (x1 * away[:, 1] - y1 * away[:, 0]) / areas[facing[box]]
    inside = np.flatnonzero((second >= 0) & (third >= 0) & (second + third <= 1))
    weights = np.stack([1 - second - third, second, third], axis=1)[inside]
    triangles, places = facing[box[inside]], pixels[inside, 1] * size + pixels[inside, 0]
    depth = (weights * depths[triangles]).sum(axis=1)
    order = np.argsort(-depth, kind="stable")  # the nearest is written last
    places = places[order]
    seen, shares, deep = np.full(size * size, -1), np.zeros((size * size, 3)), np.full(size * size, np.inf)
    seen[places], shares[places], deep[places] = triangles[order], weights[order], depth[order]
    return seen.reshape(size, size), shares.reshape(size, size, 3), deep.reshape(size, size)


def _covered(body: Body | Surface, frame: ViewFrame) -> np.ndarray:
    """Share of each pixel (S, S) that the body covers."""
    size = frame.size * SAMPLES
    outline = Image.new("L", (size, size))
    draw = ImageDraw.Draw(outline)
    for corners in (frame.to_pixels(body.vertices) * SAMPLES - 0.5)[body.faces].reshape(-1, 6).tolist():
        draw.polygon(corners, fill=255)
    return np.asarray(outline.reduce(SAMPLES), dtype=np.float64) / 255


def _depth_below(depth: np.ndarray, frame: ViewFrame) -> np.ndarray:
    """Depth of each pixel below its surroundings, metres; 0 outside the body.

    Luft, Colditz and Deussen (2006), doi:10.1145/1141911.1142016.
    """
    covered, reach = np.isfinite(depth), CREASE_M * frame.size / frame.width
    filled = np.where(covered, depth, 0.0)
    around = gaussian_filter(filled, reach) / np.maximum(gaussian_filter(covered.astype(float), reach), 1e-9)
    return np.where(covered, filled - around, 0.0)


def _brightness(
    body: Body | Surface, frame: ViewFrame, corners: np.ndarray, weights: np.ndarray, below: np.ndarray
) -> np.ndarray:
    """Brightness of places on the body, 0 to 1: soft lamps, less in creases."""
    normals = np.einsum("kc,kcx->kx", weights, body.vertex_normals[corners])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-9)
    across, deep, up = normals @ frame.right, -normals @ frame.towards_camera, normals[:, 2]
    bright = np.zeros(len(normals))
    for direction, strength in LIGHTS:
        towards = np.array(direction) / np.linalg.norm(direction)
        bright += strength * np.clip(0.5 + 0.5 * np.stack([across, deep, up], axis=1) @ towards, 0, 1) ** 1.5
    bright = bright / np.percentile(bright, 95) - CREASE * np.clip(below, -0.01, 0.04)
    return np.clip(bright, 0, 1)


def _bytes(values: np.ndarray) -> np.ndarray:
    """Values from 0 to 1 as bytes."""
    return np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)


class BodyPictures:
    """Square pictures of one body in many colours, softly shaded so that its shape can be read.

    The shading is computed once; then each picture is only coloured. Views are "front", "left", "back" and
    "right".
    """

    def __init__(self, body: Body, size: int = 900, views: Sequence[str] = ("front", "back")) -> None:
        self.body = body
        self.size = size
        self.frames = tuple(ViewFrame.of(body, view, size) for view in views)
        self._shades = [_Shade(body, frame) for frame in self.frames]

    def coloured(self, vertex_colours: np.ndarray) -> list[np.ndarray]:
        """One picture for each view, in these colours of the vertices: sRGB, 0 to 1, shape (V, 3).

        A picture has shape (size, size, 4), uint8: sRGB and straight alpha, the upper row first; it is
        transparent around the body.
        """
        return [shade.over(vertex_colours, self.size) for shade in self._shades]

    def locate(self, points: np.ndarray, normals: np.ndarray) -> list[tuple[int, float, float]]:
        """View, column and row at which each place on the body is seen best: see `locate`."""
        return locate(self.frames, points, normals)


def locate(
    frames: Sequence[ViewFrame], points: np.ndarray, normals: np.ndarray
) -> list[tuple[int, float, float]]:
    """View, column and row at which each place on a body is seen best; view -1 if it is turned from all.

    Places are points (N, 3), metres, with outward normals (N, 3); each is best seen in the view whose
    camera it faces most.
    """
    facing = np.asarray(normals) @ np.stack([frame.towards_camera for frame in frames], axis=1)
    pixels = np.stack([frame.to_pixels(points) for frame in frames])
    return [
        (
            int(view) if facing[index, view] >= 0 else -1,
            float(pixels[view, index, 0]),
            float(pixels[view, index, 1]),
        )
        for index, view in enumerate(facing.argmax(axis=1))
    ]


def size_for(body: Body, pixels: float) -> int:
    """Size of pictures in which a body is `pixels` high."""
    return round(pixels * ViewFrame.of(body, "front", 1).width / body.height)


def common_crop(views: Sequence[np.ndarray]) -> tuple[int, int, int, int]:
    """Rows and columns (top, bottom, left, right) that hold the body in every view."""
    covered = np.any([view[..., 3] > 0 for view in views], axis=0)
    rows, columns = np.flatnonzero(covered.any(axis=1)), np.flatnonzero(covered.any(axis=0))
    return int(rows[0]), int(rows[-1]) + 1, int(columns[0]), int(columns[-1]) + 1
