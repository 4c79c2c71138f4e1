# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a coloured body from the front and from behind, rendered by Workbench without a window."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType

import bpy
import numpy as np
from mathutils.bvhtree import BVHTree
from scipy.ndimage import distance_transform_edt
from scipy.sparse import csr_array

from ..core.body.body import Body

Marker = tuple[Sequence[float], Sequence[float]]
"""Where a marker is, metres, and its sRGB colour."""

VIEW_TURNS = {"front": 0.0, "left": np.pi / 2, "back": np.pi, "right": -np.pi / 2}
"""Turn of the camera about the body for each view; the body faces -y."""

MARGIN = 1.04
SHADE_DEPTH = 0.5
"""How much darker than its colour the darkest shade of the body is."""

GLEAM = 0.06
"""How far towards white the brightest parts are lifted, without which dark colours hide the shape."""

MARKER_RADIUS = 0.011
"""Radius of a marker, in heights of the body."""


@dataclass(frozen=True)
class ViewFrame:
    """Where points of the world are in a picture taken by `BodyRenderer`.

    Parameters
    ----------
    name : str
        Name of the view.
    turn : float
        Turn of the camera about z, radians; 0 looks along +y.
    centre : ndarray, shape (3,)
        World point in the middle of the picture, metres.
    width : float
        Metres from one edge of the picture to the other.
    size : int
        Pixels from one edge to the other.
    """

    name: str
    turn: float
    centre: np.ndarray
    width: float
    size: int

    @property
    def towards_camera(self) -> np.ndarray:
        """Unit vector from the body to the camera."""
        return np.array([np.sin(self.turn), -np.cos(self.turn), 0.0])

    def to_pixels(self, points: np.ndarray) -> np.ndarray:
        """Pixel coordinates of points, from the upper left corner.

        Parameters
        ----------
        points : ndarray, shape (..., 3)
            World positions, metres.

        Returns
        -------
        ndarray, shape (..., 2)
            Column and row.
        """
        offsets = np.asarray(points, dtype=np.float64) - self.centre
        right = np.array([np.cos(self.turn), np.sin(self.turn), 0.0])
        scale = self.size / self.width
        return np.stack([offsets @ right, -offsets[..., 2]], axis=-1) * scale + self.size / 2

    def from_pixels(self, pixels: np.ndarray) -> np.ndarray:
        """Points in front of the body at these pixel coordinates, for rays away from the camera.

        Parameters
        ----------
        pixels : ndarray, shape (..., 2)
            Column and row, from the upper left corner.

        Returns
        -------
        ndarray, shape (..., 3)
            World positions, metres.
        """
        across, down = np.moveaxis((np.asarray(pixels) - self.size / 2) * (self.width / self.size), -1, 0)
        right, up = np.array([np.cos(self.turn), np.sin(self.turn), 0.0]), np.array([0.0, 0.0, 1.0])
        before = self.centre + 2 * self.width * self.towards_camera
        return before + across[..., None] * right - down[..., None] * up


