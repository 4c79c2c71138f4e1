# SPDX-License-Identifier: GPL-3.0-or-later
"""Train the networks of many places together, each with a learning rate and an end of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields, replace

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from .multi3net_network import Network

DECAY, SQUARE_DECAY, FLOOR = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015)."""
PREDICTED_AT_ONCE = 256
"""Windows named in one go."""
TIE_BREAK = 1e-4
"""Share of the loss in a score, too little to outweigh a window named rightly."""


@dataclass(frozen=True)
class Schedule:
    """How long and how fast to train; see `Multi3Net`."""

    rate: float
    batch: int
    epochs: int
    patience: int
    plateau: int
    drop: float


@dataclass(frozen=True, eq=False)
class Examples:
    """Windows of P places and what they show, ready for the network.

    Parameters
    ----------
    windows : Tensor, shape (P, samples, channels, W)
    labels : Tensor of int, shape (W,)
    train, check : Tensor of int
        Indices of the windows to learn from, and of those that say when to stop.
    """

    windows: Tensor
    labels: Tensor
    train: Tensor
    check: Tensor

    @classmethod
    def prepare(
        cls, windows: np.ndarray, labels: np.ndarray, train: np.ndarray, check: np.ndarray, device: str
    ) -> Examples:
        """Scale windows (W, P, samples, channels) by the mean and spread of each place's training windows."""
        signals = torch.as_tensor(windows).to(device).permute(1, 2, 3, 0).contiguous()
        rows = torch.as_tensor(train, device=device)
        learnt = signals[..., rows]
        mean = learnt.mean(dim=(1, 3), keepdim=True)
        spread = learnt.std(dim=(1, 3), keepdim=True, correction=0)
        signals.sub_(mean).div_(torch.where(spread > 1e-6, spread, torch.ones_like(spread)))
        return cls(
            signals,
            torch.as_tensor(labels, device=device),
            rows,
            torch.as_tensor(check, device=device),
        )

    def of(self, places: Tensor) -> Examples:
        """The same windows of some of the places."""
        return replace(self, windows=self.windows[places])


