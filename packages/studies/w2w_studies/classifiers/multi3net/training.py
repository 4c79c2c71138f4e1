# SPDX-License-Identifier: GPL-3.0-or-later
"""Train the networks of many patches together, each with a learning rate and early stopping of its own.

Their predictions, their loss and their validation score, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from .network import Examples, Network
from .settings import Settings
from .step import Replayed, Step, beside, draw_epoch, mean_loss

PREDICTED_AT_ONCE = 256
"""Windows named in one go."""
TIE_BREAK = 1e-4
"""Share of the loss in a score, too little to outweigh a window named rightly."""

OF_TRAINING = (
    "patches", "weights", "first_moment", "second_moment", "learning_rate", "score", "since", "waited",
)  # fmt: skip
OF_ALL = ("best", "epochs")
"""Fields of `State` about the patches still in training, and about all patches."""


@dataclass(eq=False)
class State:
    """All that training goes on from: Q of the group's P patches are still in training."""

    epoch: int  # epochs done
    step: int  # steps done
    patches: Tensor  # (Q,), int: indices among the P
    weights: Tensor  # (Q, n_weights)
    first_moment: Tensor  # (Q, n_weights): Adam's, of the gradient
    second_moment: Tensor
    learning_rate: Tensor  # (Q, 1)
    score: Tensor  # (Q,): the best validation score so far
    since: Tensor  # (Q,), int: epochs since then
    waited: Tensor  # (Q,), int: epochs since then or since the last reduction of the learning rate
    best: Tensor  # (P, n_weights): weights at the highest score
    epochs: Tensor  # (P,), int: epoch of the highest score

    @classmethod
    def start(cls, weights: Tensor, n_patches: int, learning_rate: float) -> State:
        """Untrained: the same `weights` (n_weights,) at every patch."""
        stacked = weights.repeat(n_patches, 1)
        device = weights.device
        return cls(
            epoch=0,
            step=0,
            patches=torch.arange(n_patches, device=device),
            weights=stacked,
            first_moment=torch.zeros_like(stacked),
            second_moment=torch.zeros_like(stacked),
            learning_rate=torch.full((n_patches, 1), learning_rate, dtype=weights.dtype, device=device),
            score=torch.full((n_patches,), -torch.inf, dtype=weights.dtype, device=device),
            since=torch.zeros(n_patches, dtype=torch.int64, device=device),
            waited=torch.zeros(n_patches, dtype=torch.int64, device=device),
            best=stacked.clone(),
            epochs=torch.zeros(n_patches, dtype=torch.int64, device=device),
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """The parameters as arrays, for a file."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: value.cpu().numpy() if isinstance(value, Tensor) else np.array(value)
            for name, value in values.items()
        }

    @classmethod
    def restore(
        cls, arrays: dict[str, np.ndarray], device: str, n_patches: int, n_weights: int
    ) -> State | None:
        """From what `arrays` gave; None if that is of other numbers of patches or weights."""
        fresh = cls.start(torch.zeros(n_weights), n_patches, 0.0).arrays()
        training = arrays["patches"]
        if (
            any(arrays[name].dtype != value.dtype for name, value in fresh.items())
            or any(arrays[name].shape[1:] != value.shape[1:] for name, value in fresh.items())
            or any(arrays[name].shape[:1] != fresh[name].shape[:1] for name in ("epoch", "step", *OF_ALL))
            or any(arrays[name].shape[:1] != training.shape[:1] for name in OF_TRAINING)
            or not set(training.tolist()) <= set(range(n_patches))
        ):
            return None
        counters = {name: int(arrays[name]) for name in ("epoch", "step")}
        tensors = {name: torch.as_tensor(arrays[name], device=device) for name in (*OF_ALL, *OF_TRAINING)}
        return cls(**tensors, **counters)

    def keep(self, going: Tensor) -> None:
        """Go on with some of the patches only."""
        for name in OF_TRAINING:
            setattr(self, name, getattr(self, name)[going])


def train(
    network: Network,
    examples: Examples,
    settings: Settings,
    generator: Callable[[int], torch.Generator],
    state: State | None = None,
    after_epoch: Callable[[State], None] | None = None,
    size: int = 0,
) -> State:
    """Train until every patch has stopped; `State.best` then holds the weights to use.

    All patches start from the same weights and meet the same order of windows and the same
    dropout, so that they differ by their signals alone, and each is trained as it would be
    alone. One that has stopped improving leaves the batch. Without a validation split, early stopping is by
    the training loss. `generator` gives the draws of an epoch, 1 and up; 0 is for the first weights. A GPU
    pads batches to `size` windows, or to the largest.
    """
    state = state or State.start(
        network.initial(generator(0)).to(examples.windows), examples.windows.shape[1], settings.learning_rate
    )
    target = targets(examples.labels[examples.train], network.classes, settings.label_smoothing)
    target = target.to(examples.windows)
    size = size or settings.largest_batch(len(examples.train))
    active = examples.of(state.patches)
    step = _step(network, active, target, state, settings)
    while len(state.patches) and state.epoch < settings.epochs:
        drawn = draw_epoch(
            network, settings, len(examples.train), state.step, generator(state.epoch + 1), target.dtype
        )
        losses = [step(one) for one in beside(drawn, active.windows, size)]
        state.step += len(losses)
        state.epoch += 1
        if not settings.early_stopping:
            state.best, state.epochs = state.weights, torch.full_like(state.epochs, state.epoch)
        else:
            score = -sum(losses)
            if len(examples.validation):
                score = validation_score(network, state.weights, active)
            if _judge(state, score, settings):
                active = examples.of(state.patches)
                step = _step(network, active, target, state, settings)
        if after_epoch is not None:
            after_epoch(state)
    return state


def _step(
    network: Network, active: Examples, target: Tensor, state: State, settings: Settings
) -> Step | Replayed:
    """A step of the patches still in training; on a GPU as the settings say."""
    written = state.learning_rate, state.weights, state.first_moment, state.second_moment
    step = Step(network, settings, active.windows, active.train, target, *written)
    if active.windows.is_cuda and settings.compiled:
        step = torch.compile(step, dynamic=False)
    return Replayed(step) if active.windows.is_cuda and settings.replayed else step


def _judge(state: State, score: Tensor, settings: Settings) -> bool:
    """Keep better weights; else reduce the learning rate or stop; whether any stopped."""
    better = score > state.score
    state.best[state.patches[better]] = state.weights[better]
    state.epochs[state.patches[better]] = state.epoch
    state.score = torch.where(better, score, state.score)
    state.since = torch.where(better, 0, state.since + 1)
    state.waited = torch.where(better, 0, state.waited + 1)
    reduced = state.waited >= settings.lr_patience
    lower = state.learning_rate * settings.lr_factor
    state.learning_rate.copy_(torch.where(reduced[:, None], lower, state.learning_rate))  # a step reads it
    state.waited = torch.where(reduced, 0, state.waited)
    going = state.since < settings.patience
    if bool(going.all()):
        return False
    state.keep(going)
    return True


def name_windows(network: Network, weights: Tensor, windows: Tensor) -> Tensor:
    """Classes (P, W) of windows (W, P, samples, channels)."""
    with torch.inference_mode():
        parts = windows.permute(1, 2, 3, 0).split(PREDICTED_AT_ONCE, dim=-1)
        return torch.cat([network.forward(weights, part).argmax(dim=1) for part in parts], dim=1)


def validation_score(network: Network, weights: Tensor, examples: Examples) -> Tensor:
    """Macro F1 of each patch on the validation windows, a lower loss deciding between equals; shape (Q,)."""
    labels = examples.labels[examples.validation]
    with torch.inference_mode():
        parts = [
            network.forward(weights, examples.windows[rows].permute(1, 2, 3, 0))
            for rows in examples.validation.split(PREDICTED_AT_ONCE)
        ]
        scores = torch.cat(parts, dim=-1)
        loss = mean_loss(scores, targets(labels, network.classes))
        return macro_f1(scores.argmax(dim=1), labels, network.classes) - TIE_BREAK * loss


def macro_f1(named: Tensor, labels: Tensor, classes: int) -> Tensor:
    """Mean F1 of the classes among `labels` (W,), for each row of `named` (Q, W)."""
    truth = functional.one_hot(labels, classes).float()
    given = functional.one_hot(named, classes).float()
    hits = (given * truth).sum(dim=1)
    f1 = 2 * hits / (given.sum(dim=1) + truth.sum(dim=0)).clamp(min=1)
    return f1[:, truth.any(dim=0)].mean(dim=1)


def targets(labels: Tensor, classes: int, label_smoothing: float = 0.0) -> Tensor:
    """Target distributions (classes, W) of windows' labels (W,), weighed so that all classes count the same.

    Each column sums to the weight of its window; the weights are 1 on average. The share `label_smoothing` is
    spread over all classes (Szegedy et al. 2016).
    """
    windows = torch.bincount(labels, minlength=classes)
    present = (windows > 0).sum()
    weight = len(labels) / (present * windows.clamp(min=1)).float()
    one_hot = functional.one_hot(labels, classes).float().T
    return (one_hot * (1 - label_smoothing) + label_smoothing / classes) * weight[labels]
