# SPDX-License-Identifier: GPL-3.0-or-later
"""Smoothing of regularly sampled paths whose samples are not all to be trusted alike."""

from __future__ import annotations

import numpy as np
from scipy.linalg import solveh_banded

OUTLIER_SIGMAS = 6.0
"""Residuals beyond this many robust standard deviations weigh nothing (Tukey's biweight)."""

ROBUST_ROUNDS = 3


def smooth(
    values: np.ndarray, weights: np.ndarray, rate: float, cutoff_hz: float, order: int = 3
) -> np.ndarray:
    """Penalised least squares along the first axis (T, ...), with a weight (T,) for each sample.

    Minimises sum w |s - y|^2 + (rate / 2 pi f0)^(2 k) sum |D^k s|^2 for differences of order k (Whittaker
    1923; Eilers 2003, doi:10.1021/ac034173t), with f0 = `cutoff_hz`. Where all weights are 1 the gain is 1 /
    (1 + (f / f0)^(2 k)). Values are finite, also where the weight is 0; at least k weights are positive.
    """
    n = len(values)
    order = min(order, n - 1)
    if order < 1:
        return values.copy()
    penalty = (rate / (2 * np.pi * cutoff_hz)) ** (2 * order)
    bands = penalty * _difference_bands(n, order)
    bands[0] += weights
    right = (weights[:, None] * values.reshape(n, -1)).astype(np.float64)
    return solveh_banded(bands, right, lower=True).reshape(values.shape)


def smooth_robustly(
    values: np.ndarray, weights: np.ndarray, rate: float, cutoff_hz: float, floor: float
) -> np.ndarray:
    """`smooth`, without regard for points (T, D) far off the path.

    No residual up to `floor`, in the unit of `values`, counts as far off.
    """
    path = smooth(values, weights, rate, cutoff_hz)
    trusted = weights
    for _ in range(ROBUST_ROUNDS):
        residual = np.linalg.norm(values - path, axis=1)
        spread = 1.4826 * np.median(residual[weights > 0])
        limit = max(OUTLIER_SIGMAS * spread, floor)
        renewed = weights * np.clip(1 - (residual / limit) ** 2, 0, 1) ** 2
        if (renewed > 0).sum() < 4 or np.allclose(renewed, trusted, atol=1e-3):
            break
        trusted = renewed
        path = smooth(values, trusted, rate, cutoff_hz)
    return path


def _difference_bands(n: int, order: int) -> np.ndarray:
    """Lower bands (order + 1, n) of D^T D for differences of an order over n samples."""
    stencil = np.array([1.0])
    for _ in range(order):
        stencil = np.convolve(stencil, [1, -1])
    bands = np.zeros((order + 1, n))
    for start in range(order + 1):
        for offset in range(order + 1 - start):
            bands[offset, start : n - order + start] += stencil[start] * stencil[start + offset]
    return bands
