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
from scipy.ndimage import distance_transform_edt

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


@dataclass(frozen=True)
class _Shade:
    """Light and outline of one view: all of a picture but its colours.

    `light` and `gleam`, shape (K, 1), and `alpha`, shape (K,), are of the pixels `shown`, flat indices of
    those that are not transparent; `nearest` are the covered ones nearest to them, whose colours they take.
    """

    light: np.ndarray
    gleam: np.ndarray
    alpha: np.ndarray
    shown: np.ndarray
    nearest: np.ndarray

    @classmethod
    def of(cls, picture: np.ndarray, covered: np.ndarray) -> _Shade:
        """From a picture of the white body, and the pixels that one sample finds covered."""
        brightness = picture[..., :3].mean(axis=-1)
        # Workbench's samples of a solid surface add up to 0.99
        alpha = picture[..., 3] / max(picture[..., 3].max(), np.finfo(np.float32).tiny)
        solid = alpha > 0.99
        brightest = np.percentile(brightness[solid], 95) if solid.any() else 1.0
        bright = np.clip(brightness / brightest, 0, 1)
        light = 1 - SHADE_DEPTH * (1 - bright)
        gleam = GLEAM * np.clip(2 * bright - 1, 0, 1) ** 2
        rows, columns = distance_transform_edt(~covered, return_distances=False, return_indices=True)
        shown = np.flatnonzero(alpha > 0)
        nearest = (rows * covered.shape[1] + columns).ravel()[shown]
        light, gleam, alpha = (values.ravel()[shown] for values in (light, gleam, alpha))
        return cls(light[:, None], gleam[:, None], alpha, shown, nearest)

    def over(self, flat: np.ndarray) -> np.ndarray:
        """Shade flat colours; pixels of the soft outline take the colour of the nearest covered one."""
        own = flat.reshape(-1, 4)[self.nearest, :3]
        picture = np.zeros(flat.shape, dtype=np.uint8)
        shaded = np.column_stack([own * self.light + (1 - own) * self.gleam, self.alpha])
        picture.reshape(-1, 4)[self.shown] = np.rint(np.clip(shaded, 0, 1) * 255)
        return picture


class BodyRenderer:
    """Renders one body in many colours, in a scene of its own that is removed at the end.

    The colours of the pictures are those of the vertices, darkened by soft shading so that
    the shape can be read; the shading is rendered once for all pictures.

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
        _set_colours(self._object.data, colours)
        balls = _add_balls(self._scene, markers, self.body.height * MARKER_RADIUS)
        try:
            shades = self._shades if self._shades and not balls else self._shade_pass()
            if not balls:
                self._shades = shades
            return [shade.over(flat) for shade, flat in zip(shades, self._flat_pass(), strict=True)]
        finally:
            if balls:
                bpy.data.batch_remove([balls, balls.data])

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

    def _flat_pass(self) -> list[np.ndarray]:
        """The vertices' own colours, one sample a pixel: `_Shade` knows the smooth outline."""
        shading = self._scene.display.shading
        shading.light, shading.color_type, shading.show_cavity = "FLAT", "VERTEX", False
        self._scene.display.render_aa = "OFF"
        return self._pictures()

    def _shade_pass(self) -> list[_Shade]:
        """The white body in studio light, with five samples a pixel (16 look alike): slow, but done once."""
        shading = self._scene.display.shading
        covered = [picture[..., 3] > 0.5 for picture in self._flat_pass()]
        shading.light, shading.color_type, shading.show_cavity = "STUDIO", "SINGLE", True
        self._scene.display.render_aa = "5"
        return [_Shade.of(picture, mask) for picture, mask in zip(self._pictures(), covered, strict=True)]

    def _pictures(self) -> list[np.ndarray]:
        return [self._picture(frame) for frame in self.frames]

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
    shading = scene.display.shading
    shading.single_color = (1.0, 1.0, 1.0)
    shading.show_object_outline = shading.show_specular_highlight = False
    shading.cavity_type = "BOTH"


def _add_mesh(scene: bpy.types.Scene, name: str, vertices: np.ndarray, faces: np.ndarray) -> bpy.types.Object:
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.shade_smooth()
    mesh.color_attributes.new("colour", "FLOAT_COLOR", "POINT")
    item = bpy.data.objects.new(name, mesh)
    scene.collection.objects.link(item)
    return item


def _set_colours(mesh: bpy.types.Mesh, colours: np.ndarray) -> None:
    values = np.ones((len(colours), 4), dtype=np.float32)
    values[:, :3] = colours
    mesh.color_attributes["colour"].data.foreach_set("color_srgb", values.ravel())
    mesh.update()


def _add_balls(scene: bpy.types.Scene, markers: Sequence[Marker], radius: float) -> bpy.types.Object | None:
    """One mesh of a ball at each marker."""
    if not len(markers):
        return None
    ball, faces = _ball()
    centres = np.array([position for position, _ in markers], dtype=np.float64)
    colours = np.array([colour for _, colour in markers], dtype=np.float64)
    vertices = (centres[:, None] + ball * radius).reshape(-1, 3)
    starts = np.arange(len(markers))[:, None, None] * len(ball)
    item = _add_mesh(scene, "W2W Markers", vertices, (faces + starts).reshape(-1, 3))
    _set_colours(item.data, np.repeat(colours, len(ball), axis=0))
    return item


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
