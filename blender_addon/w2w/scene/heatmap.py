# SPDX-License-Identifier: GPL-3.0-or-later
"""Expected F1 as colour attributes of a body's mesh, and a second map on a copy next to the body."""

from collections.abc import Callable, Sequence

import numpy as np

from ..core.body.body import Body
from ..core.colours import Scale, mannequin_colours
from ..core.patches.patches import PatchSet
from .base.body import matrix, moved, painted_colours, rest_vertices
from .base.module import bpy
from .base.patches import check_patches

MEAN = "Expected F1"
ON_THESE_CLIPS = "F1 on these clips"
"""Title of heatmaps of the raw F1."""

DIFFERENCE = "Difference of F1"
"""The heatmap of a difference of two others."""

MANNEQUIN = "Mannequin"
"""The colours of a body without a map."""

MAX_NAME_BYTES = 63
"""Longer names of attributes are cut by Blender at different lengths in different versions."""

BESIDE = "w2w beside"
"""Custom property of a body's copy: name of the body that it was copied from."""

GAP = 0.15
"""Metres between the two at rest."""

ASIDE = "Beside"
"""Name of the modifier that moves the copy's surface aside."""


def add_heatmaps(
    mesh: bpy.types.Object,
    patches: PatchSet,
    utility_f1: np.ndarray,
    activities: Sequence[str],
    mean: np.ndarray,
    title: str = MEAN,
    scale: Callable[[np.ndarray], Scale] = Scale.of,
) -> list[str]:
    """Paint colour attributes on the mesh for the mean (N,) and each activity (N, A), and show the mean.

    Heatmaps of an earlier call are replaced. `title` says what the scores are: `MEAN` or `ON_THESE_CLIPS`,
    and `scale` gives the colours of each heatmap's. Returns the names of the attributes: the mean, then the
    activities. Raises `ValueError` if the patches do not fit the mesh.
    """
    check_patches(mesh, patches)
    remove_heatmaps(mesh)
    names = _attribute_names(activities, title)
    for name, scores in zip(names, np.column_stack([mean, utility_f1]).T, strict=True):
        paint_colours(mesh.data, name, map_colours(mesh, scale(scores), patches, scores))
    show_heatmap(mesh, names[0])
    return names


def dress(mesh: bpy.types.Object, body: Body) -> None:
    """Show a body without a map as a mannequin."""
    paint_colours(mesh.data, MANNEQUIN, mannequin_colours(body))
    mesh.data.materials.append(heatmap_material())
    show_heatmap(mesh, MANNEQUIN)


def map_colours(mesh: bpy.types.Object, scale: Scale, patches: PatchSet, scores: np.ndarray) -> np.ndarray:
    """Colours (V, 3) of a map of scores (N,) on a body, or the mannequin's where all places do alike."""
    plain = mesh.data.color_attributes.get(MANNEQUIN)
    if not scale.is_alike or plain is None:
        return scale.colours(patches, scores)
    return painted_colours(plain)


def add_difference(mesh: bpy.types.Object, patches: PatchSet, scores: np.ndarray) -> None:
    """Paint the difference of two heatmaps, in addition to those of `add_heatmaps`, in its own colours."""
    paint_colours(mesh.data, DIFFERENCE, Scale.of_difference(scores).colours(patches, scores))


def show_heatmap(mesh: bpy.types.Object, name: str) -> None:
    """Make a colour attribute the one that the viewport, materials and renders show."""
    attributes = mesh.data.color_attributes
    index = attributes.find(name)
    if index < 0:
        raise ValueError(
            f"'{mesh.name}' has no heatmap '{name}', only: {', '.join(attributes.keys()) or 'none'}"
        )
    attributes.active_color_index = attributes.render_color_index = index


def heatmap_names(mesh: bpy.types.Object) -> list[str]:
    """Names of a mesh's heatmaps, the mean first, a difference last."""
    names = mesh.data.color_attributes.keys()
    means = (MEAN, ON_THESE_CLIPS)
    prefixes = tuple(f"{title}: " for title in means)
    maps = [name for name in names if name in means] + [name for name in names if name.startswith(prefixes)]
    return maps + [name for name in names if name == DIFFERENCE]


def remove_heatmaps(mesh: bpy.types.Object) -> None:
    """Remove all heatmaps of a mesh, and no other attribute."""
    for name in heatmap_names(mesh):
        mesh.data.color_attributes.remove(mesh.data.color_attributes[name])
    if MANNEQUIN in mesh.data.color_attributes:
        show_heatmap(mesh, MANNEQUIN)


