# SPDX-License-Identifier: GPL-3.0-or-later
"""One step of training as a program of tensors alone: what is drawn for it, and its replay on a GPU."""

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from .network import Network
from .settings import Settings

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-8
"""Adam's constants (Kingma and Ba 2015)."""
PLAIN_STEPS = 3
"""Steps on a side stream before one is captured, in which CUDA's libraries set themselves up."""


class Drawn(NamedTuple):
    """What chance and schedule give one step of B windows, the same for all patches."""

    rows: Tensor  # (B,), int: places in the training split
    others: Tensor  # (B,), int: places among the B of the windows that each is mixed with
    counts: Tensor  # (B,): weights in the mean loss; 0 for padding
    embedding: Tensor  # (width, channels, B): dropout, as `Network.masks` gives it
    channels: Tensor
    segments: Tensor
    share: Tensor  # (): of a window itself in mixup
    pace: Tensor  # (3,): of the learning rate; Adam's corrections of the second and of the first moment


OF_WINDOWS = 6
"""Fields of `Drawn` with an axis of windows, which come first."""


def draw_epoch(
    network: Network,
    settings: Settings,
    n_windows: int,
    done: int,
    draws: torch.Generator,
    dtype: torch.dtype,
) -> Iterator[Drawn]:
    """Draw each step of an epoch, after `done` steps; batches are of about equal size."""
    n_batches = settings.batches(n_windows)
    order = torch.randperm(n_windows, generator=draws)
    for step, rows in enumerate(torch.tensor_split(order, n_batches), start=done + 1):
        masks = [mask.to(dtype) for mask in network.masks(len(rows), draws)]
        share, others = 1.0, rows
        if settings.mixup:
            seed = int(torch.randint(2**62, (), generator=draws))
            share = float(np.random.default_rng(seed).beta(settings.mixup, settings.mixup))
            others = torch.randperm(len(rows), generator=draws)
        rate = settings.schedule(step, settings.epochs * n_batches)
        pace = torch.tensor([rate, 1 - BETA_2**step, -1 / (1 - BETA_1**step)], dtype=dtype)
        yield Drawn(
            rows, others, torch.ones(len(rows), dtype=dtype), *masks, torch.tensor(share, dtype=dtype), pace
        )


def together(drawn: Iterable[Drawn], size: int) -> Drawn:
    """The draws of several steps, stacked; each padded to `size` windows by some that count nothing."""
    padded = []
    for one in drawn:
        n_windows = len(one.rows)
        one = one._replace(counts=one.counts * (size / n_windows))
        of_windows = (functional.pad(values, (0, size - n_windows)) for values in one[:OF_WINDOWS])
        padded.append((*of_windows, *one[OF_WINDOWS:]))
    return Drawn(*map(torch.stack, zip(*padded, strict=True)))


def beside(drawn: Iterable[Drawn], windows: Tensor, size: int) -> Iterable[Drawn]:
    """The draws where the windows lie: on a GPU sent at once, all of one size."""
    if not windows.is_cuda:
        return drawn
    sent = (values.pin_memory().to(windows.device, non_blocking=True) for values in together(drawn, size))
    return map(Drawn._make, zip(*sent, strict=True))


@dataclass(frozen=True, eq=False)
class Step:
    """One step of Adam for Q patches; called with draws it gives the loss (Q,) of each before it.

    It reads and writes tensors that stay where they are, waits for none and makes none on the CPU: a GPU can
    replay it.
    """

    network: Network
    settings: Settings
    windows: Tensor  # (W, Q, numbers, channels)
    train: Tensor  # int: indices of the windows of the training split
    target: Tensor  # (classes, windows of the training split)
    learning_rate: Tensor  # (Q, 1)
    weights: Tensor  # (Q, n_weights), written, as are Adam's moments of the gradient
    first_moment: Tensor
    second_moment: Tensor

    def __call__(self, drawn: Drawn) -> Tensor:
        """Losses (Q,)."""
        windows, target = self.windows[self.train[drawn.rows]], self.target[:, drawn.rows]
        if self.settings.mixup:  # the same pairs at all patches
            windows = torch.lerp(windows[drawn.others], windows, drawn.share)
            target = torch.lerp(target[:, drawn.others], target, drawn.share)
        weights = self.weights.detach().requires_grad_()
        masks = [drawn.embedding, drawn.channels, drawn.segments]
        scores = self.network.forward(weights, windows.permute(1, 2, 3, 0), masks)
        losses = mean_loss(scores, target * drawn.counts)
        (gradient,) = torch.autograd.grad(losses.sum(), weights)
        pace, second, first = drawn.pace.unbind()
        self.first_moment.lerp_(gradient, 1 - BETA_1)
        self.second_moment.mul_(BETA_2).addcmul_(gradient, gradient, value=1 - BETA_2)
        root = (self.second_moment / second).sqrt_().add_(EPSILON)
        learning_rate = self.learning_rate * pace
        self.weights.mul_(1 - learning_rate * self.settings.weight_decay)
        self.weights.addcmul_(self.first_moment.div(root).mul_(first), learning_rate)
        return losses.detach()


@dataclass(eq=False)
class Replayed:
    """A step as one CUDA graph: run as it is a few times, then captured, from then on replayed."""

    step: Callable[[Drawn], Tensor]
    plain: int = PLAIN_STEPS
    graph: torch.cuda.CUDAGraph = field(default_factory=torch.cuda.CUDAGraph)
    side: torch.cuda.Stream = field(default_factory=torch.cuda.Stream)  # none may be captured on the default
    given: Drawn | None = None  # which the graph reads
    losses: Tensor | None = None  # which it writes

    def __call__(self, drawn: Drawn) -> Tensor:
        """Losses (Q,) of the step."""
        if self.plain:
            self.plain -= 1
            self.side.wait_stream(torch.cuda.current_stream())
            with torch.cuda.stream(self.side):
                losses = self.step(drawn)
            torch.cuda.current_stream().wait_stream(self.side)
            return losses
        if self.given is None:
            self.given = Drawn(*(values.clone() for values in drawn))
            with torch.cuda.graph(self.graph, stream=self.side):
                self.losses = self.step(self.given)
        for kept, values in zip(self.given, drawn, strict=True):
            kept.copy_(values)
        self.graph.replay()
        return self.losses.clone()


def mean_loss(scores: Tensor, target: Tensor) -> Tensor:
    """Mean cross-entropy (P,) of scores (P, classes, B) with their targets (classes, B)."""
    return -(scores.log_softmax(dim=1) * target.to(scores)).sum(dim=1).mean(dim=1)
