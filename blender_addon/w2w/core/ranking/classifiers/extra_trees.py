# SPDX-License-Identifier: GPL-3.0-or-later
"""Extremely randomised trees, patch by patch: scikit-learn's strong baseline, for reference."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..inputs import BLOCK_BYTES, PatchBlocks
from .estimator import EstimatorClassifier


@dataclass(frozen=True)
class ExtraTrees:
    """One forest a patch and fold (Geurts, Ernst and Wehenkel 2006, doi:10.1007/s10994-006-6226-1).

    Nothing is shared between patches, so it is slow: use it to check `Ridge`, not to map.

    Parameters
    ----------
    trees : int
        Trees in a forest; the rest is as scikit-learn sets it.
    seed : int
        Decides every draw; all patches and folds have the same.
    workers : int or None
        Threads; None for as many as the process may use.
    block_bytes : int
        Features held at a time; changes nothing but memory.
    """

    trees: int = 100
    seed: int = 0
    workers: int | None = None
    block_bytes: int = BLOCK_BYTES

    name: ClassVar[str] = "trees"
    inputs: ClassVar[str] = "features"

    def predict_folds(
        self,
        features: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Name every test window by the forest of the folds it does not belong to.

        Parameters and what is returned are those of `Ridge.predict_folds`.
        """
        from sklearn.ensemble import ExtraTreesClassifier

        forest = ExtraTreesClassifier(self.trees, random_state=self.seed)
        each = EstimatorClassifier(forest, workers=self.workers, block_bytes=self.block_bytes)
        return each.predict_folds(features, labels, fold, is_test, progress)
