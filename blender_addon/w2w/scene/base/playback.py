# SPDX-License-Identifier: GPL-3.0-or-later
"""Step through the frames of the scene, read meshes there, and restore the scene."""

from collections.abc import Generator, Iterator
from contextlib import AbstractContextManager, contextmanager

import numpy as np
from scipy.sparse import csr_matrix

from ...core.patches.patches import PatchSet
from . import actions
from .body import matrix
from .module import bpy
from .patches import PATCH

TAG = "W2W vertex tag"
"""Attribute that distinguishes a mesh's own vertices from those that modifiers make."""


def active_action(armature: bpy.types.Object) -> bpy.types.Action | None:
    """The action that an armature plays."""
    return armature.animation_data.action if armature.animation_data else None


def each_frame(frames: np.ndarray) -> Generator[int, None, None]:
    """Put the scene on each frame in turn, and back at the end."""
    scene = bpy.context.scene
    current, part = scene.frame_current, scene.frame_subframe
    try:
        for number, frame in enumerate(frames):
            whole = int(np.floor(frame))
            scene.frame_set(whole, subframe=float(frame - whole))
            yield number
    finally:
        scene.frame_set(current, subframe=part)


def same_timing() -> AbstractContextManager[None]:
    """Keep the scene's frame rate and range, which importers set to a file's."""
    scene = bpy.context.scene
    return kept((scene.render, "fps", "fps_base"), (scene, "frame_start", "frame_end"))


@contextmanager
def kept(*settings: tuple) -> Iterator[None]:
    """Put settings, each an owner and names of its attributes, back at the end."""
    before = [(owner, name, getattr(owner, name)) for owner, *names in settings for name in names]
    try:
        yield
    finally:
        for owner, name, value in before:
            setattr(owner, name, value)


@contextmanager
def at_rate(rate: float) -> Iterator[None]:
    """Set the scene's frames per second, and restore them at the end."""
    with same_timing():
        if rate != actions.scene_rate():
            actions.set_scene_rate(rate)
        yield


@contextmanager
def playing(armature: bpy.types.Object, action: bpy.types.Action | None) -> Iterator[None]:
    """Let the armature play an action, and the one it played before at the end."""
    before = active_action(armature)
    if action is None or action == before:
        yield
        return
    slot = getattr(armature.animation_data, "action_slot", None)
    actions.show_action(armature, action)
    try:
        yield
    finally:
        armature.animation_data.action = before
        if slot is not None:
            armature.animation_data.action_slot = slot


@contextmanager
def without_empties(mesh: bpy.types.Object) -> Iterator[None]:
    """Leave collections of this body's empties out of evaluation: they cost more than the body."""
    view_layer = bpy.context.view_layer
    idle = [
        layer
        for layer in _layer_collections(view_layer.layer_collection)
        if not layer.exclude
        and len(layer.collection.all_objects)
        and all(PATCH in item and item.parent == mesh for item in layer.collection.all_objects)
    ]
    empties = {item for layer in idle for item in layer.collection.all_objects}
    # what is left out is deselected and shown again by that
    selected = [item for item in empties if item.select_get(view_layer=view_layer)]
    hidden = [item for item in empties if item.hide_get(view_layer=view_layer)]
    active = view_layer.objects.active
    for layer in idle:
        layer.exclude = True
    try:
        yield
    finally:
        for layer in idle:
            layer.exclude = False
        for item in selected:
            item.select_set(True, view_layer=view_layer)
        for item in hidden:
            item.hide_set(True, view_layer=view_layer)
        view_layer.objects.active = active


def _layer_collections(layer: bpy.types.LayerCollection) -> Iterator[bpy.types.LayerCollection]:
    for child in layer.children:
        yield child
        yield from _layer_collections(child)


