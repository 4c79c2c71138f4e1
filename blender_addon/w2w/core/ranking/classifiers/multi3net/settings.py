# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes, schedule and memory of `Multi3Net`; known without PyTorch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from ...inputs import BLOCK_BYTES

WARM_UP = 20
"""Steps of learning-rate warm-up, before the cosine decay."""


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
    learning_rate : float
        The highest of the schedule, or the initial one with early stopping.
    batch_size : int
    epochs : int
        Exactly, or at most with early stopping.
    weight_decay : float
        Decoupled from the gradient (AdamW; Loshchilov and Hutter 2019).
    label_smoothing : float
        Share of a window's label that is spread over all activities.
    mixup : float
        Both parameters of the beta distribution by which windows and their labels are
        blended in pairs (mixup; Zhang et al. 2018); 0 for no blending.
    early_stopping : bool
        Whether the windows of the next fold are a validation split for early stopping and for
        reducing the learning rate on plateaus. If not, they are trained on, and the learning rate
        follows a cosine decay.
    patience : int
        Epochs without a better validation F1 after which training of a patch stops.
    lr_patience : int
        Epochs without a better validation F1 after which its learning rate is reduced.
    lr_factor : float
        By which it is then multiplied.
    seed : int
        Of the initial weights, batches, mixup and dropout.
    group : int
        Patches trained together; changes nothing but memory and time.
    device : str
        "cuda" or "cpu"; empty for a GPU where there is one.
    block_bytes : int
        Windows held at a time; changes nothing but memory.
    checkpoints : Path or None
        Folder of its own for checkpoints, from which training resumes; made if missing.
        Checkpoints of other inputs or settings are removed at the end.
    checkpoint_epochs : int
        Epochs from one checkpoint to the next.

    Raises
    ------
    ValueError
        If a size or share is not as it must be.
    """

    width: int = 32
    hidden: int = 96
    embedding: int = 32
    spectrum: int = 25
    learning_rate: float = 4e-3
    batch_size: int = 64
    epochs: int = 80
    weight_decay: float = 0.1
    label_smoothing: float = 0.1
    mixup: float = 0.3
    early_stopping: bool = False
    patience: int = 15
    lr_patience: int = 8
    lr_factor: float = 0.5
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
        for name in (
            "hidden",
            "batch_size",
            "epochs",
            "patience",
            "lr_patience",
            "group",
            "checkpoint_epochs",
        ):
            if getattr(self, name) < 1:
                raise ValueError(f"{name} must be at least 1, not {getattr(self, name)}")
        for name in ("spectrum", "weight_decay", "label_smoothing", "mixup"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} must be at least 0, not {getattr(self, name)}")

    def schedule(self, step: int, steps: int) -> float:
        """Factor of the learning rate at a step: warm-up, then cosine decay; 1 with early stopping."""
        if self.early_stopping:
            return 1.0
        return min(1.0, step / WARM_UP) * 0.5 * (1 + math.cos(math.pi * step / steps))
