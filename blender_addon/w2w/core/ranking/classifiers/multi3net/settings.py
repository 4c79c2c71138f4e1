# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes, schedule and memory of `Multi3Net`; known without PyTorch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from ...inputs import BLOCK_BYTES

WARM_UP = 20
"""Steps in which the learning rate rises, where its fall is laid down beforehand."""


@dataclass(frozen=True)
class Settings:
    """How large a network is and how it is trained.

    Parameters
    ----------
    width, hidden, embedding : int
        Numbers a channel is embedded in, units of the layer after the attention, and
        numbers a window is described by; `width` and `embedding` are multiples of 8.
    spectrum : int
        Frequencies, from the lowest, whose amplitude in a window is embedded beside its
        samples, its mean and its deviation; 0 for the samples alone.
    rate : float
        Learning rate: the highest, or that to begin with where some windows say when to stop.
    batch : int
        Windows a step.
    epochs : int
        All of them, or the most where some windows say when to stop.
    decay : float
        Share, times the learning rate, by which a step shrinks the weights (AdamW;
        Loshchilov and Hutter 2019).
    smoothing : float
        Share of a window's label that is spread over all activities.
    mixing : float
        Both parameters of the beta distribution by which windows and their labels are
        blended in pairs (mixup; Zhang et al. 2018); 0 for no blending.
    stopping : bool
        Whether the windows of the next fold say when to stop and when the learning rate drops.
        If not, they are learnt from, and the rate falls along half a cosine.
    patience : int
        Epochs without a better F1 after which a patch stops.
    plateau : int
        Epochs without a better F1 after which its learning rate drops.
    drop : float
        Factor of that drop.
    seed : int
        Every draw comes from it.
    group : int
        Patches trained together; changes nothing but memory and time.
    device : str
        "cuda" or "cpu"; empty for a GPU where there is one.
    block_bytes : int
        Windows held at a time; changes nothing but memory.
    checkpoints : Path or None
        Folder of its own to leave finished patches and the state of those in training in, and
        to take them up from; made if missing. What other inputs or settings left there is
        removed at the end.
    checkpoint_epochs : int
        Epochs from one saved state to the next.

    Raises
    ------
    ValueError
        If a size or share is not as it must be.
    """

    width: int = 32
    hidden: int = 96
    embedding: int = 32
    spectrum: int = 25
    rate: float = 4e-3
    batch: int = 64
    epochs: int = 80
    decay: float = 0.1
    smoothing: float = 0.1
    mixing: float = 0.3
    stopping: bool = False
    patience: int = 15
    plateau: int = 8
    drop: float = 0.5
    seed: int = 0
    group: int = 32
    device: str = ""
    block_bytes: int = BLOCK_BYTES
    checkpoints: Path | None = None
    checkpoint_epochs: int = 20

    def __post_init__(self) -> None:
        for name in ("width", "embedding"):
            size = getattr(self, name)
            if size < 8 or size % 8:
                raise ValueError(f"{name} must be a multiple of 8, one part for each head, not {size}")
        for name in ("hidden", "batch", "epochs", "patience", "plateau", "group", "checkpoint_epochs"):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)}")
        for name in ("spectrum", "decay", "smoothing", "mixing"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must be at least 0, not {getattr(self, name)}")

    def pace(self, step: int, steps: int) -> float:
        """Share of the learning rate at one of all steps: a half cosine where nothing else lowers it."""
        if self.stopping:
            return 1.0
        return min(1.0, step / WARM_UP) * 0.5 * (1 + math.cos(math.pi * step / steps))
