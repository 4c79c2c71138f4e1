# SPDX-License-Identifier: GPL-3.0-or-later
"""What the networks of `Multi3Net` are shown: each channel's samples, and beside them its spectrum."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

SPECTRUM_FLOOR = 0.05
"""Amplitude below which nothing is told apart, as a share of the channel's spread."""
LEAST_SPREAD = 1e-6
"""Spread below which a channel is taken to be constant."""


@dataclass(frozen=True, eq=False)
class Examples:
    """Windows of P patches and what they show, ready for the network.

    Parameters
    ----------
    windows : Tensor, shape (P, numbers, channels, W)
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
        cls,
        windows: np.ndarray,
        labels: np.ndarray,
        train: np.ndarray,
        check: np.ndarray,
        device: str,
        spectrum: int = 0,
    ) -> Examples:
        """Scale windows by the mean and spread of each patch's training windows.

        Parameters
        ----------
        windows : ndarray, shape (W, P, samples, channels)
        labels : ndarray of int, shape (W,)
        train, check : ndarray of int
        device : str
        spectrum : int
            Frequencies, from the lowest but zero, whose amplitude is told as well; see `shape_of`.
        """
        signals = torch.as_tensor(windows).to(device).permute(1, 2, 3, 0).contiguous()
        rows = torch.as_tensor(train, device=device)
        spread = signals[..., rows].std(dim=(1, 3), keepdim=True, correction=0)
        parts = [_scaled(signals, rows, (1, 3))]
        if spectrum:
            parts.append(_scaled(shape_of(signals, spread, spectrum), rows, (3,)))
        return cls(
            torch.cat(parts, dim=1),
            torch.as_tensor(labels, device=device),
            rows,
            torch.as_tensor(check, device=device),
        )

    def of(self, patches: Tensor) -> Examples:
        """The same windows of some of the patches."""
        return replace(self, windows=self.windows[patches])


def shape_of(signals: Tensor, spread: Tensor, frequencies: int) -> Tensor:
    """What of a window does not depend on when it begins.

    Parameters
    ----------
    signals : Tensor, shape (P, samples, channels, W)
    spread : Tensor, shape (P, 1, channels, 1)
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
    floor = SPECTRUM_FLOOR * spread.clamp(min=LEAST_SPREAD)
    mean = signals.mean(dim=1, keepdim=True)
    centred = signals - mean
    deviation = centred.square().mean(dim=1, keepdim=True).sqrt()
    hann = torch.hann_window(samples, periodic=False, dtype=signals.dtype, device=signals.device)
    amplitude = torch.fft.rfft(centred * hann[:, None, None], dim=1).abs()[:, 1 : 1 + frequencies]
    return torch.cat([mean, (deviation + floor).log(), (amplitude / samples + floor).log()], dim=1)


def _scaled(numbers: Tensor, rows: Tensor, over: tuple[int, ...]) -> Tensor:
    """Less the mean and by the spread of the training windows, each taken over some dimensions."""
    learnt = numbers[..., rows]
    mean = learnt.mean(dim=over, keepdim=True)
    spread = learnt.std(dim=over, keepdim=True, correction=0)
    return (numbers - mean) / torch.where(spread > LEAST_SPREAD, spread, torch.ones_like(spread))
