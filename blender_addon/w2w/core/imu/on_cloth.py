# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that sit on cloth, and cloth that has caught on the body: its sensors feel nonsense."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from ..wording import NAMED, count
from .recording import ImuRecording
from .synthesis import Synthesis, synthesize

CAUGHT = 2.0
"""An edge of a cloth has caught when it is longer than this many times its rest length."""

HAS_CAUGHT = "cloth caught on the body"
"""How the sentence about it begins."""


@dataclass(frozen=True, eq=False)
class ClothSensors:
    """Poses of the sensors on cloth during a clip.

    Parameters
    ----------
    patches : ndarray of int, shape (K,)
        Patches whose sensors sit on cloth.
    matrices : ndarray, shape (T, K, 4, 4), float64
        World matrices of those sensors, metres, without scale.
    rate : float
        Frames per second; need not be the clip's.
    caught : mapping of str to int
        Frames in which each piece of cloth, by its name, had caught on the body; empty if not counted.
    """

    patches: np.ndarray
    matrices: np.ndarray
    rate: float
    caught: Mapping[str, int] = field(default_factory=dict)

    def carried(self, there: np.ndarray, here: np.ndarray) -> Self:
        """The sensors on a body in another pose: each keeps its place relative to its patch.

        `there` and `here` (T, K, 4, 4) are world matrices of the patches on the skin, in the simulated
        pose and in the wanted one.
        """
        return replace(self, matrices=here @ np.linalg.inv(there) @ self.matrices)

    def over(self, skin: ImuRecording, settings: Synthesis) -> ImuRecording:
        """The ideal recording of the skin with the signals of the sensors on cloth in place of the skin's.

        Raises `ValueError` if the cloth's frames end before the recording does.
        """
        if not len(self.patches):
            return skin
        cloth = synthesize(self.matrices, self.rate, settings)
        if cloth.n_samples < skin.n_samples:
            raise ValueError(
                f"the cloth was followed for {cloth.n_samples} samples of {skin.n_samples}: "
                "its frames end before the clip does"
            )
        acc, gyr = skin.acc.copy(), skin.gyr.copy()
        acc[:, self.patches] = cloth.acc[: skin.n_samples]
        gyr[:, self.patches] = cloth.gyr[: skin.n_samples]
        return replace(skin, acc=acc, gyr=gyr)

    def facts(self) -> dict[str, Any]:
        """What caught, for a clip's record; {} if nothing did."""
        caught = {name: count for name, count in self.caught.items() if count}
        return {"cloth_caught": caught, "cloth_frames": len(self.matrices)} if caught else {}


class RestLengths:
    """Rest lengths of the edges (E, 2) of a cloth, from its vertices (V, 3) at rest."""

    def __init__(self, vertices: np.ndarray, edges: np.ndarray) -> None:
        lengths = _lengths(vertices, edges)
        self.edges, self.lengths = edges[lengths > 0], lengths[lengths > 0]

    def caught(self, vertices: np.ndarray) -> bool:
        """Whether any edge is too long; an edge of a vertex that a modifier removed (NaN) never is."""
        return bool((_lengths(vertices, self.edges) > CAUGHT * self.lengths).any())


def caught_sentence(frames: Mapping[str, int], of: int) -> str:
    """A sentence on the number of a clip's frames in which each piece of cloth caught; "" if none did."""
    parts = [f"{name} in {count}" for name, count in frames.items() if count]
    if not parts:
        return ""
    return (
        f"{HAS_CAUGHT}, stretched to more than {CAUGHT:g} times its length: {', '.join(parts)} of {of} frames"
    )


def caught_sentences(clips: Sequence[tuple[str, Mapping[str, Any]]]) -> list[str]:
    """A sentence for each of the first clips in which cloth caught, and one for the rest.

    Clips are names with their records.
    """
    caught = [(name, about) for name, about in clips if about.get("cloth_caught")]
    sentences = [
        f"In {name} {caught_sentence(about['cloth_caught'], about['cloth_frames'])}: do not trust what its "
        "sensors feel there"
        for name, about in caught[:NAMED]
    ]
    more = len(caught) - NAMED
    if more > 0:
        sentences.append(f"Cloth caught in {count('more clip', more)}: see cloth_caught in clips.jsonl")
    return sentences


def _lengths(vertices: np.ndarray, edges: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vertices[edges[:, 1]] - vertices[edges[:, 0]], axis=1)
