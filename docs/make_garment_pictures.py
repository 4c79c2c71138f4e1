# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of docs/garments.md: the garments as they are cut, and draped in the middle of a clip.

python docs/make_garment_pictures.py CLIP [SECOND [NAME]]
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy
import matplotlib.pyplot as plt
import numpy as np

from w2w.core.body.body import Body
from w2w.core.garments.cover import cover, without_overlap
from w2w.core.garments.cut import KINDS, cut
from w2w.core.garments.run_up import with_run_up
from w2w.core.patches.patches import sample_patches
from w2w.drawing.body import BodyPictures
from w2w.scene.base.body import add_body
from w2w.scene.base.output import quiet_output
from w2w.scene.base.playback import EvaluatedVertices
from w2w.scene.garments.cloth import dress
from w2w.scene.garments.follow import DressedBody, follow
from w2w.scene.motion.load import read_motion, to_body

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


def draped(body: Body, clip: Path, second: float) -> tuple[Body, dict[str, Body]]:
    """Body and garments so many seconds into a clip."""
    with quiet_output():
        motion = to_body(read_motion(clip), body).motion
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    objects = add_body(body)
    items = {kind: dress(objects.mesh, kind) for kind in KINDS}
    patches = sample_patches(body, 16)
    cloths = {kind: cut(kind, body).cloth for kind in KINDS}
    covers = without_overlap([cover(c.vertices, c.faces, body, patches) for c in cloths.values()])
    moved, before = with_run_up(motion)
    wanted = (before + second * moved.rate) / moved.n_frames
    frames = follow(DressedBody(objects.mesh, list(items.values()), covers), motion, patches)
    while next(frames) < wanted:
        pass
    shown = {"": (objects.mesh, body)} | {kind: (items[kind], cloths[kind]) for kind in KINDS}
    found = {}
    for kind, (item, mesh) in shown.items():
        points = EvaluatedVertices(item, np.arange(len(mesh.vertices))).positions()
        found[kind] = Body(points, mesh.faces, mesh.joints, mesh.weights)
    frames.close()
    return found.pop(""), found


def _on_white(picture: np.ndarray) -> np.ndarray:
    alpha = picture[..., 3:] / 255
    return np.clip(picture[..., :3] / 255 * alpha + 1 - alpha, 0, 1)


def main() -> None:
    """Draw both."""
    PICTURES.mkdir(exist_ok=True)
    body = Body.bundled()
    draw(PICTURES / "garments_cut.png", body, {kind: cut(kind, body).cloth for kind in KINDS})
    if len(sys.argv) > 1:
        second = float(sys.argv[2]) if len(sys.argv) > 2 else 0.5
        name = sys.argv[3] if len(sys.argv) > 3 else "garments_draped"
        draw(PICTURES / f"{name}.png", *draped(body, Path(sys.argv[1]), second))


if __name__ == "__main__":
    main()
