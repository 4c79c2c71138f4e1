# SPDX-License-Identifier: GPL-3.0-or-later
"""The IMU branch of Multi3Net for many patches at once, every weight with a leading axis of patches.

Its inputs, too: each channel's samples and its spectrum.
"""

import math
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

SPECTRUM_FLOOR = 0.05
"""Smallest amplitude that counts, as a share of the channel's standard deviation."""
LEAST_STD = 1e-6
"""Standard deviation below which a channel is taken to be constant."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Windows of P patches and what they show, ready for the network."""

    windows: Tensor  # (W, P, numbers, channels): some of them are shown at a time, in any order
    labels: Tensor  # (W,), int
    train: Tensor  # int: indices of the windows of the training split
    validation: Tensor

    @classmethod
    def prepare(
        cls,
        windows: np.ndarray,
        labels: np.ndarray,
        train: np.ndarray,
        validation: np.ndarray,
        device: str,
        spectrum: int = 0,
    ) -> Self:
        """Scale windows (W, P, samples, channels) by mean and deviation of each patch's training windows.

        The amplitudes of the `spectrum` lowest frequencies but zero are shown as well; see `shape_of`.
        """
        signals = torch.as_tensor(windows).to(device).permute(1, 2, 3, 0).contiguous()
        rows = torch.as_tensor(train, device=device)
        std = signals[..., rows].std(dim=(1, 3), keepdim=True, correction=0)
        parts = [_scaled(signals, rows, (1, 3))]
        if spectrum:
            parts.append(_scaled(shape_of(signals, std, spectrum), rows, (3,)))
        shown, checked = (torch.as_tensor(values, device=device) for values in (labels, validation))
        return cls(torch.cat(parts, dim=1).permute(3, 0, 1, 2).contiguous(), shown, rows, checked)

    def of(self, patches: Tensor) -> Self:
        """The same windows of some of the patches."""
        return replace(self, windows=self.windows[:, patches])


def shape_of(signals: Tensor, std: Tensor, frequencies: int) -> Tensor:
    """Describe signals (P, samples, channels, W) by what does not depend on when a window begins.

    By the mean (in which gravity's direction is kept), the logarithm of the deviation, and logarithms of the
    amplitudes under a Hann window, of at most half as many frequencies as samples: (P, 2 + frequencies,
    channels, W). `std` (P, 1, channels, 1) is that of each channel over all windows.
    """
    samples = signals.shape[1]
    floor = SPECTRUM_FLOOR * std.clamp(min=LEAST_STD)
    mean = signals.mean(dim=1, keepdim=True)
    centred = signals - mean
    deviation = centred.square().mean(dim=1, keepdim=True).sqrt()
    hann = torch.hann_window(samples, periodic=False, dtype=signals.dtype, device=signals.device)
    amplitude = torch.fft.rfft(centred * hann[:, None, None], dim=1).abs()[:, 1 : 1 + frequencies]
    return torch.cat([mean, (deviation + floor).log(), (amplitude / samples + floor).log()], dim=1)


def _scaled(numbers: Tensor, rows: Tensor, over: tuple[int, ...]) -> Tensor:
    """Standardised by mean and standard deviation of the training windows over some dimensions."""
    trained = numbers[..., rows]
    mean = trained.mean(dim=over, keepdim=True)
    std = trained.std(dim=over, keepdim=True, correction=0)
    return (numbers - mean) / torch.where(std > LEAST_STD, std, torch.ones_like(std))


def attention_among_few(query: Tensor, key: Tensor, value: Tensor, dropout: Tensor | None = None) -> Tensor:
    """Scaled dot-product attention (Vaswani et al. 2017), shape (P, heads, E, T, B) as query, key and value.

    Of P patches, E numbers of T tokens in each of B windows. `dropout` (heads, T, T, B) holds factors of the
    attention of each token (first) to each other.
    """
    if dropout is None:
        dropout = query.new_ones(1)
    return _Attention.apply(query, key, value, dropout)[0]


class _Attention(torch.autograd.Function):
    generate_vmap_rule = True

    @staticmethod
    def forward(query: Tensor, key: Tensor, value: Tensor, dropout: Tensor) -> tuple[Tensor, Tensor]:
        attention = torch.softmax(_compare(query, key) / math.sqrt(query.shape[2]), dim=3)
        return _blend(attention * dropout, value), attention

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Tensor, ...], output: tuple[Tensor, Tensor]) -> None:
        ctx.mark_non_differentiable(output[1])
        ctx.save_for_backward(*inputs, output[1])

    @staticmethod
    def backward(ctx: Any, slope: Tensor, _: Tensor) -> tuple[Tensor | None, ...]:
        query, key, value, dropout, attention = ctx.saved_tensors
        of_value = _blend((attention * dropout).transpose(2, 3), slope)
        weighed = _compare(slope, value).mul_(dropout).mul_(attention)
        weighed = weighed.addcmul_(attention, weighed.sum(dim=3, keepdim=True), value=-1)
        weighed = weighed.div_(math.sqrt(query.shape[2]))
        return _blend(weighed, key), _blend(weighed.transpose(2, 3), query), of_value, None


