# SPDX-License-Identifier: GPL-3.0-or-later
"""The IMU branch of Multi3Net at every patch, all patches trained together; needs PyTorch."""

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from w2w.core.windows.inputs import PatchBlocks, as_blocks, spans

from .settings import Settings

HOW_TO_GET_TORCH = "the classifier multi3net needs PyTorch: get it with `pip install torch==2.13.0`"


@dataclass(frozen=True)
class Multi3Net(Settings):
    """A network a patch after the IMU branch of Multi3Net (Fortes Rey et al., ISWC 2024).

    Theirs: each channel of a window embedded by a linear layer, sinusoidal positional
    encoding (dropout .3), self-attention of 8 heads among the channels (dropout .1), layer
    norm, flattened to linear layers that describe a window by one vector; a head of a
    convolution of width 3, layer norm, attention of 8 heads and linear layers; Adam at
    1e-3, learning rate reduced on plateaus, early stopping.

    Not theirs: their pretraining against text and poses is left out, and each patch learns
    from nothing. Their published code does not run as it stands; where it leaves a choice,
    this is ours: residual connections around both attentions, ReLU between linear layers,
    no reshape to three vectors and average of these (a linear layer alone can do the same),
    the head's convolution along the vector in 8 segments, and losses that count all activities
    the same. `Multi3Net.full()` has their sizes and schedule. The default is smaller, so that
    512 patches are mapped in the time that `docs/utility.md` states, and is made for a few
    clips an activity: its embedding reads a window's spectrum and its samples, windows are
    mixed in pairs (mixup), and none is set aside for validation.

    With early stopping, the validation split is the next fold, never the tested one; windows of
    an activity that no other fold holds are trained on instead. All
    patches of a fold start from the same weights and meet the same batches, mixup and dropout:
    they differ by their signals alone, and a patch comes out alone as it does among others.

    Raises
    ------
    ValueError
        If a size or share is not as it must be.
    """

    name: ClassVar[str] = "multi3net"
    inputs: ClassVar[str] = "windows"

    @classmethod
    def full(cls, **changes: object) -> Self:
        """The published sizes and schedule: weeks, not minutes, for hundreds of patches."""
        published = {
            "width": 256, "hidden": 1536, "embedding": 256, "spectrum": 0, "learning_rate": 1e-3,
            "batch_size": 32, "epochs": 300, "weight_decay": 0.0, "label_smoothing": 0.0, "mixup": 0.0,
            "early_stopping": True, "patience": 30, "lr_patience": 10, "group": 4,
        }  # fmt: skip
        return cls(**(published | changes))

    @staticmethod
    def unavailable() -> str:
        """Why it cannot be used here, as a sentence, or ""."""
        return "" if importlib.util.find_spec("torch") else HOW_TO_GET_TORCH

    def predict_folds(
        self,
        windows: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Name every test window by the network of the folds it does not belong to, as `Ridge.predict_folds`.

        `windows` (W, N, samples, 6) are specific force (m/s2) and angular velocity (rad/s); they have 6 k
        channels where k sensors are worn together. A ValueError says how to get PyTorch where it is missing.
        """
        if problem := self.unavailable():
            raise ValueError(problem)
        from .group import Group, portions

        source = as_blocks(windows)
        if len(source.shape) != 4 or source.shape[3] % 6:
            raise ValueError(f"multi3net takes windows of shape (W, N, samples, 6), not {source.shape}")
        if self.checkpoints is not None:
            self.checkpoints.mkdir(parents=True, exist_ok=True)
        splits = {
            int(f): split_windows(labels, fold, f, self.early_stopping) for f in np.unique(fold[is_test])
        }
        size = max((self.largest_batch(len(train)) for train, _ in splits.values()), default=0)
        at_once, held = portions(self, source.shape)
        position = np.cumsum(is_test) - 1
        predictions = np.empty((int(is_test.sum()), source.shape[1]), dtype=np.int16)
        used = set()
        for span in spans(source, held):
            block = source.patches(span)
            for start in range(span.start, span.stop, at_once):
                stop = min(start + at_once, span.stop)
                group = np.ascontiguousarray(block[:, start - span.start : stop - span.start])
                for done, (f, (train, validation)) in enumerate(splits.items(), start=1):
                    test = np.flatnonzero(is_test & (fold == f))
                    work = Group(self, group, labels, train, validation, test, f, size)
                    predictions[position[test], start:stop] = work.predict()
                    used.add(work.file)
                    if progress is not None:
                        progress((start + (stop - start) * done / len(splits)) / source.shape[1])
        if self.checkpoints is not None:
            for stale in set(self.checkpoints.glob("*.npz")) - used:
                stale.unlink(missing_ok=True)
        return predictions


def split_windows(
    labels: np.ndarray, fold: np.ndarray, tested: int, early_stopping: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Indices of the training and of the validation windows outside the fold `tested`.

    With early stopping, the validation windows are those of the next fold; none where there are only two
    folds. Those of a class that is in no third fold are trained on, since it could not be named otherwise.
    """
    if not early_stopping:
        return np.flatnonzero(fold != tested), np.empty(0, dtype=np.int64)
    folds = np.unique(fold[fold >= 0])
    following = folds[(np.searchsorted(folds, tested) + 1) % len(folds)]
    elsewhere = np.unique(labels[(fold != tested) & (fold != following)])
    is_validation = (fold == following) & np.isin(labels, elsewhere)
    return np.flatnonzero((fold != tested) & ~is_validation), np.flatnonzero(is_validation)
