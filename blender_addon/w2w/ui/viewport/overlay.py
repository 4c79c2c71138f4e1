# SPDX-License-Identifier: GPL-3.0-or-later
"""The overlay of the 3D viewport: the colour bar, marks on picked patches and their cards."""

from collections.abc import Sequence

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from mathutils import Vector

from ...core.colours import Scale, score_colours
from ...core.patches.patches import PatchSet
from ...drawing.canvas import Colour
from ...drawing.card import BACKGROUND, GREY, PALE, HoverCard, on_one_scale
from ...drawing.colour_bar import Legend, draw_colour_bar, sizes
from ...drawing.places import Box, Place, place_all
from ...scene.base.actions import FIRST_FRAME, key_rate
from ...scene.base.patches import PATCH
from ..study import lists, scores, signal_cache, state
from . import drawing
from .drawing import Surface, disc, dots, rectangle, ring, text, width_of
from .framing import free_area
from .legend import legend, show_colours
from .places import blenders_own, seen

MARKS: tuple[tuple[str, Colour], ...] = (("A", (1.0, 0.45, 0.35, 1.0)), ("B", (0.95, 0.95, 0.95, 1.0)))
BADGE: Colour = (0.1, 0.1, 0.1, 1.0)
PIN: Colour = (0.35, 0.85, 1.0, 1.0)
NO_PICK = "Click a spot on the body first, with the tool Pick Spot (Ctrl Alt W)"

DOT = 6
"""Width of a patch's dot, pixels at a scale of 1."""

OVER_HEAD = 0.08
"""Metres from a head to the name over it."""

cards_at: dict[int, list[tuple[int, Box, Box]]] = {}
"""Patches of the cards in each region, where these stand and where closed, by the region's address."""

_stood: dict[tuple, tuple[Place, ...]] = {}
"""Where legend and cards stood when they were placed last."""

_known: set[int] = set()
"""Addresses of the spaces of 3D views that have shown a map."""

_handlers: list[object] = []


def picks(context: bpy.types.Context, body: bpy.types.Object) -> list[int]:
    """Patches looked at, one or two: the selected empties, or else those picked on the surface."""
    study = body.w2w
    picked = [patch for patch in (study.picked, study.compared) if patch >= 0]
    active = context.view_layer.objects.active
    if active is None or PATCH not in active or active.parent is not body or not active.select_get():
        return picked
    chosen = [item[PATCH] for item in context.selected_objects if PATCH in item and item.parent is body]
    if set(picked) == set(chosen):
        return picked
    others = [patch for patch in chosen if patch != active[PATCH]]
    return [*others[:1], active[PATCH]] if others else [active[PATCH]]


def draw() -> None:
    """Draw everything; Blender calls this for each 3D view."""
    context = bpy.context
    if (shown_body := _shown_body(context)) is None:
        cards_at.pop(context.region.as_pointer(), None)
        return
    (body, patches), space = shown_body, context.space_data
    scale = context.preferences.system.ui_scale
    chosen = [patch for patch in picks(context, body) if patch < len(patches)]
    cards = on_one_scale(
        [_card(context, body, patches, patch, number) for number, patch in enumerate(chosen)]
    )
    utility, outdated = state.utility_of(body.w2w), state.outdated_at_a_glance(body)
    if utility is not None:
        _colour_new(space)
    shown = legend(body.w2w, utility) if utility is not None and is_coloured(space.shading) else None
    bodies = (body, body.w2w.beside) if shown is not None and shown.beside else (body,)
    heads = _heads(context, bodies) if len(bodies) > 1 else []
    stands = _places(context, bodies, shown, cards, heads)
    if shown is not None:
        if not (cards and stands[-1].covers):
            draw_colour_bar(shown, stands[-1], drawing)
        _draw_names(shown, heads, scale)
    surface = Surface(context, body, patches)
    _draw_chosen(surface, body.w2w, scale, GREY if outdated else PALE)
    _draw_own(surface, body.w2w, scale)
    for number, patch in enumerate(chosen):
        _draw_mark(surface, patch, number, scale)
    for card, stand in zip(cards, stands, strict=False):
        card.draw(stand, drawing)
    shown_at = [(card.patch, *card.boxes(stand)) for card, stand in zip(cards, stands, strict=False)]
    cards_at[context.region.as_pointer()] = shown_at


