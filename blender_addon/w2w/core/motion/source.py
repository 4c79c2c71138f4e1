# SPDX-License-Identifier: GPL-3.0-or-later
"""What a motion file holds, before retargeting: a named skeleton's rest pose and its frames."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class SourceMotion:
    """A named skeleton and its motion, in world space.

    Parameters
    ----------
    bones : tuple of str, length B
        Names as the file has them.
    parents : ndarray of int, shape (B,)
        Parent of each bone, -1 for a root; parents come before their children.
    rest : ndarray, shape (B, 4, 4)
        World matrix of each bone in the rest pose: z up, in the file's own unit of length.
    matrices : ndarray, shape (T, B, 4, 4)
        World matrix of each bone in each frame, same axes and unit.
    rate : float
        Frames per second.
    take : str
        Name of the take (action) the frames come from.
    people : int
        Whole skeletons in the file, of which this is one.
    first_bone : int
        Number of the first true bone: 1 where the armature that holds them comes before.
    """

    bones: tuple[str, ...]
    parents: np.ndarray
    rest: np.ndarray
    matrices: np.ndarray
    rate: float
    take: str = ""
    people: int = 1
    first_bone: int = 0

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.matrices)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.n_frames - 1) / self.rate


def people_in(parents: np.ndarray) -> int:
    """Trees of bones that are no mere helpers: half as large as the largest.

    Parameters
    ----------
    parents : ndarray of int, shape (B,)
        -1 for a root; parents come before their children.
    """
    tree = np.arange(len(parents))
    for bone, parent in enumerate(parents):
        if parent >= 0:
            tree[bone] = tree[parent]
    sizes = np.bincount(tree, minlength=1)
    return max(1, int(np.count_nonzero((sizes > 0) & (2 * sizes >= sizes.max()))))


MOST_BONE_FRAMES = 2**24
"""Frames times bones that can be held: 2 GiB of matrices, over an hour of 65 bones at 60 frames/s."""


LOWEST_RATE, HIGHEST_RATE = 1.0, 2000.0
"""Frames per second of motions, from sparse key poses to the fastest motion capture."""

NOT_FINITE = "its animation holds values that no body has (NaN, infinite or beyond 1e10)"


class UnusableMotion(Exception):  # noqa: N818 - named for what it says, it is shown to people
    """A motion file that cannot be used; the message says why, in a sentence for people."""


def refuse_too_long(n_frames: int, n_bones: int) -> None:
    """Refuse a motion that would not fit in memory, before it is read.

    Raises
    ------
    UnusableMotion
        If it has more than MOST_BONE_FRAMES.
    """
    if n_frames * n_bones > MOST_BONE_FRAMES:
        raise UnusableMotion(
            f"it is too long to be read at once ({n_frames} frames of {n_bones} bones): cut it into parts of "
            f"at most {MOST_BONE_FRAMES // n_bones} frames"
        )


def reason_of(error: Exception) -> str:
    """Why a file cannot be used, from what reading it raised: never empty; a fault of ours is said as one."""
    text = str(error).strip()
    if text and isinstance(error, (UnusableMotion, ValueError, OSError, MemoryError)):
        return text
    return f"W2W failed on it, please report this: {type(error).__name__}: {text}".rstrip(": ")


def refuse_rate(rate: float) -> None:
    """Refuse a frame rate that no motion has.

    Raises
    ------
    UnusableMotion
        If it is not from LOWEST_RATE to HIGHEST_RATE.
    """
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise UnusableMotion(
            f"it says {rate:,.4g} frames a second; motions have {LOWEST_RATE:g} to {HIGHEST_RATE:,.0f}: "
            "correct its frame rate"
        )


def unscaled_rotations(matrices: np.ndarray) -> np.ndarray:
    """Rotation part of 4x4 matrices that may also scale.

    Parameters
    ----------
    matrices : ndarray, shape (..., 4, 4)

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Gram-Schmidt on the columns: exact where the scale is uniform, as in FBX and BVH.
    """
    y = matrices[..., :3, 1]
    y = y / np.linalg.norm(y, axis=-1, keepdims=True)
    x = matrices[..., :3, 0]
    x = x - y * np.sum(x * y, axis=-1, keepdims=True)
    x = x / np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, y, np.cross(x, y)], axis=-1)
