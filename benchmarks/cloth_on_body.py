# SPDX-License-Identifier: GPL-3.0-or-later
"""How often our garments catch on a moving body, and how deep they lie below its skin.

    python -m benchmarks.cloth_on_body tshirt|trousers [before] CLIP...

With `before`, as it was before arms were held clear of the trunk. Depth is measured in every tenth frame,
at all vertices of the cloth: how far those inside the body are from the nearest point of its skin. Where
two parts of the body overlap no cloth can lie between them: that share stands by itself.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import bpy
import numpy as np
from mathutils import Vector
from mathutils.bvhtree import BVHTree

from w2w.core.body.body import Body
from w2w.core.garments.cover import cover
from w2w.core.garments.cut import cut
from w2w.core.garments.on_cloth import CAUGHT, RestLengths
from w2w.core.garments.run_up import with_run_up
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import sample_patches
from w2w.scene.base.body import add_body
from w2w.scene.base.output import quiet_output
from w2w.scene.base.playback import EvaluatedVertices
from w2w.scene.garments.clear import SIDES, outward, times_inside
from w2w.scene.garments.cloth import dress
from w2w.scene.garments.follow import Worn, follow
from w2w.scene.motion.load import carry, read_motion

EVERY = 10
"""Frames from one in which depth is measured to the next."""


@dataclass
class Found:
    """What cloth did in one clip: edges caught by frame, and of the frames looked into depth and overlap."""

    turned: str
    caught: np.ndarray
    depth: np.ndarray
    overlap: np.ndarray


def through(kind: str, body: Body, clip: Path) -> Found:
    """A garment through a clip."""
    with quiet_output():
        motion = carry(read_motion(clip), body).motion
    turned = ", ".join(f"{outward(body, motion, side):.0f}" for side in SIDES)
    garment = cut(kind, body).cloth
    lengths = RestLengths(garment.vertices, _edges(garment.faces))
    faces = body.faces.tolist()
    caught, depths, overlaps = [], [], []
    for number, (skin, points) in enumerate(_frames(kind, body, motion)):
        ends = points[lengths.edges]
        stretch = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) / lengths.lengths
        caught.append((stretch > CAUGHT).sum())
        if number % EVERY == 0:
            tree = BVHTree.FromPolygons(skin.tolist(), faces)
            turns = np.array([times_inside(tree, Vector(point)) for point in points.tolist()])
            depths.append(_depth(tree, points, turns))
            overlaps.append(turns > 1)
    return Found(turned, np.array(caught), np.concatenate(depths), np.concatenate(overlaps))


def _frames(kind: str, body: Body, motion: Motion) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Skin and cloth in each frame of a clip, metres, after the run-up."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    mesh = add_body(body).mesh
    item = dress(mesh, kind)
    garment = cut(kind, body).cloth
    patches = sample_patches(body, 16)
    moved, before = with_run_up(motion)
    readers = [EvaluatedVertices(one, np.array([0])) for one in (mesh, item)]
    worn = Worn(mesh, [item], [cover(garment.vertices, garment.faces, body, patches)])
    frames = follow(worn, motion, patches)
    for share in frames:
        if round(share * moved.n_frames) > before:
            yield tuple(reader.everywhere() for reader in readers)


def _depth(tree: BVHTree, points: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """How deep each point is below the skin, metres; nothing where it is outside or parts overlap."""
    depth = np.zeros(len(points))
    for index in np.flatnonzero(turns == 1):
        depth[index] = tree.find_nearest(Vector(points[index].tolist()))[3]
    return depth


def _edges(faces: np.ndarray) -> np.ndarray:
    sides = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    return np.unique(np.sort(sides, axis=1), axis=0)


def show(title: str, found: list[Found]) -> None:
    """Print what was found in some clips."""
    caught = np.concatenate([one.caught for one in found])
    depth = 1000 * np.concatenate([one.depth for one in found])
    shares = [100 * (depth > least).mean() for least in (5, 10)]
    overlap = 100 * np.concatenate([one.overlap for one in found]).mean()
    turned = found[0].turned if len(found) == 1 else ""
    print(
        f"{title:44}{turned:>7}{(caught > 0).sum():5} of {len(caught):5}{caught.mean():7.1f}{caught.max():5}"
        f"{shares[0]:8.2f}{shares[1]:8.2f}{depth.max():6.0f}{overlap:8.2f}"
    )


def main() -> None:
    """Print a line a clip, and one of all."""
    kind, *clips = sys.argv[1:]
    if before := clips[0] == "before":
        clips = clips[1:]
    body, found = Body.bundled(), []
    print(f"{'':44}   arms   caught in   edges most  >5 mm  >10 mm    mm  overlap (% of vertices)")
    with ExitStack() as stack:
        if before:
            stack.enter_context(
                mock.patch("w2w.scene.garments.follow.with_clear_arms", lambda _, motion: motion)
            )
        for clip in clips:
            found.append(through(kind, body, Path(clip)))
            show(Path(clip).stem, found[-1:])
    show(f"all {len(clips)}", found)


if __name__ == "__main__":
    main()
