# SPDX-License-Identifier: GPL-3.0-or-later
"""Sizes, schedule and means of the networks of `Multi3Net`."""

import math
from dataclasses import dataclass
from pathlib import Path

from w2w.core.windows.inputs import BLOCK_BYTES

WARM_UP = 20
"""Steps of learning-rate warm-up, before the cosine decay."""


@dataclass(frozen=True)
class Settings:
    """Sizes, schedule and means of the networks; a ValueError says which is not as it must be."""

    width: int = 32  # numbers a channel is embedded in, a multiple of 8
    hidden: int = 96  # units of the layer after the attention
    embedding: int = 32  # numbers a window is described by, a multiple of 8
    spectrum: int = 25  # lowest frequencies whose amplitude is embedded, too; 0 for the samples alone
    learning_rate: float = 4e-3  # the highest of the schedule, or the initial one with early stopping
    batch_size: int = 64
    epochs: int = 80  # exactly, or at most with early stopping
    weight_decay: float = 0.1  # decoupled from the gradient (AdamW; Loshchilov and Hutter 2019)
    label_smoothing: float = 0.1  # share of a window's label that is spread over all activities
    mixup: float = 0.3  # both parameters of its beta distribution (Zhang et al. 2018); 0 for no blending
    early_stopping: bool = False  # with the next fold for validation; else it is trained on, and cosine decay
    patience: int = 15  # epochs without a better validation F1 after which training of a patch stops
    lr_patience: int = 8  # and those after which its learning rate is reduced
    lr_factor: float = 0.5  # by which it is then multiplied
    seed: int = 0  # of the initial weights, batches, mixup and dropout
    group: int = (
        0  # patches trained together; 0 for 32 on a CPU, as many as fit on a GPU; only memory and time
    )
    device: str = ""  # "cuda" or "cpu"; empty for a GPU where there is one
    replayed: bool = True  # on a GPU each step is one CUDA graph; else its operations are launched one by one
    compiled: bool = False  # on a GPU by torch.compile, too: half a minute at first for less time a step
    block_bytes: int = BLOCK_BYTES  # windows held at a time; changes nothing but memory
    checkpoints: Path | None = None  # a folder of its own, made if missing; those of other work are removed
    checkpoint_epochs: int = 20  # from one checkpoint to the next

    def __post_init__(self) -> None:
        for name in ("width", "embedding"):
            size = getattr(self, name)
            if size < 8 or size % 8:
                raise ValueError(f"{name} must be a multiple of 8, one part for each head, not {size}")
        counts = ("hidden", "batch_size", "epochs", "patience", "lr_patience", "checkpoint_epochs")
        shares = ("group", "spectrum", "weight_decay", "label_smoothing", "mixup")
        for name, least in (dict.fromkeys(counts, 1) | dict.fromkeys(shares, 0)).items():
            if getattr(self, name) < least:
                raise ValueError(f"{name} must be at least {least}, not {getattr(self, name)}")

    def batches(self, n_windows: int) -> int:
        """Batches that an epoch of so many windows is divided into."""
        return max(1, round(n_windows / self.batch_size))

    def largest_batch(self, n_windows: int) -> int:
        """Windows of the largest of them."""
        return -(-n_windows // self.batches(n_windows))

    def schedule(self, step: int, steps: int) -> float:
        """Factor of the learning rate at a step: warm-up, then cosine decay; 1 with early stopping."""
        if self.early_stopping:
            return 1.0
        return min(1.0, step / WARM_UP) * 0.5 * (1 + math.cos(math.pi * step / steps))
