# SPDX-License-Identifier: GPL-3.0-or-later
"""A heatmap on the body drawn by Matplotlib alone: no Blender, no window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import PolyCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure

from .core.body.body import Body
from .core.colours import COLOUR_MAP, LEAST_SPAN, colour_table, patch_colours, score_range, span_note
from .core.files import atomic_write
from .core.patches.patches import PatchSet

HEIGHT = 6.0
"""Of the figure, inches."""

SHADE = 0.45
"""How much darker than its colour skin is that turns its edge to the viewer."""


@rc_context({"text.parse_math": False})  # a name with two dollar signs is no formula
def draw_heatmap(
    path: str | Path,
    body: Body,
    patches: PatchSet,
    scores: np.ndarray,
    title: str,
    subtitle: str = "",
    label: str = "F1",
    low: float | None = None,
    high: float | None = None,
    colour_map: str = COLOUR_MAP,
    span: float = LEAST_SPAN,
) -> None:
    """Draw scores of patches on the front and the back of a body.

    Parameters
    ----------
    path : str or Path
        The suffix decides the kind of file, as Matplotlib knows it.
    body : Body, V vertices
    patches : PatchSet, N patches
        Of the same body.
    scores : ndarray, shape (N,)
        NaN where a patch has none.
    title, subtitle : str
    label : str
        What the colours stand for.
    low, high : float, optional
        Scores at the two ends of the colours; the scores' own range by default.
    colour_map : str
        A name that the `cmap` package knows.
    span : float
        F1 that the scores' own range spans at least; where it does, the legend says where they lie.
    """
    own_low, own_high = score_range(scores, span)
    note = span_note(scores, own_low, own_high) if low is None and high is None else ""
    low, high = own_low if low is None else low, own_high if high is None else high
    colours = patch_colours(patches, scores, low, high, colour_map)
    width = float(np.ptp(body.vertices[:, 0])) / body.height * HEIGHT
    figure = Figure(figsize=(2 * width + 1.6, HEIGHT + 0.9), dpi=150, facecolor="white")
    FigureCanvasAgg(figure)
    edges = {"top": 0.88, "bottom": 0.03, "right": 0.92}
    grid = figure.add_gridspec(1, 3, width_ratios=(1, 1, 0.03), wspace=0.02, **edges)
    for column, (view, side) in enumerate((("Front", -1.0), ("Back", 1.0))):
        axes = figure.add_subplot(grid[column])
        _draw_side(axes, body, colours, side)
        axes.set_title(view, fontsize=9, color="0.4", y=-0.02)
    scale = ScalarMappable(Normalize(low, high), ListedColormap(colour_table(colour_map)))
    figure.colorbar(scale, cax=figure.add_subplot(grid[2]), label=f"{label} ({note})" if note else label)
    figure.text(0.03, 0.965, title, fontsize=14, weight="bold", va="top")
    figure.text(0.03, 0.92, subtitle, fontsize=9, color="0.4", va="top")
    with atomic_write(path) as stream:
        figure.savefig(stream, format=Path(path).suffix[1:].lower() or "png", metadata=_undated(path))


def _draw_side(axes: Axes, body: Body, colours: np.ndarray, side: float) -> None:
    """The faces that look along y towards `side`, the farthest first."""
    corners = body.vertices[body.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = side * normals[:, 1] / np.maximum(np.linalg.norm(normals, axis=1), np.finfo(float).tiny)
    seen = np.flatnonzero(facing > 0)
    seen = seen[np.argsort(side * corners[seen, :, 1].mean(axis=1), kind="stable")]
    shade = 1 - SHADE * (1 - facing[seen, None])
    face_colours = colours[body.faces[seen]].mean(axis=1) * shade
    across = corners[seen][:, :, 0] * -side  # seen from the front the wearer's left is on the right
    outline = np.stack([across, corners[seen][:, :, 2]], axis=-1)
    axes.add_collection(
        PolyCollection(outline, facecolors=face_colours, edgecolors=face_colours, linewidths=0.2)
    )
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.set_axis_off()


def _undated(path: str | Path) -> dict[str, None] | None:
    """No date in the file: the same scores give the same bytes."""
    return {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(Path(path).suffix[1:].lower())