@dataclass(eq=False)
class State:
    """All that training goes on from.

    Parameters
    ----------
    epoch : int
        Epochs done.
    step : int
        Steps done.
    places : Tensor of int, shape (Q,)
        Places still in training, as indices among the P of the group.
    weights, momentum, square : Tensor, shape (Q, n_weights)
    rate : Tensor, shape (Q, 1)
        Learning rate of each.
    score : Tensor, shape (Q,)
        The highest on the checking windows so far.
    since, waited : Tensor of int, shape (Q,)
        Epochs since then, and since then or the last drop of the learning rate.
    best : Tensor, shape (P, n_weights)
        Weights at the highest score, of all places of the group.
    epochs : Tensor of int, shape (P,)
        Epoch of the highest score.
    """

    epoch: int
    step: int
    places: Tensor
    weights: Tensor
    momentum: Tensor
    square: Tensor
    rate: Tensor
    score: Tensor
    since: Tensor
    waited: Tensor
    best: Tensor
    epochs: Tensor

    @classmethod
    def start(cls, weights: Tensor, n_places: int, rate: float) -> State:
        """Untrained: the same `weights` (n_weights,) at every place."""
        stacked = weights.repeat(n_places, 1)
        device = weights.device
        return cls(
            epoch=0,
            step=0,
            places=torch.arange(n_places, device=device),
            weights=stacked,
            momentum=torch.zeros_like(stacked),
            square=torch.zeros_like(stacked),
            rate=torch.full((n_places, 1), rate, dtype=weights.dtype, device=device),
            score=torch.full((n_places,), -torch.inf, dtype=weights.dtype, device=device),
            since=torch.zeros(n_places, dtype=torch.int64, device=device),
            waited=torch.zeros(n_places, dtype=torch.int64, device=device),
            best=stacked.clone(),
            epochs=torch.zeros(n_places, dtype=torch.int64, device=device),
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """As arrays, for a file."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: value.cpu().numpy() if isinstance(value, Tensor) else np.array(value)
            for name, value in values.items()
        }

    @classmethod
    def restore(cls, arrays: dict[str, np.ndarray], device: str) -> State:
        """From what `arrays` gave."""
        counters = ("epoch", "step")
        tensors = {
            name: torch.as_tensor(arrays[name], device=device)
            for name in (field.name for field in fields(cls))
            if name not in counters
        }
        return cls(**tensors, **{name: int(arrays[name]) for name in counters})

    def keep(self, going: Tensor) -> None:
        """Go on with some of the places only."""
        for name in ("places", "weights", "momentum", "square", "rate", "score", "since", "waited"):
            setattr(self, name, getattr(self, name)[going])


def train(
    network: Network,
    examples: Examples,
    schedule: Schedule,
    generator: Callable[[int], torch.Generator],
    state: State | None = None,
    after_epoch: Callable[[State], None] | None = None,
) -> State:
    """Train until every place has stopped; `State.best` then holds the weights to use.

    All places start from the same weights and meet the same order of windows and the same
    dropout, so that they differ by their signals alone, and each is trained as it would be
    alone. One that has stopped improving leaves the batch.

    Parameters
    ----------
    network : Network
    examples : Examples
        Where it has no checking windows, the training loss says when to stop.
    schedule : Schedule
    generator : callable
        Draws of an epoch, 1 and up; 0 is for the first weights.
    state : State, optional
        Where to go on.
    after_epoch : callable, optional
        Given the state after each epoch.
    """
    device = examples.windows.device
    state = state or State.start(
        network.initial(generator(0)).to(examples.windows), len(examples.windows), schedule.rate
    )
    importance = _importance(examples.labels[examples.train], network.classes)
    active = examples.of(state.places)
    while len(state.places) and state.epoch < schedule.epochs:
        draws = generator(state.epoch + 1)
        losses = []
        for rows in _batches(len(examples.train), schedule.batch, draws):
            chosen = examples.train[rows.to(device)]
            masks = [mask.to(active.windows) for mask in network.masks(len(chosen), draws)]
            losses.append(_step(network, state, active, chosen, masks, importance))
        state.epoch += 1
        score = check_score(network, state.weights, active) if len(examples.check) else -sum(losses)
        if _judge(state, score, schedule):
            active = examples.of(state.places)
        if after_epoch is not None:
            after_epoch(state)
    return state


def name_windows(network: Network, weights: Tensor, windows: Tensor) -> Tensor:
    """Classes (P, W) of windows (P, samples, channels, W)."""
    with torch.inference_mode():
        parts = windows.split(PREDICTED_AT_ONCE, dim=-1)
        return torch.cat([network.forward(weights, part).argmax(dim=1) for part in parts], dim=1)


def check_score(network: Network, weights: Tensor, examples: Examples) -> Tensor:
    """Macro F1 of each place on the checking windows, a lower loss deciding between equals; shape (Q,)."""
    labels = examples.labels[examples.check]
    with torch.inference_mode():
        parts = [
            network.forward(weights, examples.windows[..., rows])
            for rows in examples.check.split(PREDICTED_AT_ONCE)
        ]
        scores = torch.cat(parts, dim=-1)
        loss = _losses(scores, labels, _importance(labels, network.classes)).mean(dim=1)
        return _macro_f1(scores.argmax(dim=1), labels, network.classes) - TIE_BREAK * loss


def _macro_f1(named: Tensor, labels: Tensor, classes: int) -> Tensor:
    """Mean F1 of the classes among `labels` (W,), for each row of `named` (Q, W)."""
    truth = functional.one_hot(labels, classes).float()
    said = functional.one_hot(named, classes).float()
    hits = (said * truth).sum(dim=1)
    f1 = 2 * hits / (said.sum(dim=1) + truth.sum(dim=0)).clamp(min=1)
    return f1[:, truth.any(dim=0)].mean(dim=1)


def _step(
    network: Network, state: State, active: Examples, rows: Tensor, masks: list[Tensor], importance: Tensor
) -> Tensor:
    """One step of Adam; the loss of each place before it."""
    weights = state.weights.requires_grad_()
    scores = network.forward(weights, active.windows[..., rows], masks)
    losses = _losses(scores, active.labels[rows], importance).mean(dim=1)
    (slope,) = torch.autograd.grad(losses.sum(), weights)
    state.weights = weights.detach()
    state.step += 1
    state.momentum.lerp_(slope, 1 - DECAY)
    state.square.mul_(SQUARE_DECAY).addcmul_(slope, slope, value=1 - SQUARE_DECAY)
    spread = (state.square / (1 - SQUARE_DECAY**state.step)).sqrt_().add_(FLOOR)
    state.weights.addcmul_(state.momentum.div(spread), state.rate, value=-1 / (1 - DECAY**state.step))
    return losses.detach()


def _judge(state: State, score: Tensor, schedule: Schedule) -> bool:
    """Keep the weights that improved, slow down or stop the others; whether any stopped."""
    better = score > state.score
    state.best[state.places[better]] = state.weights[better]
    state.epochs[state.places[better]] = state.epoch
    state.score = torch.where(better, score, state.score)
    state.since = torch.where(better, 0, state.since + 1)
    state.waited = torch.where(better, 0, state.waited + 1)
    slower = state.waited >= schedule.plateau
    state.rate = torch.where(slower[:, None], state.rate * schedule.drop, state.rate)
    state.waited = torch.where(slower, 0, state.waited)
    going = state.since < schedule.patience
    if bool(going.all()):
        return False
    state.keep(going)
    return True


def _losses(scores: Tensor, labels: Tensor, importance: Tensor) -> Tensor:
    """Cross-entropy (P, B) of scores (P, classes, B), weighed by class."""
    losses = functional.cross_entropy(scores, labels.expand(len(scores), -1), reduction="none")
    return losses * importance[labels]


def _importance(labels: Tensor, classes: int) -> Tensor:
    """Weight of a window by its class, so that all classes count the same; 1 on average."""
    windows = torch.bincount(labels, minlength=classes)
    present = (windows > 0).sum()
    return len(labels) / (present * windows.clamp(min=1)).float()


def _batches(windows: int, batch: int, draws: torch.Generator) -> Iterator[Tensor]:
    """All windows once, in batches of about equal size."""
    order = torch.randperm(windows, generator=draws)
    return iter(torch.tensor_split(order, max(1, round(windows / batch))))