class EvaluatedVertices:
    """Reads world positions of some vertices of a mesh from its evaluated copy, frame after frame.

    Modifiers that add or remove vertices are followed too: a vertex is found again by a tag
    that modifiers pass on and never make anew, and where they copied it the middle of its
    copies counts, as in Blender's vertex parenting. One that removes a wanted vertex is refused.
    """

    def __init__(self, mesh: bpy.types.Object, vertices: np.ndarray) -> None:
        self.mesh = mesh
        self.vertices = vertices
        self._depsgraph = bpy.context.evaluated_depsgraph_get()
        self._coordinates = np.empty((0, 3), dtype=np.float32)
        self._sources: csr_matrix | None = None

    def positions(self) -> np.ndarray:
        """World positions of the wanted vertices in the scene's current frame, metres, shape (..., 3)."""
        own, world = self._own()
        return own[self.vertices] @ world[:3, :3].T + world[:3, 3]

    def of_triangles(self) -> tuple[np.ndarray, np.ndarray]:
        """Middles (N, 3), in the world, and normals (N, 3) of the wanted triangles of vertices (N, 3)."""
        first, second, third = self.positions().swapaxes(0, 1)
        return (first + second + third) / 3, np.cross(second - first, third - first)

    def everywhere(self) -> np.ndarray:
        """World positions of the mesh's own vertices, shape (V, 3); NaN for those that a modifier removed."""
        own, world = self._own()
        return own @ world[:3, :3].T + world[:3, 3]

    def _own(self) -> tuple[np.ndarray, np.ndarray]:
        """The mesh's own vertices in its own space, and its matrix to the world."""
        evaluated = self.mesh.evaluated_get(self._depsgraph)
        n_vertices = len(evaluated.data.vertices)
        if n_vertices != len(self._coordinates):
            self._sources = None if n_vertices == len(self.mesh.data.vertices) else self._find_sources()
            evaluated = self.mesh.evaluated_get(self._depsgraph)
            self._coordinates = np.empty((n_vertices, 3), dtype=np.float32)
        evaluated.data.attributes["position"].data.foreach_get("vector", self._coordinates.ravel())
        world = matrix(evaluated.matrix_world)
        if self._sources is None:
            return self._coordinates, world
        own = self._sources @ self._coordinates
        own[np.diff(self._sources.indptr) == 0] = np.nan
        return own, world

    def _find_sources(self) -> csr_matrix:
        """Share of each evaluated vertex in each vertex of the mesh, shape (V, evaluated)."""
        # vectors of which none is a mean of others, the first components distinct
        generator, n_vertices = np.random.default_rng(0), len(self.mesh.data.vertices)
        tags = generator.random((n_vertices, 3), dtype=np.float32)
        tags[:, 0] = (generator.permutation(n_vertices) + 1) / (n_vertices + 1)
        found = self._evaluated_tags(tags)
        order = np.argsort(tags[:, 0])
        places = np.searchsorted(tags[order, 0], found[:, 0])
        owners = order[np.minimum(places, len(order) - 1)]
        columns = np.flatnonzero((tags[owners] == found).all(axis=1))
        copies = np.bincount(owners[columns], minlength=len(tags))
        lost = np.setdiff1d(self.vertices, np.flatnonzero(copies))
        if len(lost):
            raise ValueError(
                f"the modifiers of '{self.mesh.name}' remove {len(lost)} of the vertices under patches: "
                "switch off the one that does so in the viewport"
            )
        rows = owners[columns]
        return csr_matrix((1 / copies[rows], (rows, columns)), shape=(len(tags), len(found)))

    def _evaluated_tags(self, tags: np.ndarray) -> np.ndarray:
        attributes = self.mesh.data.attributes
        attributes.new(TAG, "FLOAT_VECTOR", "POINT").data.foreach_set("vector", tags.ravel())
        try:
            self._depsgraph.update()
            evaluated = self.mesh.evaluated_get(self._depsgraph).data
            values = np.zeros((len(evaluated.vertices), 3), dtype=np.float32)
            if TAG in evaluated.attributes:
                evaluated.attributes[TAG].data.foreach_get("vector", values.ravel())
        finally:
            attributes.remove(attributes[TAG])
            self._depsgraph.update()
        return values


def spot_at(
    depsgraph: bpy.types.Depsgraph,
    body: bpy.types.Object,
    patches: PatchSet,
    face: int,
    point: np.ndarray,
    shown: bpy.types.Object | None = None,
) -> tuple[int, int]:
    """Patch of a point in the world, on this face of the evaluated body, and the vertex nearest to it.

    `shown` is the clicked object if it is a copy of the body; the vertex is -1 if a modifier has made other
    vertices than the body's.
    """
    evaluated = (shown or body).evaluated_get(depsgraph)
    mesh, world = evaluated.data, matrix(evaluated.matrix_world)
    if len(mesh.vertices) == len(patches.labels):
        corners = list(mesh.polygons[face].vertices)
        points = np.array([mesh.vertices[corner].co for corner in corners]) @ world[:3, :3].T + world[:3, 3]
        vertex = corners[int(np.linalg.norm(points - point, axis=1).argmin())]
        return int(patches.labels[vertex]), vertex
    # a modifier has made other vertices: the nearest carrier triangle stands for its patch
    points = EvaluatedVertices(body, patches.triangles).positions().mean(axis=1)
    return int(np.linalg.norm(points - point, axis=1).argmin()), -1
