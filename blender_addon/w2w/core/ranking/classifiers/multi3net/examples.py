# SPDX-License-Identifier: GPL-3.0-or-later
"""What the networks of `Multi3Net` are shown: each channel's samples, and beside them its spectrum."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

SPECTRUM_FLOOR = 0.05
"""Amplitude below which nothing is told apart, as a share of the channel's standard deviation."""
LEAST_STD = 1e-6
"""Standard deviation below which a channel is taken to be constant."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Windows of P patches and what they show, ready for the network.

    Parameters
    ----------
    windows : Tensor, shape (P, numbers, channels, W)
    labels : Tensor of int, shape (W,)
    train, validation : Tensor of int
        Indices of the windows of the training and of the validation split.
    """

    windows: Tensor
    labels: Tensor
    train: Tensor
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
        """Scale windows by the mean and standard deviation of each patch's training windows.

        Parameters
        ----------
        windows : ndarray, shape (W, P, samples, channels)
        labels : ndarray of int, shape (W,)
        train, validation : ndarray of int
        device : str
        spectrum : int
            Frequencies, from the lowest but zero, whose amplitude is told as well; see `shape_of`.
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
    """What of a window does not depend on when it begins.

    Parameters
    ----------
    signals : Tensor, shape (P, samples, channels, W)
    std : Tensor, shape (P, 1, channels, 1)
        Of each channel over all windows, in the unit of the signals.
    frequencies : int
        At most half the samples are there.

    Returns
    -------
    Tensor, shape (P, 2 + frequencies, channels, W)
        Mean (in which gravity's direction is kept), logarithm of the deviation, and logarithms of
        the amplitudes under a Hann window.
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