def _places(
    context: bpy.types.Context, bodies: Sequence[bpy.types.Object], shown: Legend | None,
    cards: Sequence[HoverCard], heads: Sequence[Vector],
) -> list[Place]:  # fmt: skip
    """Where each card, then the legend if there is one, stands; while a clip plays they stay there."""
    of_cards, of_legend = [card.sizes() for card in cards], [] if shown is None else [sizes(shown, drawing)]
    scale, region = context.preferences.system.ui_scale, context.region
    things = [*of_cards, *of_legend]
    key = (region.as_pointer(), region.width, region.height, *(forms[0](scale) for forms in things))
    if context.screen.is_animation_playing and key in _stood:
        return list(_stood[key])
    free = free_area(context.area, region)
    middle = [sum(head.x for head in heads) / 2] if len(heads) == 2 else []

    def at_edges(width: float, gap: float) -> list[float]:
        return [free.left + gap, free.right - width - gap]

    def for_legend(width: float, gap: float) -> list[float]:
        return [*(x - width / 2 for x in middle), *at_edges(width, gap)[::-1]]

    clear, taken = seen(context, bodies), blenders_own(context, free, scale)
    stands = place_all(of_cards, free, clear, taken, scale, at_edges)
    taken += [stand.box(forms) for stand, forms in zip(stands, of_cards, strict=True)]
    stands += place_all(of_legend, free, clear, taken, scale, for_legend)
    _stood.clear()
    _stood[key] = tuple(stands)
    return stands


def _colour_new(space: bpy.types.SpaceView3D) -> None:
    """Show colours in a view that opens after they came, soon: nothing may be changed while it is drawn."""
    if space.as_pointer() not in _known:
        _known.add(space.as_pointer())
        if not is_coloured(space.shading):
            bpy.app.timers.register(show_colours, first_interval=0.0)


def draw_patches() -> None:
    """Draw the patches that are shown in the colours of their scores: Blender draws all empties in one."""
    context = bpy.context
    if (shown_body := _shown_body(context)) is None:
        return
    body, patches = shown_body
    utility = state.utility_of(body.w2w)
    if utility is None or not body.w2w.show_patches:
        return
    shown, size = legend(body.w2w, utility), body.w2w.patch_size
    places = Surface(context, body, patches).above(size)
    colours = score_colours(scores.shown_scores(body.w2w, utility), shown.low, shown.high, shown.colour_map)
    dots(places, colours[: len(places)], DOT * context.preferences.system.ui_scale)


def _shown_body(context: bpy.types.Context) -> tuple[bpy.types.Object, PatchSet] | None:
    """The body that a 3D view shows with its overlay, and its patches; None without one."""
    body = state.current_body(context)
    wanted = context.scene.w2w.show_overlay and context.space_data.overlay.show_overlays
    if body is None or not wanted or not body.visible_get():
        return None
    patches = state.patches_of(body)
    return None if patches is None else (body, patches)


def is_coloured(shading: bpy.types.View3DShading) -> bool:
    """Whether a 3D view shows the colours of the body's map."""
    is_solid = (shading.type, shading.color_type) == ("SOLID", "VERTEX")
    return is_solid or shading.type in ("MATERIAL", "RENDERED")


def _heads(context: bpy.types.Context, bodies: Sequence[bpy.types.Object]) -> list[Vector]:
    """Points in the region over the heads of bodies side by side; [] if one is behind the viewer."""
    points = []
    for item in bodies:
        evaluated = item.evaluated_get(context.view_layer.depsgraph)
        corners = [evaluated.matrix_world @ Vector(corner) for corner in evaluated.bound_box]
        middle = sum(corners, Vector()) / len(corners)
        middle.z = max(corner.z for corner in corners) + OVER_HEAD
        points.append(location_3d_to_region_2d(context.region, context.region_data, middle))
    return [] if None in points else points


def _draw_names(shown: Legend, heads: list[Vector], scale: float) -> None:
    """Write over the heads of two bodies side by side which map each shows."""
    for point, name in zip(heads, (shown.name, shown.beside), strict=False):
        half = width_of(name, 13 * scale) / 2 + 8 * scale
        rectangle(point.x - half, point.y - 6 * scale, 2 * half, 20 * scale, BACKGROUND)
        text(point.x, point.y, name, 13 * scale, PALE, "CENTER")


