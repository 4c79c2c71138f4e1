# SPDX-License-Identifier: GPL-3.0-or-later
"""Features of windows by MiniRocket's kernels: for how much of a window a pattern stands out.

After Dempster, Schmidt and Webb 2021, doi:10.1145/3447548.3467231: 84 kernels of nine weights, three of them
2 and the others -1, whose taps are spread over time by several dilations; a feature is the share of samples
at which a kernel's output is above a threshold. Theirs are quantiles of the output in training windows. Here
they are quantiles of a normal distribution as wide as the window's own channel: nothing of the library goes
into a feature, so nothing can leak from test to training, and a clip's features are the same in any library.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.stats import norm

from .features import CHANNELS, FLOOR, channels_of

TAPS = 9
"""Weights of a kernel; they add up to nothing, so that a channel's mean does not count."""

RAISED = tuple(combinations(range(TAPS), 3))
"""Which weights are 2, of each kernel."""

DILATIONS = 4
"""Spacings of the taps, from one sample to as far as the window is long."""

OUTERMOST = 0.05
"""Thresholds are quantiles from this to one minus it."""

GOLDEN = (np.sqrt(5) - 1) / 2
"""Its multiples, modulo 1, are spread evenly however many there are."""


class Kernel(NamedTuple):
    """A kernel at one dilation.

    Attributes
    ----------
    raised : tuple of three ints
        Taps of weight 2.
    channel : int
        Of `features.CHANNELS`.
    padded : bool
        Whether zeros stand beyond the window's ends; else samples whose taps reach there are left out.
    threshold : float
        In standard deviations of the channel in the window.
    """

    raised: tuple[int, int, int]
    channel: int
    padded: bool
    threshold: float


@lru_cache(maxsize=8)
def kernels(samples: int, seed: int) -> dict[int, tuple[Kernel, ...]]:
    """The kernels for windows of so many samples, by dilation; their channels are drawn."""
    rng = np.random.default_rng([seed, 5])
    furthest = np.log2(max((samples - 1) / (TAPS - 1), 1))
    dilations = np.unique((2 ** np.linspace(0, furthest, DILATIONS)).astype(int)).tolist()
    found: dict[int, tuple[Kernel, ...]] = {}
    for dilation in dilations:
        fits = samples > (TAPS - 1) * dilation
        first = len(found) * len(RAISED) + 1
        channels = rng.integers(len(CHANNELS), size=len(RAISED))
        quantiles = OUTERMOST + (1 - 2 * OUTERMOST) * (np.arange(first, first + len(RAISED)) * GOLDEN % 1)
        drawn = zip(RAISED, channels.tolist(), norm.ppf(quantiles).tolist(), strict=True)
        found[dilation] = tuple(
            Kernel(raised, channel, not fits or number % 2 == 0, threshold)
            for number, (raised, channel, threshold) in enumerate(drawn)
        )
    return found


def kernel_features(windows: np.ndarray, seed: int = 0) -> np.ndarray:
    """Describe each window of each sensor by the kernels.

    Parameters
    ----------
    windows : ndarray, shape (W, N, samples, 6)
        As for `window_features`.
    seed : int
        Of the channel that each kernel looks at.

    Returns
    -------
    ndarray, shape (W, N, D), float32
        Shares of the samples, between 0 and 1.
    """
    wanted = kernels(windows.shape[2], seed)
    width = sum(len(of_dilation) for of_dilation in wanted.values())
    features = np.empty((len(windows), windows.shape[1], width), dtype=np.float32)
    for window, row in zip(windows, features, strict=True):
        channels = channels_of(window.transpose(1, 2, 0))
        channels -= channels.mean(axis=0)
        row[:] = np.concatenate([_shares(channels, *one) for one in wanted.items()]).T
    return features


def _shares(channels: np.ndarray, dilation: int, of_dilation: tuple[Kernel, ...]) -> np.ndarray:
    """Shares (kernels, N) of the samples of (samples, 8, N) above each kernel's threshold."""
    samples, n_channels, n_sensors = channels.shape
    reach = TAPS // 2 * dilation
    padded = np.zeros((n_channels, samples + 2 * reach, n_sensors), dtype=np.float32)
    padded[:, reach : reach + samples] = channels.swapaxes(0, 1)
    taps = [padded[:, tap * dilation : tap * dilation + samples] for tap in range(TAPS)]
    third = sum(taps) / 3  # the raised taps count 3, all together -1
    deviation = np.sqrt((channels**2).mean(axis=0) + FLOOR**2) / 3
    shares = np.empty((len(of_dilation), n_sensors), dtype=np.float32)
    output = np.empty((samples, n_sensors), dtype=np.float32)
    for share, (raised, channel, pad, threshold) in zip(shares, of_dilation, strict=True):
        first, second, last = (taps[tap][channel] for tap in raised)
        np.add(first, second, out=output)
        np.add(output, last, out=output)
        np.subtract(output, third[channel], out=output)
        seen = output if pad else output[reach : samples - reach]
        above = seen > threshold * deviation[channel]
        np.divide(above.sum(axis=0, dtype=np.min_scalar_type(samples)), len(seen), out=share)
    return shares
