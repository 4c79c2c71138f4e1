# SPDX-License-Identifier: GPL-3.0-or-later
"""Examples for the networks of `Multi3Net`: each channel's samples, and beside them its spectrum."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

SPECTRUM_FLOOR = 0.05
"""Smallest amplitude told apart, as a share of the channel's standard deviation."""
LEAST_STD = 1e-6
"""Standard deviation below which a channel is taken to be constant."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Windows of P patches and what they show, ready for the network."""

    windows: Tensor  # (P, numbers, channels, W)
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
    ) -> Examples:
        """Scale windows (W, P, samples, channels) by mean and deviation of each patch's training windows.

        The amplitudes of the `spectrum` lowest frequencies but zero are shown as well; see `shape_of`.
        """
        signals = torch.as_tensor(windows).to(device).permute(1, 2, 3, 0).contiguous()
        rows = torch.as_tensor(train, device=device)
        std = signals[..., rows].std(dim=(1, 3), keepdim=True, correction=0)
        parts = [_scaled(signals, rows, (1, 3))]
        if spectrum:
            parts.append(_scaled(shape_of(signals, std, spectrum), rows, (3,)))
        return cls(
            torch.cat(parts, dim=1),
            torch.as_tensor(labels, device=device),
            rows,
            torch.as_tensor(validation, device=device),
        )

    def of(self, patches: Tensor) -> Examples:
        """The same windows of some of the patches."""
        return replace(self, windows=self.windows[patches])


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