def _draw_chosen(surface: Surface, study: bpy.types.PropertyGroup, scale: float, colour: Colour) -> None:
    """Number the chosen sensors in the order of their choice, those in sight."""
    if study.chosen_collection is None:
        return
    for number, sensor in enumerate(lists.leading(study), start=1):
        point = surface.on_screen(sensor.patch)
        if point is not None and surface.in_sight(sensor.patch):
            disc(point.x, point.y, 9 * scale, colour)
            disc(point.x, point.y, 7.5 * scale, BADGE)
            text(point.x, point.y - 4 * scale, str(number), 10.5 * scale, colour, "CENTER")


def _draw_own(surface: Surface, study: bpy.types.PropertyGroup, scale: float) -> None:
    """Put a pin on each of the user's placements and the clicked spot; names there and on a character."""
    named = {own.vertex: own.name for own in study.own}
    for vertex, name in (named | {study.picked_vertex: named.get(study.picked_vertex, "")}).items():
        point = surface.spot(vertex)
        if point is not None:
            disc(point.x, point.y, 5 * scale, BADGE)
            disc(point.x, point.y, 3.5 * scale, PIN)
            text(point.x + 8 * scale, point.y - 4 * scale, name, 11 * scale, PALE)
    for ball in study.marks.objects if study.marks is not None else ():  # Blender writes names in black
        if ball.visible_get() and (point := surface.project(ball.matrix_world.translation)) is not None:
            text(point.x + 8 * scale, point.y - 4 * scale, ball.name, 11 * scale, PALE)


def _draw_mark(surface: Surface, patch: int, number: int, scale: float) -> None:
    """Put a ring and a letter on the patch as the body moves it; faint if it is hidden."""
    point = surface.on_screen(patch)
    if point is None:
        return
    strength = 1.0 if surface.in_sight(patch) else 0.35
    mark, colour = MARKS[number]
    colour = (*colour[:3], strength)
    ring(point.x, point.y, 12 * scale, (0.0, 0.0, 0.0, 0.8 * strength), 4.5 * scale)
    ring(point.x, point.y, 12 * scale, colour, 2.5 * scale)
    text(point.x + 16 * scale, point.y + 8 * scale, mark, 15 * scale, colour)


def _card(
    context: bpy.types.Context, body: bpy.types.Object, patches: PatchSet, patch: int, number: int
) -> HoverCard:
    study, utility = body.w2w, state.utility_of(body.w2w)
    mark, colour = MARKS[number]
    clip = state.playing_clip(body)
    recording = signal_cache.recording(clip) if clip is not None and clip.signals else None
    if recording is not None and recording.n_sensors != len(patches):
        recording = None
    if clip is None:
        shows = "Preview a clip (page Clips) to see its signals"
    elif recording is None:
        shows = f"Bake '{clip.name}' (page Details) to see its signals"
    else:
        shows = f"{clip.activity}: {clip.name}" if clip.activity else clip.name
    lines: tuple[str, ...] = (f"spot {patch}, not ranked yet",)
    f1, colours, score = np.zeros(0), Scale(0.0, 1.0, colour_map=study.colour_map), ""
    if utility is not None:
        lines, values = scores.patch_lines(study, utility, patch), scores.activity_scores(study, utility)
        f1, score = values[patch], f"{scores.expected_mean(study, utility)[patch]:.2f}"
        colours = scores.scale_of(study, utility) if study.fix_range else colours
    return HoverCard(
        mark=mark, colour=colour, title=patches.names[patch], lines=lines,
        activities=utility.activities if utility is not None else (),
        f1=f1, scale=colours, score=score, recording=recording, patch=patch, clip=shows,
        time=(context.scene.frame_current_final - FIRST_FRAME) / key_rate(clip and clip.action),
    )  # fmt: skip


def register() -> None:
    """Draw from now on."""
    if not bpy.app.background:
        for function, when in ((draw, "POST_PIXEL"), (draw_patches, "POST_VIEW")):
            _handlers.append(bpy.types.SpaceView3D.draw_handler_add(function, (), "WINDOW", when))


def unregister() -> None:
    """Draw no more."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