@dataclass(frozen=True)
class _Shade:
    """Light and outline of one view, and where on the body its pixels lie: all of a picture but its colours.

    All is of the K pixels `shown`, flat indices of those that are not transparent. `share`, shape (K, V), is
    how much of each vertex's colour shines there, `gleam`, shape (K, 1), what white is added, and `alpha`,
    shape (K,), uint8, how much the body covers.
    """

    share: csr_array
    gleam: np.ndarray
    alpha: np.ndarray
    shown: np.ndarray

    @classmethod
    def of(
        cls, picture: np.ndarray, frame: ViewFrame, tree: BVHTree, vertices: np.ndarray, faces: np.ndarray
    ) -> _Shade:
        """From a picture of the white body, whose tree has its triangles."""
        brightness = picture[..., :3].mean(axis=-1)
        # Workbench's samples of a solid surface add up to 0.99
        alpha = picture[..., 3] / max(picture[..., 3].max(), np.finfo(np.float32).tiny)
        solid = alpha > 0.99
        brightest = np.percentile(brightness[solid], 95) if solid.any() else 1.0
        bright = np.clip(brightness / brightest, 0, 1)
        light = 1 - SHADE_DEPTH * (1 - bright)
        gleam = GLEAM * np.clip(2 * bright - 1, 0, 1) ** 2
        shown = np.flatnonzero(alpha > 0)
        light, gleam, alpha = (values.ravel()[shown] for values in (light, gleam, alpha))
        triangles, weights = _seen(frame, shown, tree, vertices, faces)
        shining = (weights * (light - gleam)[:, None]).astype(np.float32)
        starts = np.arange(0, shining.size + 1, 3)
        share = csr_array((shining.ravel(), faces[triangles].ravel(), starts), (len(shown), len(vertices)))
        return cls(share, gleam[:, None], _bytes(alpha), shown)

    def over(self, colours: np.ndarray, size: int) -> np.ndarray:
        """A picture in these colours of the vertices, shape (V, 3)."""
        drawn = np.empty((len(self.shown), 4), dtype=np.uint8)
        drawn[:, :3] = _bytes(self.share @ colours.astype(np.float32) + self.gleam)
        drawn[:, 3] = self.alpha
        picture = np.zeros(size * size, dtype=np.uint32)  # a pixel's bytes are put in their place at once
        picture[self.shown] = drawn.view(np.uint32)[:, 0]
        return picture.view(np.uint8).reshape(size, size, 4)


def _bytes(values: np.ndarray) -> np.ndarray:
    """From 0 to 1 as bytes."""
    return np.rint(np.clip(values, 0, 1) * 255).astype(np.uint8)


