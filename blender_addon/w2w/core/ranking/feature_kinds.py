# SPDX-License-Identifier: GPL-3.0-or-later
"""Which features describe a window: statistics and spectra, MiniRocket's kernels, or both."""

from __future__ import annotations

import numpy as np

from ..threads import unthreaded_products
from .features import window_features
from .kernels import kernel_features

SUMMARY = "summary"
MINIROCKET = "minirocket"
FEATURES = (SUMMARY, MINIROCKET, "both")
"""What can be asked for; the first is the default."""


def check_features(kind: str) -> None:
    """Refuse a word that is none of FEATURES.

    Raises
    ------
    ValueError
        The message names it.
    """
    if kind not in FEATURES:
        raise ValueError(f"no features are called {kind!r}; there are {', '.join(FEATURES)}")


def features_of(windows: np.ndarray, rate: float, kind: str = SUMMARY, seed: int = 0) -> np.ndarray:
    """Describe each window of each sensor by numbers, the same whatever threads there are.

    Parameters
    ----------
    windows, rate
        As for `window_features`.
    kind : str
        One of FEATURES.
    seed : int
        As for `kernel_features`.

    Returns
    -------
    ndarray, shape (W, N, D), float32
    """
    check_features(kind)
    with unthreaded_products():
        if kind == SUMMARY:
            return window_features(windows, rate)
        if kind == MINIROCKET:
            return kernel_features(windows, seed)
        return np.concatenate([window_features(windows, rate), kernel_features(windows, seed)], axis=2)
