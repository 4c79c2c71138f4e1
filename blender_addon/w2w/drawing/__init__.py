# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps on the body as pictures: no Blender, no window."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ..core.body.body import Body
from ..core.colours import COLOUR_MAP, LEAST_SPAN, patch_colours, score_range, span_note
from ..core.patches.patches import PatchSet
from .body import BodyPictures, size_for
from .heatmap import VIEW_PIXELS, Scale, heatmap_figure


def draw_heatmap(
    path: str | Path | None,
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
) -> Figure:
    """Draw scores of patches on the front and the back of a body.

    Parameters
    ----------
    path : str or Path or None
        The suffix decides the kind of file, as Matplotlib knows it; None writes none.
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
        A name in `colours.COLOUR_MAPS`.
    span : float
        F1 that the scores' own range spans at least; where it does, the legend says where they lie.

    Returns
    -------
    matplotlib.figure.Figure
    """
    own_low, own_high = score_range(scores, span)
    note = span_note(scores, own_low, own_high) if low is None and high is None else ""
    low, high = own_low if low is None else low, own_high if high is None else high
    colours = patch_colours(patches, scores, low, high, colour_map)
    views = BodyPictures(body, size_for(body, VIEW_PIXELS)).coloured(colours)
    return heatmap_figure(path, views, title, Scale(low, high, label, note, colour_map), subtitle)
