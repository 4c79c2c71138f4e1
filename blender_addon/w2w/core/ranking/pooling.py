# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps pooled over a patch's neighbours and its mirror image, as far as they repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..body.body import Body
from ..patches.patches import PatchSet
from ..patches.strip_graph import SkinDistances

WIDTH_M = 0.05
"""Standard deviation of the kernel over the skin. Widths from 0 to 25 cm, and widths that halves of the clips
choose, deliver the same within noise on five libraries (docs/evidence/ranking.md)."""

MIRROR_M = 0.04
"""Width of the kernel that reads a map at mirror images, which lie between patches."""

LOST = 10.0
"""Widths from which weights, 2e-22 and less, are lost in rounding."""

UNLEARNED = 0.2
"""Share of the difference between sides that is kept if a library cannot be halved."""

LEAST = 0.05
"""Least share of it, so that the better of two equal sides is recommended, not one that rounding picks."""


@dataclass(frozen=True, eq=False)
class Pooling:
    """Smoothing over the skin, and over left and right."""

    kernel: np.ndarray  # (N, N): each row the weights of a mean over a patch's neighbours
    mirror: np.ndarray  # (N, N): reads a map at each patch's mirror image

    @classmethod
    def on(cls, body: Body | None, patches: PatchSet) -> Pooling:
        """Pooling over the skin of a body at rest; none without a body."""
        if body is None:
            return cls.none(len(patches))
        skin = SkinDistances.of(body, patches.vertices, LOST * max(WIDTH_M, MIRROR_M))
        return cls(_kernel(skin.between, WIDTH_M), _kernel(skin.to_mirror_image, MIRROR_M))

    @classmethod
    def none(cls, n_patches: int) -> Pooling:
        """No pooling, for patches that are on no known body."""
        return cls(np.eye(n_patches), np.eye(n_patches))

    def sides(self, maps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Smoothed maps (A, N) about their means: the mean of both sides, and how a side differs from it."""
        about = centred(maps)
        reflected = about @ self.mirror.T
        return (about + reflected) / 2 @ self.kernel.T, (about - reflected) / 2 @ self.kernel.T

    def side_share(self, pairs: Sequence[tuple[np.ndarray, np.ndarray]]) -> float:
        """Share of the difference between sides that repeats, from maps (A, N) of halves of the clips.

        Least squares through the origin from each half's one-sided part to the other half's map, over all
        activities, kept between `LEAST` and 1 (stacked regression, Breiman 1996, doi:10.1007/BF00117832).
        """
        together = square = 0.0
        for a, b in pairs:
            for here, there in ((a, b), (b, a)):
                one_sided = self.sides(here)[1]
                together += float((one_sided * centred(there)).sum())
                square += float((one_sided**2).sum())
        return min(max(together / square, LEAST), 1.0) if square > 0 else UNLEARNED

    def apply(self, maps: np.ndarray, side_share: float = UNLEARNED) -> np.ndarray:
        """Maps (A, N) averaged over the skin and over both sides, which keep a share of their difference."""
        both, one_sided = self.sides(maps)
        return maps.mean(axis=1, keepdims=True) + both + side_share * one_sided


def centred(values: np.ndarray) -> np.ndarray:
    """Values (..., N) about their mean over patches."""
    return values - values.mean(axis=-1, keepdims=True)


def _kernel(distance: np.ndarray, width: float) -> np.ndarray:
    weights = np.exp(-0.5 * (distance / width) ** 2)
    return weights / weights.sum(axis=1, keepdims=True)