def _compare(first: Tensor, second: Tensor) -> Tensor:
    """Dot products of tokens, (P, heads, T, T, B), of two (P, heads, E, T, B)."""
    total = first[:, :, 0, :, None] * second[:, :, 0, None]
    for number in range(1, first.shape[2]):
        total.addcmul_(first[:, :, number, :, None], second[:, :, number, None])
    return total


def _blend(weights: Tensor, tokens: Tensor) -> Tensor:
    """Sums of tokens (P, heads, E, T, B) by weights (P, heads, T, T, B)."""
    total = weights[:, :, None, :, 0] * tokens[:, :, :, :1]
    for number in range(1, tokens.shape[3]):
        total.addcmul_(weights[:, :, None, :, number], tokens[:, :, :, number : number + 1])
    return total


HEADS = 8
SEGMENTS = 8
"""Parts that the classifier head reads an embedding in."""
EMBEDDING_DROPOUT = 0.3
ATTENTION_DROPOUT = 0.1
NORM_FLOOR = 1e-5
"""Added to the variance by a layer norm, as torch does."""


@dataclass(frozen=True)
class Network:
    """P networks of one shape as one program, each with weights and inputs of its own.

    A patch's weights lie in one row of a matrix (P, `n_weights`), so that an optimiser
    step, a copy of the best weights or the removal of patches that have finished is one
    operation. Sizes are those of `Multi3Net`.
    """

    samples: int  # of a window
    channels: int  # six a sensor
    classes: int
    width: int
    hidden: int
    embedding: int

    def shapes(self) -> dict[str, tuple[int, ...]]:
        """Shape of each weight of one patch: matrices (out, in), the others vectors."""
        segment, kernels = self.embedding // SEGMENTS, self._kernels
        return {
            **_linear_shapes("embed", self.width, self.samples),
            **_attention_shapes("channels", self.width),
            **_linear_shapes("hidden", self.hidden, self.channels * self.width),
            **_linear_shapes("describe", self.embedding, self.hidden),
            **_linear_shapes("convolve", kernels, 3 * segment),
            **_attention_shapes("head", kernels),
            **_linear_shapes("mix", self.embedding, SEGMENTS * kernels),
            **_linear_shapes("name", self.classes, self.embedding),
        }

    @property
    def n_weights(self) -> int:
        """Weights of one patch."""
        return sum(math.prod(shape) for shape in self.shapes().values())

    @property
    def _kernels(self) -> int:
        """Channels of the head's convolution: 64 at an embedding of 256, and a multiple of the heads."""
        return HEADS * max(1, self.embedding // 4 // HEADS)

    def initial(self, generator: torch.Generator) -> Tensor:
        """Weights of one patch (n_weights,): torch's own defaults for linear layers and norms."""
        rows = []
        fan_in = 1
        for name, shape in self.shapes().items():
            if name.endswith(("_scale", "_shift")):
                rows.append(torch.full(shape, float(name.endswith("_scale"))))
                continue
            if len(shape) == 2:
                fan_in = shape[1]
            rows.append((torch.rand(math.prod(shape), generator=generator) * 2 - 1) / math.sqrt(fan_in))
        return torch.cat([row.reshape(-1) for row in rows])

    def masks(self, windows: int, generator: torch.Generator) -> list[Tensor]:
        """Dropout of one step, the same for all patches: a patch alone meets what it meets among others."""
        return [
            _mask((self.width, self.channels, windows), EMBEDDING_DROPOUT, generator),
            _mask((HEADS, self.channels, self.channels, windows), ATTENTION_DROPOUT, generator),
            _mask((HEADS, SEGMENTS, SEGMENTS, windows), ATTENTION_DROPOUT, generator),
        ]

    def forward(self, weights: Tensor, windows: Tensor, masks: list[Tensor] | None = None) -> Tensor:
        """Scores (P, classes, B) of windows (P, samples, channels, B) of order one; weights (P, n_weights).

        Windows lie innermost throughout: matrix products need no transposition, and the
        attention of few tokens, too small for matrix products, runs over all windows at once. `masks` are
        for training.
        """
        n_patches, n_windows = len(windows), windows.shape[-1]
        w = self._named(weights)
        drop_embedding, drop_channels, drop_segments = masks or (None, None, None)

        tokens = _linear(windows.reshape(n_patches, self.samples, -1), w, "embed")
        tokens = tokens.view(n_patches, self.width, self.channels, n_windows)
        tokens = tokens + _positions(self.channels, self.width, windows)
        if drop_embedding is not None:
            tokens = tokens * drop_embedding
        tokens = _norm(tokens + _attend(tokens, w, "channels", drop_channels), w, "channels")
        hidden = functional.relu(_linear(tokens.view(n_patches, -1, n_windows), w, "hidden"))
        embedding = _linear(hidden, w, "describe")

        segments = functional.pad(embedding.view(n_patches, -1, SEGMENTS, n_windows), (0, 0, 1, 1))
        beside = torch.cat([segments[:, :, shift : shift + SEGMENTS] for shift in range(3)], dim=1)
        segments = _linear(beside.view(n_patches, -1, SEGMENTS * n_windows), w, "convolve")
        segments = _norm(segments.view(n_patches, -1, SEGMENTS, n_windows), w, "head")
        segments = segments + _attend(segments, w, "head", drop_segments)
        mixed = functional.relu(_linear(segments.view(n_patches, -1, n_windows), w, "mix"))
        return _linear(mixed, w, "name")

    def _named(self, weights: Tensor) -> dict[str, Tensor]:
        """Weights by name: matrices (P, out, in), vectors (P, n, 1)."""
        shapes = self.shapes()
        parts = weights.split([math.prod(shape) for shape in shapes.values()], dim=1)
        return {
            name: part.view(-1, *(shape if len(shape) == 2 else (*shape, 1)))
            for (name, shape), part in zip(shapes.items(), parts, strict=True)
        }


def _linear_shapes(name: str, n_out: int, n_in: int) -> dict[str, tuple[int, ...]]:
    return {name: (n_out, n_in), f"{name}_bias": (n_out,)}


def _attention_shapes(name: str, width: int) -> dict[str, tuple[int, ...]]:
    layers = _linear_shapes(f"{name}_qkv", 3 * width, width) | _linear_shapes(f"{name}_out", width, width)
    return layers | {f"{name}_scale": (width,), f"{name}_shift": (width,)}


def _linear(inputs: Tensor, w: dict[str, Tensor], name: str) -> Tensor:
    """(P, in, M) -> (P, out, M), each patch by its own matrix."""
    return torch.baddbmm(w[f"{name}_bias"], w[name], inputs)


def _norm(tokens: Tensor, w: dict[str, Tensor], name: str) -> Tensor:
    """Layer norm of (P, D, T, B) over D."""
    centred = tokens - tokens.mean(dim=1, keepdim=True)
    normal = centred * torch.rsqrt((centred * centred).mean(dim=1, keepdim=True) + NORM_FLOOR)
    return torch.addcmul(w[f"{name}_shift"].unsqueeze(-1), normal, w[f"{name}_scale"].unsqueeze(-1))


def _attend(tokens: Tensor, w: dict[str, Tensor], name: str, dropout: Tensor | None) -> Tensor:
    """Self-attention among the T tokens of each window: (P, D, T, B) -> the same shape."""
    n_patches, width, n_tokens, n_windows = tokens.shape
    mixed = _linear(tokens.reshape(n_patches, width, -1), w, f"{name}_qkv")
    mixed = mixed.view(n_patches, 3, HEADS, width // HEADS, n_tokens, n_windows)
    query, key, value = mixed.unbind(dim=1)
    heard = attention_among_few(query, key, value, dropout)
    return _linear(heard.view(n_patches, width, -1), w, f"{name}_out").view(tokens.shape)


def _positions(channels: int, width: int, like: Tensor) -> Tensor:
    """Sinusoidal positional encoding of the channels, (width, channels, 1) (Vaswani et al. 2017)."""
    evens, numbers = (
        torch.arange(0, stop, by, device=like.device) for stop, by in ((width, 2), (channels, 1))
    )
    angles = torch.exp(evens * (-math.log(10000.0) / width))[:, None] * numbers
    return torch.stack([angles.sin(), angles.cos()], dim=1).reshape(width, channels, 1).to(like)


def _mask(shape: tuple[int, ...], dropped: float, generator: torch.Generator) -> Tensor:
    return (torch.rand(shape, generator=generator) >= dropped).float() / (1 - dropped)
