# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's body as a still picture, front and back: for print, mail and screen readers."""

import base64
import io
from typing import Any

import numpy as np
from PIL import Image

from ..core.body.body import Body
from ..core.colours import Scale
from ..core.motion.skinning import triangle_frames
from ..core.study.results import StudyResults
from ..drawing.body import BodyPictures, common_crop, size_for

PIXELS = 560
"""Height of the body."""

ARROW = 0.17
"""Length of the arrow along a sensor's x axis, metres; a disc hides the first third."""

COLOURS = 160
"""Palette size; makes the PNG three times smaller."""


def still_picture(study: StudyResults, body: Body, first: list[int], together: list[int]) -> dict[str, Any]:
    """Front and back, coloured by expected F1, and where numbered discs for two lists of patches belong."""
    utility, patches = study.utility, study.patches
    scale = Scale.of(utility.expected_mean)
    pictures = BodyPictures(body, size_for(body, PIXELS))
    views = pictures.coloured(scale.colours(patches, utility.expected_mean))
    top, bottom, left, right = common_crop(views)
    both = np.concatenate([view[top:bottom, left:right] for view in views], axis=1)
    stream = io.BytesIO()
    Image.fromarray(both).quantize(COLOURS, Image.Quantize.FASTOCTREE).save(stream, "PNG", optimize=True)

    def marks(chosen: list[int]) -> list[tuple[float, ...]]:
        """Where each sensor is drawn, and the tip of its arrow: x, y, x, y."""
        places = patches.vertices[chosen]
        arrows = triangle_frames(body.vertices[patches.triangles[chosen]])[:, :3, 0]
        ends = [body.vertices[places], body.vertices[places] + ARROW * arrows]
        both = zip(*(pictures.locate(end, body.vertex_normals[places]) for end in ends), strict=True)
        return [
            tuple(round(n, 1) for view, x, y in pair for n in (view * (right - left) + x - left, y - top))
            for pair in both
        ]

    named = ", ".join(f"{number}: {patches.names[patch]}" for number, patch in enumerate(first, start=1))
    return {
        "picture": f"data:image/png;base64,{base64.b64encode(stream.getvalue()).decode('ascii')}",
        "width": both.shape[1],
        "height": both.shape[0],
        "low": scale.low,
        "high": scale.high,
        "first": marks(first),
        "first_named": named,
        "set": marks(together),
    }
