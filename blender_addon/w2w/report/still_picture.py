# SPDX-License-Identifier: GPL-3.0-or-later
"""The report's body as a still picture, front and back: for print, mail and screen readers."""

import base64
import io
from typing import Any

import numpy as np
from PIL import Image

from ..core.body.body import Body
from ..core.colours import Scale
from ..core.study.results import StudyResults
from ..drawing.body import BodyPictures, common_crop, size_for

PIXELS = 560
"""Height of the body."""

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

    def marks(chosen: list[int]) -> list[tuple[float, float, int]]:
        places = patches.vertices[chosen]
        located = pictures.locate(body.vertices[places], body.vertex_normals[places])
        return [
            (round(view * (right - left) + x - left, 1), round(y - top, 1), number)
            for number, (view, x, y) in enumerate(located, start=1)
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
