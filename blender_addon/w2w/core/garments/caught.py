# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth that has caught on the body: it is stretched as no fabric is, and its sensors ride on nonsense."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

CAUGHT = 2.0
"""Times its own length beyond which an edge of a cloth has caught."""

HAS_CAUGHT = "cloth caught on the body"
"""How the sentence about it begins."""


class RestLengths:
    """Knows how long the edges of a cloth are at rest.

    Parameters
    ----------
    vertices : ndarray, shape (V, 3)
        At rest.
    edges : ndarray of int, shape (E, 2)
    """

    def __init__(self, vertices: np.ndarray, edges: np.ndarray) -> None:
        lengths = _lengths(vertices, edges)
        self.edges, self.lengths = edges[lengths > 0], lengths[lengths > 0]

    def caught(self, vertices: np.ndarray) -> bool:
        """Whether any edge is too long with the vertices there; one that is not there (NaN) is not."""
        return bool((_lengths(vertices, self.edges) > CAUGHT * self.lengths).any())


def caught_sentence(frames: Mapping[str, int], of: int) -> str:
    """What caught in how many of a clip's frames; empty where nothing did."""
    found = [f"{name} in {count}" for name, count in frames.items() if count]
    if not found:
        return ""
    return (
        f"{HAS_CAUGHT}, stretched to more than {CAUGHT:g} times its length: {', '.join(found)} of {of} frames"
    )


def _lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