def _seen(
    frame: ViewFrame, shown: np.ndarray, tree: BVHTree, vertices: np.ndarray, faces: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The triangle (K,) that each pixel's centre shows, and the weights (K, 3) of its corners there.

    Pixels of the soft outline, whose centre shows none, have those of the nearest one that does.
    """
    rows, columns = np.divmod(shown, frame.size)
    centres = np.stack([columns, rows], axis=-1) + 0.5
    away = (-frame.towards_camera).tolist()
    found = [tree.ray_cast(start, away)[2] for start in frame.from_pixels(centres).tolist()]
    hit = np.array([index is not None for index in found], dtype=bool)
    if not hit.any():
        raise ValueError("Blender drew no body")
    covered = np.zeros((frame.size, frame.size), dtype=bool)
    covered[rows[hit], columns[hit]] = True
    nearest = distance_transform_edt(~covered, return_distances=False, return_indices=True)
    place = np.searchsorted(shown, np.ravel_multi_index(nearest[:, rows, columns], covered.shape))
    triangles = np.array([index or 0 for index in found])[place]
    return triangles, _weights(centres[place], frame.to_pixels(vertices[faces[triangles]]))


def _weights(points: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Weights (K, 3) by which the corners (K, 3, 2) of triangles make up points (K, 2)."""
    opposite = np.roll(corners, -2, axis=1) - np.roll(corners, -1, axis=1)
    apart = points[:, None] - np.roll(corners, -1, axis=1)
    areas = opposite[..., 0] * apart[..., 1] - opposite[..., 1] * apart[..., 0]
    return areas / areas.sum(axis=1, keepdims=True)


class BodyRenderer:
    """Pictures of one body in many colours, from a scene of its own that is removed at the end.

    The colours of the pictures are those of the vertices, darkened by soft shading so that
    the shape can be read. Blender renders the shading once; then each picture is only coloured.

    Use it as a context manager::

        with BodyRenderer(body) as renderer:
            front, back = renderer.render(score_colours(scores))

    Parameters
    ----------
    body : Body
    size : int
        Width and height of the pictures, pixels.
    views : sequence of str
        Any of "front", "left", "back", "right".

    Raises
    ------
    ValueError
        If a view has another name.
    """

    def __init__(self, body: Body, size: int = 900, views: Sequence[str] = ("front", "back")) -> None:
        unknown = [view for view in views if view not in VIEW_TURNS]
        if unknown:
            raise ValueError(f"unknown view '{unknown[0]}': choose among {', '.join(VIEW_TURNS)}")
        self.body = body
        self.size = size
        self.frames = tuple(_view_frame(body, view, size) for view in views)
        self._shades: list[_Shade] | None = None

    def __enter__(self) -> BodyRenderer:
        self._folder = tempfile.TemporaryDirectory(prefix="w2w_render_")
        self._scene = bpy.data.scenes.new("W2W Pictures")
        self._object = _add_mesh(self._scene, "W2W Pictured Body", self.body.vertices, self.body.faces)
        _prepare(self._scene, self.size)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        camera = self._scene.camera
        mesh = self._object.data
        bpy.data.batch_remove([self._scene, self._object, camera, mesh, camera.data])
        self._folder.cleanup()

    def render(self, vertex_colours: np.ndarray, markers: Sequence[Marker] = ()) -> list[np.ndarray]:
        """Pictures of the body in these colours, one a view.

        Parameters
        ----------
        vertex_colours : ndarray, shape (V, 3)
            sRGB, 0 to 1.
        markers : sequence of (position, colour)
            Balls to put on the body: position in metres, shape (3,), and sRGB colour.

        Returns
        -------
        list of ndarray, shape (size, size, 4), uint8
            sRGB and straight alpha, the upper row first; transparent around the body.

        Raises
        ------
        ValueError
            If there is not one colour a vertex.
        """
        colours = np.asarray(vertex_colours, dtype=np.float64)
        if colours.shape != self.body.vertices.shape:
            raise ValueError(
                f"vertex_colours must have shape {self.body.vertices.shape}, not {colours.shape}"
            )
        if not len(markers):
            if self._shades is None:
                self._shades = self._shade_pass(self.body.vertices, self.body.faces)
            return [shade.over(colours, self.size) for shade in self._shades]
        vertices, faces, ball_colours = _balls(markers, self.body.height * MARKER_RADIUS)
        balls = _add_mesh(self._scene, "W2W Markers", vertices, faces)
        try:
            shades = self._shade_pass(
                np.concatenate([self.body.vertices, vertices]),
                np.concatenate([self.body.faces, faces + len(self.body.vertices)]),
            )
        finally:
            bpy.data.batch_remove([balls, balls.data])
        return [shade.over(np.concatenate([colours, ball_colours]), self.size) for shade in shades]

    def locate(self, points: np.ndarray, normals: np.ndarray) -> list[tuple[int, float, float]]:
        """In which picture, and where in it, places on the body are seen best.

        Parameters
        ----------
        points : ndarray, shape (N, 3)
            Positions on the body, metres.
        normals : ndarray, shape (N, 3)
            Outward normals there.

        Returns
        -------
        list of (view, column, row)
            Index of the view whose camera the place faces most, and its pixel there.
        """
        facing = np.asarray(normals) @ np.stack([frame.towards_camera for frame in self.frames], axis=1)
        pixels = np.stack([frame.to_pixels(points) for frame in self.frames])
        return [
            (int(view), float(pixels[view, index, 0]), float(pixels[view, index, 1]))
            for index, view in enumerate(facing.argmax(axis=1))
        ]

    def _shade_pass(self, vertices: np.ndarray, faces: np.ndarray) -> list[_Shade]:
        """The white body in studio light, with five samples a pixel (16 look alike)."""
        tree = BVHTree.FromPolygons(vertices.tolist(), faces.tolist(), all_triangles=True)
        return [_Shade.of(self._picture(frame), frame, tree, vertices, faces) for frame in self.frames]

    def _picture(self, frame: ViewFrame) -> np.ndarray:
        """One rendered view, shape (size, size, 4), sRGB with straight alpha, 0 to 1."""
        camera = self._scene.camera
        camera.data.ortho_scale = frame.width
        camera.location = frame.centre + frame.towards_camera * 2 * frame.width
        camera.rotation_euler = (np.pi / 2, 0.0, frame.turn)
        path = Path(self._folder.name) / "view.png"
        self._scene.render.filepath = str(path)
        bpy.ops.render.render(write_still=True, scene=self._scene.name)
        return _read_picture(path, self.size)


def size_for(body: Body, pixels: float) -> int:
    """Size of pictures in which a body is so many pixels high."""
    return round(pixels * _view_frame(body, "front", 1).width / body.height)


def _view_frame(body: Body, view: str, size: int) -> ViewFrame:
    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    return ViewFrame(view, VIEW_TURNS[view], (low + high) / 2, float((high - low).max()) * MARGIN, size)


def _prepare(scene: bpy.types.Scene, size: int) -> None:
    camera = bpy.data.objects.new("W2W Camera", bpy.data.cameras.new("W2W Camera"))
    camera.data.type = "ORTHO"
    scene.collection.objects.link(camera)
    scene.camera = camera
    render = scene.render
    render.engine = "BLENDER_WORKBENCH"
    render.resolution_x = render.resolution_y = size
    render.resolution_percentage = 100
    render.film_transparent = True
    render.use_compositing = render.use_sequencer = False
    render.image_settings.file_format = "PNG"
    render.image_settings.color_mode = "RGBA"
    render.image_settings.compression = 0
    scene.view_settings.view_transform = "Standard"
    scene.display.render_aa = "5"
    shading = scene.display.shading
    shading.light, shading.color_type, shading.single_color = "STUDIO", "SINGLE", (1.0, 1.0, 1.0)
    shading.show_cavity = True
    shading.show_object_outline = shading.show_specular_highlight = False
    shading.cavity_type = "BOTH"


def _add_mesh(scene: bpy.types.Scene, name: str, vertices: np.ndarray, faces: np.ndarray) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.shade_smooth()
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    return item


def _balls(markers: Sequence[Marker], radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Vertices, triangles and vertices' colours of a ball at each marker."""
    ball, faces = _ball()
    centres = np.array([position for position, _ in markers], dtype=np.float64)
    colours = np.array([colour for _, colour in markers], dtype=np.float64)
    vertices = (centres[:, None] + ball * radius).reshape(-1, 3)
    starts = np.arange(len(markers))[:, None, None] * len(ball)
    return vertices, (faces + starts).reshape(-1, 3), np.repeat(colours, len(ball), axis=0)


def _ball(segments: int = 24, rings: int = 12) -> tuple[np.ndarray, np.ndarray]:
    """A unit ball: vertices on a grid of latitude and longitude, and triangles."""
    polar, around = np.meshgrid(
        np.linspace(0, np.pi, rings + 1), np.linspace(0, 2 * np.pi, segments, endpoint=False), indexing="ij"
    )
    vertices = np.stack(
        [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1
    )
    ring, segment = np.meshgrid(np.arange(rings), np.arange(segments), indexing="ij")
    here, beside = ring * segments + segment, ring * segments + (segment + 1) % segments
    upper = np.stack([here, here + segments, beside + segments], axis=-1)
    lower = np.stack([here, beside + segments, beside], axis=-1)
    return vertices.reshape(-1, 3), np.concatenate([upper.reshape(-1, 3), lower.reshape(-1, 3)])


def _read_picture(path: Path, size: int) -> np.ndarray:
    image = bpy.data.images.load(str(path))
    try:
        pixels = np.empty(size * size * 4, dtype=np.float32)
        image.pixels.foreach_get(pixels)
    finally:
        bpy.data.images.remove(image)
    return pixels.reshape(size, size, 4)[::-1]
