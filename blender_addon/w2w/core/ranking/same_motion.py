# SPDX-License-Identifier: GPL-3.0-or-later
"""Find clips that show one and the same motion, so that none is tested on its own copy."""

import hashlib
from collections.abc import Sequence

import numpy as np

from ..motion.same_speeds import same_speeds
from ..motion.shared_stretches import shared_stretches
from ..motion.signature import WIDTH


def same_motion_groups(
    clips: Sequence[str], keys: Sequence[str] | None = None, signatures: Sequence[np.ndarray] | None = None
) -> np.ndarray:
    """Number the distinct motions among C clips, in order of appearance, shape (C,), int.

    Two clips are the same if their names or keys are equal or they share a stretch of one motion, mirrored or
    not. Sameness is transitive. An empty key or signature matches none.

    Parameters
    ----------
    signatures : sequence of ndarrays, length C, optional
        `motion_signature` of each clip.

    Raises
    ------
    ValueError
        If a signature is none of today's, as in folders of earlier versions.
    """
    joined = _Joined(len(clips))
    joined.join_equal(list(clips))
    if keys is not None:
        joined.join_equal([key or None for key in keys])
    if signatures is not None:
        read = [(_digest(row), len(row) // WIDTH) for row in signatures]
        distinct = joined.join_equal([digest for digest, _ in read])
        frames = np.array([frames for _, frames in read])[distinct]
        for alike in (shared_stretches, same_speeds):
            for first, second in alike(signatures, distinct, frames, joined.are_one):
                joined.join(first, second)
    roots = [joined.root(clip) for clip in range(len(clips))]
    _, appearance, number = np.unique(roots, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(appearance))[number]


def _digest(signature: np.ndarray) -> bytes | None:
    """A hash of a signature, None of an empty one; a ValueError refuses one of an earlier version."""
    if len(signature) % WIDTH:
        raise ValueError("an earlier version of W2W made the signals of these clips: make them again")
    return hashlib.blake2b(signature.tobytes()).digest() if len(signature) else None


class _Joined:
    """Clips that are one motion (union-find)."""

    def __init__(self, clips: int) -> None:
        self._parent = list(range(clips))

    def root(self, clip: int) -> int:
        """The clip that stands for all that are one with this."""
        while self._parent[clip] != clip:
            self._parent[clip] = self._parent[self._parent[clip]]
            clip = self._parent[clip]
        return clip

    def are_one(self, first: int, second: int) -> bool:
        """Whether two clips are one motion."""
        return self.root(first) == self.root(second)

    def join(self, first: int, second: int) -> None:
        """Make two clips one motion."""
        self._parent[self.root(second)] = self.root(first)

    def join_equal(self, values: list) -> np.ndarray:
        """Join clips of equal values other than None; return the first clip of each value."""
        first: dict = {}
        for clip, value in enumerate(values):
            if value is not None:
                self.join(first.setdefault(value, clip), clip)
        return np.array(list(first.values()), dtype=np.int64)
