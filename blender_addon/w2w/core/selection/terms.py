# SPDX-License-Identifier: GPL-3.0-or-later
"""Terms of a choice: patches that may and must be chosen, their cost, and how many."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Requirement = int | Sequence[int]
"""A patch that must be chosen, or several of which one must be."""


@dataclass(frozen=True, eq=False)
class Terms:
    """Terms of a choice among N patches, checked."""

    allowed: np.ndarray  # (N,), bool
    required: list[np.ndarray]  # of each of these patches' numbers one must be chosen
    cost: np.ndarray  # (N,), positive
    max_size: int

    @classmethod
    def checked(
        cls,
        n_patches: int,
        max_size: int | None = None,
        allowed: np.ndarray | None = None,
        required: Sequence[Requirement] = (),
        cost: np.ndarray | None = None,
    ) -> Terms:
        mask = open_mask(allowed, n_patches)
        price = np.ones(n_patches) if cost is None else np.asarray(cost, dtype=np.float64)
        if price.shape != (n_patches,) or not (np.isfinite(price) & (price > 0)).all():
            raise ValueError(f"cost must hold {n_patches} positive numbers, one a patch")
        options = []
        for wish in required:
            patches = np.atleast_1d(np.asarray(wish, dtype=np.int64))
            if not mask[patches].any():
                raise ValueError(
                    f"one of the patches {patches.tolist()} is required, but none of them is allowed"
                )
            options.append(patches[mask[patches]])
        limit = int(mask.sum()) if max_size is None else max_size
        if limit < max(1, len(options)):
            raise ValueError(f"max_size is {limit}, but {max(1, len(options))} patches are required")
        return cls(mask, options, price, limit)


def fewest(order: Sequence[int], required: Sequence[np.ndarray]) -> int:
    """Number of the first patches chosen that it takes to have one wherever one must be."""
    chosen = np.array(order)
    firsts = [np.flatnonzero(np.isin(chosen, options)) for options in required]
    return max((int(found[0]) + 1 for found in firsts if len(found)), default=1)


def open_mask(allowed: np.ndarray | None, n_patches: int) -> np.ndarray:
    """Mask (N,) of the patches that may be chosen, checked; all by default."""
    mask = np.ones(n_patches, bool) if allowed is None else np.asarray(allowed, dtype=bool)
    if mask.shape != (n_patches,):
        raise ValueError(f"allowed must have shape ({n_patches},), not {mask.shape}")
    if not mask.any():
        raise ValueError("no patch is allowed: the constraints leave nothing to choose from")
    return mask
