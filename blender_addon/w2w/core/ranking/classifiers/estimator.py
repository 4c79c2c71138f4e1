# SPDX-License-Identifier: GPL-3.0-or-later
"""Any scikit-learn estimator as a classifier of windows, patch by patch."""

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any, Literal, Protocol, runtime_checkable

import numpy as np

from ...threads import n_threads
from ...windows.inputs import BLOCK_BYTES, PatchBlocks, as_blocks, for_each_patch


@runtime_checkable
class Classifier(Protocol):
    """A classifier of windows, all patches at once, each by its own signals."""

    @property
    def name(self) -> str:
        """Name in the results."""

    @property
    def inputs(self) -> str:
        """Kind of inputs: "features" or "windows"."""

    def predict_folds(
        self,
        inputs: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Predict every test window (T,) at every patch, shape (T, N), by what the other folds taught."""


@dataclass(frozen=True)
class EstimatorClassifier:
    """The user's estimator, fitted anew for each patch and fold.

    Nothing is shared between patches, so a map takes as long as that many fits.

    Parameters
    ----------
    estimator : object
        With `fit(X, y)` and `predict(X)`, as scikit-learn's have them; copied by `sklearn.base.clone`
        where it knows `get_params`, else by `copy.deepcopy`. Give it a seed of its own.
    inputs : {"features", "windows"}
        What X is: features of windows, shape (windows, D), or the windows themselves, shape
        (windows, samples, 6), m/s2 and rad/s.
    name : str
        What the results call it.
    workers : int or None
        Threads; None for as many as the process may use.
    block_bytes : int
        Inputs held at a time; changes nothing but memory.

    Examples
    --------
    >>> from sklearn.naive_bayes import GaussianNB
    >>> EstimatorClassifier(GaussianNB()).name
    'GaussianNB'
    """

    estimator: Any
    inputs: Literal["features", "windows"] = "features"
    name: str = ""
    workers: int | None = None
    block_bytes: int = BLOCK_BYTES

    def __post_init__(self) -> None:
        if self.inputs not in ("features", "windows"):
            raise ValueError(f'inputs must be "features" or "windows", not {self.inputs!r}')
        if isinstance(self.estimator, type):
            raise ValueError(f"the estimator must be made first: {self.estimator.__name__}(...)")
        for method in ("fit", "predict"):
            if not callable(getattr(self.estimator, method, None)):
                raise ValueError(f"the estimator {self.estimator!r} has no method {method!r}")
        # the type is told by a tag since scikit-learn 1.6, by an attribute before; scikit-learn may be absent
        tags = getattr(self.estimator, "__sklearn_tags__", lambda: None)()
        if "regressor" in (
            getattr(tags, "estimator_type", ""),
            getattr(self.estimator, "_estimator_type", ""),
        ):
            raise ValueError(f"{self.estimator!r} is a regressor: activities need a classifier")
        if not self.name:
            object.__setattr__(self, "name", type(self.estimator).__name__)

    def predict_folds(
        self,
        inputs: np.ndarray | PatchBlocks,
        labels: np.ndarray,
        fold: np.ndarray,
        is_test: np.ndarray,
        progress: Callable[[float], None] | None = None,
    ) -> np.ndarray:
        """Predict every test window by an estimator fitted to the other folds, as `Ridge.predict_folds`."""
        source = as_blocks(inputs)
        folds = np.unique(fold[is_test])
        splits = [(np.flatnonzero(fold != f), np.flatnonzero(is_test & (fold == f))) for f in folds]
        position = np.cumsum(is_test) - 1
        predictions = np.empty((int(is_test.sum()), source.shape[1]), dtype=np.int16)

        if hasattr(self.estimator, "get_params"):
            from sklearn.base import clone as fresh
        else:
            fresh = deepcopy

        def predict(patch: int, inputs: np.ndarray) -> None:
            given = inputs[0]
            for train, test in splits:
                fitted = fresh(self.estimator)
                fitted.fit(given[train], labels[train])
                predictions[position[test], patch] = fitted.predict(given[test])

        for_each_patch(source, predict, self.workers or n_threads(), self.block_bytes, progress)
        return predictions


def own(classifier: Any) -> Classifier:
    """The user's own classifier; an estimator becomes one of its features."""
    if isinstance(classifier, type):
        raise ValueError(f"the classifier must be made first: {classifier.__name__}(...)")
    if isinstance(classifier, Classifier):
        return classifier
    if hasattr(classifier, "fit") and hasattr(classifier, "predict"):
        return EstimatorClassifier(classifier)
    raise ValueError(
        f"a classifier is a name such as 'ridge' or a scikit-learn estimator, not {classifier!r}"
    )