def heatmap_material() -> bpy.types.Material:
    """A matt material that shows the heatmap chosen with `show_heatmap`, in every renderer."""
    material = bpy.data.materials.new("Heatmap")
    if material.node_tree is None:  # from 5.0 on every material has nodes
        material.use_nodes = True
    nodes = material.node_tree.nodes
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    colour = nodes.new("ShaderNodeVertexColor")
    colour.location = (surface.location.x - 300, surface.location.y)
    surface.inputs["Roughness"].default_value = 0.7
    material.node_tree.links.new(colour.outputs["Color"], surface.inputs["Base Color"])
    return material


def _attribute_names(activities: Sequence[str], title: str) -> list[str]:
    """A name for the mean and each activity, cut and numbered so that Blender keeps them all as they are."""
    names = [title]
    for activity in activities:
        name, copy = _cut(f"{title}: {activity}", MAX_NAME_BYTES), 1
        while name in names:
            copy += 1
            name = f"{_cut(f'{title}: {activity}', MAX_NAME_BYTES - 4)} {copy:03d}"
        names.append(name)
    return names


def _cut(name: str, n_bytes: int) -> str:
    return name.encode()[:n_bytes].decode(errors="ignore").strip()


def paint_colours(mesh: bpy.types.Mesh, name: str, colours: np.ndarray) -> None:
    """Add a colour attribute with these colours, sRGB, shape (V, 3)."""
    attribute = mesh.color_attributes.new(name, "BYTE_COLOR", "POINT")
    values = np.ones((len(colours), 4), dtype=np.float32)
    values[:, :3] = colours
    attribute.data.foreach_set("color_srgb", values.ravel())


def add_beside(mesh: bpy.types.Object, model: bpy.types.Object) -> bpy.types.Object:
    """Add a copy of a model, this body or another, for `follow` to put next to a body; it cannot be selected.

    The surface is moved aside after the armature has posed it: the copy needs no armature of its own.
    """
    copy = bpy.data.objects.new(f"{mesh.name} Beside", model.data.copy())
    copy[BESIDE] = model.name
    copy.parent, copy.parent_type = model.parent, model.parent_type
    copy.matrix_parent_inverse = model.matrix_parent_inverse
    copy.matrix_basis = model.matrix_basis
    for modifier in model.modifiers:
        if modifier.type == "ARMATURE":
            posed = copy.modifiers.new(modifier.name, "ARMATURE")
            posed.object = modifier.object
            posed.use_deform_preserve_volume = modifier.use_deform_preserve_volume
    aside = copy.modifiers.new(ASIDE, "DISPLACE")
    aside.direction, aside.space, aside.mid_level = "X", "LOCAL", 0.0
    copy.hide_select = True
    (mesh.users_collection or (bpy.context.scene.collection,))[0].objects.link(copy)
    return copy


def fits(copy: bpy.types.Object, model: bpy.types.Object) -> bool:
    """Whether a copy is still one of this body."""
    return copy.get(BESIDE) == model.name and len(copy.data.vertices) == len(model.data.vertices)


def follow(copy: bpy.types.Object, mesh: bpy.types.Object, model: bpy.types.Object) -> None:
    """Give a copy the shape that its model has now, and put it next to the body again."""
    model.update_from_editmode()
    points = rest_vertices(model)
    copy.data.vertices.foreach_set("co", points.astype(np.float32).ravel())
    copy.data.update()
    right_edge = float(moved(rest_vertices(mesh), matrix(mesh.matrix_world))[:, 0].max())
    from_body = right_edge - matrix(model.matrix_world)[0, 3]
    world = matrix(model.matrix_world)[:3, :3]
    reach = float((points @ world.T)[:, 0].min())
    aside = next(modifier for modifier in copy.modifiers if modifier.name == ASIDE)
    aside.strength = (from_body + GAP - reach) / max(float(np.linalg.norm(world[:, 0])), 1e-9)


def paint_beside(copy: bpy.types.Object, name: str, colours: np.ndarray) -> None:
    """Show one map on a copy, in place of the one before; colours are sRGB, shape (V, 3)."""
    remove_heatmaps(copy)
    paint_colours(copy.data, name, colours)
    show_heatmap(copy, name)


def remove_beside(copies: Sequence[bpy.types.Object]) -> None:
    """Remove copies and their meshes."""
    bpy.data.batch_remove([*copies, *(copy.data for copy in copies)])
