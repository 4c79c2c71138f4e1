# SPDX-License-Identifier: GPL-3.0-or-later
"""What a patch's neighbours and its mirror image say about it: maps pooled as far as they repeat."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from ..body.body import Body
from ..patches.patches import PatchSet
from ..patches.skin import SkinDistances

WIDTH_M = 0.25
"""Standard deviation of the kernel over the skin. A width learned from halves of as few clips as a
library has comes out at 5 to 12 cm, and maps pooled by it repeat less."""

MIRROR_M = 0.04
"""Width of the kernel that reads a map at mirror images, which lie between patches."""

UNLEARNED = (0.8, 0.05)
"""Shares of the symmetric and the one-sided part where a library cannot be halved: about what those give
that can."""


@dataclass(frozen=True, eq=False)
class Pooling:
    """Smoothing over the skin, and over left and right.

    Parameters
    ----------
    kernel : ndarray, shape (N, N)
        Each row the weights of a mean over a patch's neighbours.
    mirror : ndarray, shape (N, N)
        Reads a map at each patch's mirror image.
    """

    kernel: np.ndarray
    mirror: np.ndarray

    @classmethod
    def on(cls, body: Body, patches: PatchSet) -> Pooling:
        """Pooling over the skin of a body at rest."""
        return cls.over(SkinDistances.of(body, patches))

    @classmethod
    def over(cls, skin: SkinDistances) -> Pooling:
        """Pooling over skin whose distances are known."""
        return cls(_kernel(skin.between, WIDTH_M), _kernel(skin.to_mirror_image, MIRROR_M))

    @classmethod
    def none(cls, n_patches: int) -> Pooling:
        """No pooling, for patches of which nothing is known."""
        return cls(np.eye(n_patches), np.eye(n_patches))

    def parts(self, maps: np.ndarray) -> np.ndarray:
        """Smoothed parts of maps (A, N) about their means: the symmetric one, then the one-sided one.

        Returns
        -------
        ndarray, shape (2, A, N)
        """
        about = centred(maps)
        reflected = about @ self.mirror.T
        return np.stack([(about + reflected) / 2, (about - reflected) / 2]) @ self.kernel.T

    def learn(self, pairs: Sequence[tuple[np.ndarray, np.ndarray]], n_activities: int) -> np.ndarray:
        """How much of each part of a map other clips show again.

        Least squares from the map of one half of the clips to that of the other, both ways and over
        all activities, by shares that are not negative: a stacked regression (Breiman 1996,
        doi:10.1007/BF00117832), which shrinks what does not repeat, as empirical Bayes would.
        How one-sided an activity is it says for itself, half and half with what all say.

        Parameters
        ----------
        pairs : sequence of two ndarrays, shape (A, N)
            Maps from disjoint halves of the clips; none where they cannot be halved.
        n_activities : int

        Returns
        -------
        ndarray, shape (2, A)
        """
        if not pairs:
            return np.tile(np.array(UNLEARNED)[:, None], (1, n_activities))
        ways = [(self.parts(a), centred(b)) for a, b in _both_ways(pairs)]
        seen = np.concatenate([parts.reshape(len(parts), -1) for parts, _ in ways], axis=1)
        wanted = np.concatenate([other.ravel() for _, other in ways])
        shares = np.tile(nnls(seen.T, wanted)[0][:, None], (1, n_activities))
        for activity in range(n_activities):
            seen = np.concatenate([parts[1:, activity] for parts, _ in ways], axis=1)
            wanted = np.concatenate([other[activity] for _, other in ways])
            shares[1, activity] = (shares[1, activity] + nnls(seen.T, wanted)[0][0]) / 2
        return shares

    def apply(self, maps: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """Maps (A, N) as other clips would show them, by the shares `learn` gave."""
        return maps.mean(axis=1, keepdims=True) + np.einsum("pan,pa->an", self.parts(maps), shares)


def centred(values: np.ndarray) -> np.ndarray:
    """Values (..., N) about their mean over patches."""
    return values - values.mean(axis=-1, keepdims=True)


def _both_ways(
    pairs: Sequence[tuple[np.ndarray, np.ndarray]],
) -> list[tuple[np.ndarray, np.ndarray]]:
    return [way for a, b in pairs for way in ((a, b), (b, a))]


def _kernel(distance: np.ndarray, width: float) -> np.ndarray:
    weights = np.exp(-0.5 * (distance / width) ** 2)
    return weights / weights.sum(axis=1, keepdims=True)
