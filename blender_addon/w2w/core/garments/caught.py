# SPDX-License-Identifier: GPL-3.0-or-later
"""Cloth that has caught on the body: it is stretched as no fabric is, and its sensors feel nonsense."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

CAUGHT = 2.0
"""An edge of a cloth has caught when it is longer than this many times its rest length."""

HAS_CAUGHT = "cloth caught on the body"
"""How the sentence about it begins."""

CLIPS_NAMED = 3
"""Clips with caught cloth that are named."""


class RestLengths:
    """Rest lengths of the edges (E, 2) of a cloth, from its vertices (V, 3) at rest."""

    def __init__(self, vertices: np.ndarray, edges: np.ndarray) -> None:
        lengths = _lengths(vertices, edges)
        self.edges, self.lengths = edges[lengths > 0], lengths[lengths > 0]

    def caught(self, vertices: np.ndarray) -> bool:
        """Whether any edge is too long; an edge of a vertex that a modifier removed (NaN) never is."""
        return bool((_lengths(vertices, self.edges) > CAUGHT * self.lengths).any())


def caught_sentence(frames: Mapping[str, int], of: int) -> str:
    """In how many of a clip's frames each garment caught; empty where none did."""
    found = [f"{name} in {count}" for name, count in frames.items() if count]
    if not found:
        return ""
    return (
        f"{HAS_CAUGHT}, stretched to more than {CAUGHT:g} times its length: {', '.join(found)} of {of} frames"
    )


def caught_content(frames: Mapping[str, int], of: int) -> dict[str, Any]:
    """The same for a clip's record."""
    found = {name: count for name, count in frames.items() if count}
    return {"cloth_caught": found, "cloth_frames": of} if found else {}


def caught_sentences(clips: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """A sentence for each of the first clips in which cloth caught, and one for the rest.

    Clips are names with what their records say.
    """
    found = [(name, about) for name, about in clips if about.get("cloth_caught")]
    sentences = [
        f"In {name} {caught_sentence(about['cloth_caught'], about['cloth_frames'])}: do not trust what its "
        "sensors feel there"
        for name, about in found[:CLIPS_NAMED]
    ]
    more = len(found) - CLIPS_NAMED
    if more > 0:
        others = f"{more} more clip{'s' * (more > 1)}"
        sentences.append(f"Cloth caught in {others}: see cloth_caught in summary.json")
    return sentences


def _lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
