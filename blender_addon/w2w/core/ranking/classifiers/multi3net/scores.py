# SPDX-License-Identifier: GPL-3.0-or-later
"""Predictions of the networks of `Multi3Net`, their loss and their validation score."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from .examples import Examples
from .network import Network

PREDICTED_AT_ONCE = 256
"""Windows named in one go."""
TIE_BREAK = 1e-4
"""Share of the loss in a score, too little to outweigh a window named rightly."""


def name_windows(network: Network, weights: Tensor, windows: Tensor) -> Tensor:
    """Classes (P, W) of windows (P, samples, channels, W)."""
    with torch.inference_mode():
        parts = windows.split(PREDICTED_AT_ONCE, dim=-1)
        return torch.cat([network.forward(weights, part).argmax(dim=1) for part in parts], dim=1)


def validation_score(network: Network, weights: Tensor, examples: Examples) -> Tensor:
    """Macro F1 of each patch on the validation windows, a lower loss deciding between equals; shape (Q,)."""
    labels = examples.labels[examples.validation]
    with torch.inference_mode():
        parts = [
            network.forward(weights, examples.windows[..., rows])
            for rows in examples.validation.split(PREDICTED_AT_ONCE)
        ]
        scores = torch.cat(parts, dim=-1)
        loss = mean_loss(scores, targets(labels, network.classes))
        return macro_f1(scores.argmax(dim=1), labels, network.classes) - TIE_BREAK * loss


def macro_f1(named: Tensor, labels: Tensor, classes: int) -> Tensor:
    """Mean F1 of the classes among `labels` (W,), for each row of `named` (Q, W)."""
    truth = functional.one_hot(labels, classes).float()
    said = functional.one_hot(named, classes).float()
    hits = (said * truth).sum(dim=1)
    f1 = 2 * hits / (said.sum(dim=1) + truth.sum(dim=0)).clamp(min=1)
    return f1[:, truth.any(dim=0)].mean(dim=1)


def targets(labels: Tensor, classes: int, label_smoothing: float = 0.0) -> Tensor:
    """Target distributions of windows, weighed so that all classes count the same.

    Parameters
    ----------
    labels : Tensor of int, shape (W,)
    classes : int
    label_smoothing : float
        Share that is spread over all classes (Szegedy et al. 2016).

    Returns
    -------
    Tensor, shape (classes, W)
        Each column sums to the weight of its window; the weights are 1 on average.
    """
    windows = torch.bincount(labels, minlength=classes)
    present = (windows > 0).sum()
    weight = len(labels) / (present * windows.clamp(min=1)).float()
    one_hot = functional.one_hot(labels, classes).float().T
    return (one_hot * (1 - label_smoothing) + label_smoothing / classes) * weight[labels]


def mean_loss(scores: Tensor, target: Tensor) -> Tensor:
    """Mean cross-entropy (P,) of scores (P, classes, B) with their targets (classes, B)."""
    return -(scores.log_softmax(dim=1) * target.to(scores)).sum(dim=1).mean(dim=1)
