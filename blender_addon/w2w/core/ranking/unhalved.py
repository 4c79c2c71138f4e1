# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities of too few clips to be halved: what noise they add.

Two or three clips of an activity count in the mean as forty of another do, but no halves tell how far their
map repeats. Halves of the others tell what noise a clip has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .pooling import centred

Pairs = Sequence[tuple[np.ndarray, np.ndarray]]
"""Maps (A, N) of the activities that can be halved, of the one half and the other."""


@dataclass(frozen=True, eq=False)
class Unhalved:
    """Activities that no halves show.

    Attributes
    ----------
    halved : float
        What all other activities count in the macro F1.
    rows : ndarray of bool, shape (A,)
        Which these are, of all activities.
    shares : ndarray, shape (R,)
        What each of these counts in it.
    clips : ndarray, shape (R,)
        How many there are of each.
    clips_of_halved : ndarray, shape (H,)
        And of each of the others.
    """

    halved: float
    rows: np.ndarray
    shares: np.ndarray
    clips: np.ndarray
    clips_of_halved: np.ndarray

    @classmethod
    def of(cls, weights: np.ndarray, both: np.ndarray, clips: np.ndarray) -> Unhalved:
        """From what each activity (A,) counts, which of them both halves show, and their clips."""
        rows = ~both & (weights > 0)
        shares = weights / weights.sum()
        return cls(float(shares[both].sum()), rows, shares[rows], clips[rows], clips[both])

    def noise_maps(self, pooled: Pairs, seed: int) -> np.ndarray:
        """A map of their noise for each pair, shape (pairs, N): that of others, drawn at random."""
        of_a_clip = self._noise_of_a_clip(pooled)
        rng = np.random.default_rng([seed, 4])
        drawn = rng.integers(of_a_clip.shape[1], size=(len(of_a_clip), len(self.shares)))
        sign = rng.choice([-1.0, 1.0], size=drawn.shape)
        chosen = of_a_clip[np.arange(len(of_a_clip))[:, None], drawn]
        return np.einsum("r,pr,prn->pn", self.shares / np.sqrt(self.clips), sign, chosen)

    def variance_with(self, variance: float, raw: Pairs) -> float:
        """The variance of a patch's macro F1, theirs taken in."""
        if not len(self.shares):
            return variance
        apart = np.array([((a - b) ** 2).mean(axis=1) for a, b in raw]) / 2 * self.clips_of_halved / 2
        return float(self.halved**2 * variance + (self.shares**2 / self.clips).sum() * apart.mean())

    def _noise_of_a_clip(self, pooled: Pairs) -> np.ndarray:
        """What one clip's map would be off by, shape (pairs, H, N), if noise fell with the clips."""
        apart = np.array([centred(a - b) for a, b in pooled]) / np.sqrt(2)
        return apart * np.sqrt(self.clips_of_halved / 2)[:, None]
