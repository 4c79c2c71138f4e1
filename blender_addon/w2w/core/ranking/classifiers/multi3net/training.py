# SPDX-License-Identifier: GPL-3.0-or-later
"""Train the networks of many patches together, each with a learning rate and an end of its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields

import numpy as np
import torch
from torch import Tensor

from .examples import Examples
from .network import Network
from .scores import check_score, mean_loss, targets
from .settings import Settings

DECAY, SQUARE_DECAY, FLOOR = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015)."""

OF_TRAINING = ("patches", "weights", "momentum", "square", "rate", "score", "since", "waited")
OF_ALL = ("best", "epochs")
"""What `State` keeps of the patches still in training, and of all patches."""


@dataclass(eq=False)
class State:
    """All that training goes on from.

    Parameters
    ----------
    epoch : int
        Epochs done.
    step : int
        Steps done.
    patches : Tensor of int, shape (Q,)
        Patches still in training, as indices among the P of the group.
    weights, momentum, square : Tensor, shape (Q, n_weights)
    rate : Tensor, shape (Q, 1)
        Learning rate of each.
    score : Tensor, shape (Q,)
        The highest on the checking windows so far.
    since, waited : Tensor of int, shape (Q,)
        Epochs since then, and since then or the last drop of the learning rate.
    best : Tensor, shape (P, n_weights)
        Weights at the highest score, of all patches of the group.
    epochs : Tensor of int, shape (P,)
        Epoch of the highest score.
    """

    epoch: int
    step: int
    patches: Tensor
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
    def start(cls, weights: Tensor, n_patches: int, rate: float) -> State:
        """Untrained: the same `weights` (n_weights,) at every patch."""
        stacked = weights.repeat(n_patches, 1)
        device = weights.device
        return cls(
            epoch=0,
            step=0,
            patches=torch.arange(n_patches, device=device),
            weights=stacked,
            momentum=torch.zeros_like(stacked),
            square=torch.zeros_like(stacked),
            rate=torch.full((n_patches, 1), rate, dtype=weights.dtype, device=device),
            score=torch.full((n_patches,), -torch.inf, dtype=weights.dtype, device=device),
            since=torch.zeros(n_patches, dtype=torch.int64, device=device),
            waited=torch.zeros(n_patches, dtype=torch.int64, device=device),
            best=stacked.clone(),
            epochs=torch.zeros(n_patches, dtype=torch.int64, device=device),
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """As arrays, for a file."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {
            name: value.cpu().numpy() if isinstance(value, Tensor) else np.array(value)
            for name, value in values.items()
        }

    @classmethod
    def restore(
        cls, arrays: dict[str, np.ndarray], device: str, n_patches: int, n_weights: int
    ) -> State | None:
        """From what `arrays` gave; nothing if that is not of so many patches and weights."""
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
) -> State:
    """Train until every patch has stopped; `State.best` then holds the weights to use.

    All patches start from the same weights and meet the same order of windows and the same
    dropout, so that they differ by their signals alone, and each is trained as it would be
    alone. One that has stopped improving leaves the batch.

    Parameters
    ----------
    network : Network
    examples : Examples
        Where it has no checking windows, the training loss says when to stop.
    settings : Settings
    generator : callable
        Draws of an epoch, 1 and up; 0 is for the first weights.
    state : State, optional
        Where to go on.
    after_epoch : callable, optional
        Given the state after each epoch.
    """
    device = examples.windows.device
    state = state or State.start(
        network.initial(generator(0)).to(examples.windows), len(examples.windows), settings.rate
    )
    wanted = targets(examples.labels[examples.train], network.classes, settings.smoothing)
    steps = settings.epochs * _n_batches(len(examples.train), settings.batch)
    active = examples.of(state.patches)
    while len(state.patches) and state.epoch < settings.epochs:
        draws = generator(state.epoch + 1)
        losses = []
        for rows in _batches(len(examples.train), settings.batch, draws):
            rows = rows.to(device)
            shown = active.windows[..., examples.train[rows]], wanted[:, rows]
            masks = [mask.to(active.windows) for mask in network.masks(len(rows), draws)]
            if settings.mixing:
                shown = _mixed(*shown, settings.mixing, draws)
            losses.append(_step(network, state, *shown, masks, settings, steps))
        state.epoch += 1
        if not settings.stopping:
            state.best, state.epochs = state.weights, torch.full_like(state.epochs, state.epoch)
        else:
            score = check_score(network, state.weights, active) if len(examples.check) else -sum(losses)
            if _judge(state, score, settings):
                active = examples.of(state.patches)
        if after_epoch is not None:
            after_epoch(state)
    return state


def _step(
    network: Network,
    state: State,
    windows: Tensor,
    wanted: Tensor,
    masks: list[Tensor],
    settings: Settings,
    steps: int,
) -> Tensor:
    """One of all steps of Adam; the loss of each patch before it."""
    weights = state.weights.requires_grad_()
    losses = mean_loss(network.forward(weights, windows, masks), wanted)
    (slope,) = torch.autograd.grad(losses.sum(), weights)
    state.weights = weights.detach()
    state.step += 1
    state.momentum.lerp_(slope, 1 - DECAY)
    state.square.mul_(SQUARE_DECAY).addcmul_(slope, slope, value=1 - SQUARE_DECAY)
    spread = (state.square / (1 - SQUARE_DECAY**state.step)).sqrt_().add_(FLOOR)
    rate = state.rate * settings.pace(state.step, steps)
    state.weights.mul_(1 - rate * settings.decay)
    state.weights.addcmul_(state.momentum.div(spread), rate, value=-1 / (1 - DECAY**state.step))
    return losses.detach()


def _judge(state: State, score: Tensor, settings: Settings) -> bool:
    """Keep the weights that improved, slow down or stop the others; whether any stopped."""
    better = score > state.score
    state.best[state.patches[better]] = state.weights[better]
    state.epochs[state.patches[better]] = state.epoch
    state.score = torch.where(better, score, state.score)
    state.since = torch.where(better, 0, state.since + 1)
    state.waited = torch.where(better, 0, state.waited + 1)
    slower = state.waited >= settings.plateau
    state.rate = torch.where(slower[:, None], state.rate * settings.drop, state.rate)
    state.waited = torch.where(slower, 0, state.waited)
    going = state.since < settings.patience
    if bool(going.all()):
        return False
    state.keep(going)
    return True


def _batches(windows: int, batch: int, draws: torch.Generator) -> Iterator[Tensor]:
    """All windows once, in batches of about equal size."""
    order = torch.randperm(windows, generator=draws)
    return iter(torch.tensor_split(order, _n_batches(windows, batch)))


def _n_batches(windows: int, batch: int) -> int:
    return max(1, round(windows / batch))


def _mixed(windows: Tensor, wanted: Tensor, mixing: float, draws: torch.Generator) -> tuple[Tensor, Tensor]:
    """Each window and what it shall say, blended with another's (mixup); the same pairs at all patches."""
    seed = int(torch.randint(2**62, (), generator=draws))
    share = float(np.random.default_rng(seed).beta(mixing, mixing))
    others = torch.randperm(windows.shape[-1], generator=draws).to(windows.device)
    return torch.lerp(windows[..., others], windows, share), torch.lerp(wanted[:, others], wanted, share)
