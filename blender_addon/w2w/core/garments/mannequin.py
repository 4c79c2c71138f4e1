# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of a plain mannequin in a shirt and shorts: a body without a map that anyone can show."""

import numpy as np

from ..body.body import Body, midpoint
from .cut import in_part, sleeves, waist

SKIN, SHIRT, SHORTS = (0.84, 0.80, 0.765), (0.62, 0.68, 0.74), (0.30, 0.36, 0.43)
"""sRGB colours."""

LENGTH = 0.65
"""How far down the shorts reach, as a share of the thigh."""

SOFT = 0.03
"""Width of a hem, metres: about an edge of the mesh, or it would show the triangles."""


def mannequin_colours(body: Body) -> np.ndarray:
    """Colours (V, 3) of a body's vertices."""
    hip, knee = (midpoint(body.joints, name)[2] for name in ("hip", "knee"))
    height = body.vertices[:, 2]
    shirt = np.maximum(in_part(body, "torso"), _inside(sleeves(body)))
    below, above = waist(body) - height, height - (hip + LENGTH * (knee - hip))
    shorts = (in_part(body, "torso") | in_part(body, "leg")) * _inside(np.minimum(below, above))
    colours = np.tile(SKIN, (len(height), 1))
    for share, colour in ((shirt, SHIRT), (shorts, SHORTS)):
        colours += share[:, None] * (colour - colours)
    return colours


def _inside(depth: np.ndarray) -> np.ndarray:
    """How much cloth there is, 0 to 1, at a depth from its hem, metres."""
    return np.clip(0.5 + depth / SOFT, 0, 1)
