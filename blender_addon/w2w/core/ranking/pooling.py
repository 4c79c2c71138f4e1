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

WIDTHS_M = (0.12, 0.25)
"""Standard deviations of the kernels over the skin whose mixture is learned."""

MIRROR_M = 0.04
"""Width of the kernel that reads a map at mirror images, which lie between patches."""

UNLEARNED = (0.0, 0.8, 0.0, 0.05)
"""Shares where a library cannot be halved, each for symmetric then one-sided parts at `WIDTHS_M`:
about what the libraries that can be halved give at 25 cm."""


@dataclass(frozen=True, eq=False)
class Pooling:
    """Smoothing over the skin, and over left and right.

    Parameters
    ----------
    kernels : tuple of ndarray, shape (N, N)
        Each row the weights of a mean over a patch's neighbours.
    mirror : ndarray, shape (N, N)
        Reads a map at each patch's mirror image.
    """

    kernels: tuple[np.ndarray, ...]
    mirror: np.ndarray

    @classmethod
    def on(cls, body: Body, patches: PatchSet) -> Pooling:
        """Pooling over the skin of a body at rest."""
        return cls.over(SkinDistances.of(body, patches))

    @classmethod
    def over(cls, skin: SkinDistances) -> Pooling:
        """Pooling over skin whose distances are known."""
        kernels = tuple(_kernel(skin.between, width) for width in WIDTHS_M)
        return cls(kernels, _kernel(skin.to_mirror_image, MIRROR_M))

    @classmethod
    def none(cls, n_patches: int) -> Pooling:
        """No pooling, for patches of which nothing is known."""
        alone = np.eye(n_patches)
        return cls((alone,) * len(WIDTHS_M), alone)

    def parts(self, maps: np.ndarray) -> np.ndarray:
        """Smoothed parts of maps (A, N) about their means: symmetric by width, then one-sided by width.

        Returns
        -------
        ndarray, shape (parts, A, N)
        """
        about = centred(maps)
        reflected = about @ self.mirror.T
        halves = ((about + reflected) / 2, (about - reflected) / 2)
        return np.stack([half @ kernel.T for half in halves for kernel in self.kernels])

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
        ndarray, shape (parts, A)
        """
        if not pairs:
            return np.tile(np.array(UNLEARNED)[:, None], (1, n_activities))
        ways = [(self.parts(a), centred(b)) for a, b in _both_ways(pairs)]
        seen = np.concatenate([parts.reshape(len(parts), -1) for parts, _ in ways], axis=1)
        wanted = np.concatenate([other.ravel() for _, other in ways])
        shares = np.tile(nnls(seen.T, wanted)[0][:, None], (1, n_activities))
        one_sided = slice(len(self.kernels), None)
        for activity in range(n_activities):
            seen = np.concatenate([parts[one_sided, activity] for parts, _ in ways], axis=1)
            wanted = np.concatenate([other[activity] for _, other in ways])
            shares[one_sided, activity] = (shares[one_sided, activity] + nnls(seen.T, wanted)[0]) / 2
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
