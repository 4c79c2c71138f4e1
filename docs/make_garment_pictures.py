# SPDX-License-Identifier: GPL-3.0-or-later
"""The picture of docs/garments.md: the garments as they are cut."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from w2w.core.body.body import Body
from w2w.core.garments.cut import KINDS, cut
from w2w.drawing.body import BodyPictures

PICTURES = Path(__file__).resolve().parent / "pictures"
SKIN, COLOURS = (0.85, 0.72, 0.62), {"tshirt": (0.35, 0.55, 0.75), "trousers": (0.35, 0.4, 0.5)}
VIEWS, SIZE = ("front", "left", "back"), 520


def draw(path: Path, body: Body, cloths: dict[str, Body]) -> None:
    """Body and garments in one mesh, from three sides."""
    meshes = [body, *cloths.values()]
    starts = np.cumsum([0, *(len(mesh.vertices) for mesh in meshes)])
    faces = [mesh.faces + start for mesh, start in zip(meshes, starts, strict=False)]
    whole = Body(
        np.concatenate([mesh.vertices for mesh in meshes]),
        np.concatenate(faces),
        body.joints,
        np.concatenate([mesh.weights for mesh in meshes]),
    )
    shades = [SKIN, *(COLOURS[kind] for kind in cloths)]
    counts = [len(mesh.vertices) for mesh in meshes]
    colours = np.repeat(np.array(shades), counts, axis=0)
    pictures = BodyPictures(whole, SIZE, VIEWS).coloured(colours)
    row = np.concatenate(pictures, axis=1)
    used = np.flatnonzero((row[..., 3] > 0).any(axis=1))
    plt.imsave(path, _on_white(row[used[0] : used[-1] + 1]))
    print(path)


def _on_white(picture: np.ndarray) -> np.ndarray:
    alpha = picture[..., 3:] / 255
    return np.clip(picture[..., :3] / 255 * alpha + 1 - alpha, 0, 1)


def main() -> None:
    """Draw the garments as they are cut."""
    body = Body.bundled()
    draw(PICTURES / "garments_cut.png", body, {kind: cut(kind, body).cloth for kind in KINDS})


if __name__ == "__main__":
    main()
