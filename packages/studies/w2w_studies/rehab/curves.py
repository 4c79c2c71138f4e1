# SPDX-License-Identifier: GPL-3.0-or-later
"""Smooth curves over time that the generated exercises are made of: strokes, glides, sway."""

import numpy as np
from scipy.special import ndtr

SWAY_BAND = (0.15, 2.0)
"""Band of the sway, Hz: quiet-stance sway has nearly all its power below 2 Hz (Winter 1995,
doi:10.1016/0966-6362(96)82849-9)."""

_SWAY_TONES = 24


def min_jerk(phase: np.ndarray) -> np.ndarray:
    """Minimum-jerk stroke from 0 to 1 (Flash and Hogan 1985, doi:10.1523/JNEUROSCI.05-07-01688.1985).

    `phase`: 0 at the start and 1 at the end of the stroke; clipped outside.
    The result is twice continuously differentiable: speed and acceleration vanish at both ends.
    """
    s = np.clip(phase, 0.0, 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s**2)


def stroke(time: np.ndarray, start: float, end: float) -> np.ndarray:
    """0 before `start`, 1 after `end`, minimum jerk between; seconds."""
    return min_jerk((time - start) / (end - start))


def pulse(time: np.ndarray, rise: float, top: float, fall: float, end: float) -> np.ndarray:
    """0 before `rise`, 1 from `top` to `fall`, 0 again after `end`; all in seconds."""
    return stroke(time, rise, top) - stroke(time, fall, end)


def through(time: np.ndarray, knots: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Minimum-jerk strokes from knot to knot, at rest in each.

    `time` (T,).
    `knots` (K,): increasing times, seconds.
    `values` (K,): value at each knot; held before the first and after the last.
    """
    curve = np.full(len(time), float(values[0]))
    for start, end, step in zip(knots[:-1], knots[1:], np.diff(values), strict=True):
        curve += step * stroke(time, start, end)
    return curve


def glide(time: np.ndarray, knots: np.ndarray, values: np.ndarray, blur: float) -> np.ndarray:
    """Straight lines from knot to knot, rounded off by a Gaussian: passing by without a stop.

    `blur`: standard deviation of the Gaussian, seconds.
    Returns (T,): the convolution in closed form, so derivatives of every order exist.
    """
    knots, values = np.asarray(knots, dtype=float), np.asarray(values, dtype=float)
    bends = np.diff(np.diff(values) / np.diff(knots), prepend=0.0, append=0.0)
    late = (time[:, None] - knots) / blur
    ramps = blur * (late * ndtr(late) + np.exp(-0.5 * late**2) / np.sqrt(2.0 * np.pi))
    return values[0] + ramps @ bends


def sway(time: np.ndarray, rng: np.random.Generator, channels: int) -> np.ndarray:
    """Band-limited noise of unit variance, as a sum of tones.

    Displacement power falls with the square of frequency, as the sway of people does.

    `time` (T,): seconds.
    `channels`: how many independent curves.
    Returns (T, channels): nothing outside `SWAY_BAND`; derivatives of every order.
    """
    low, high = np.log(SWAY_BAND)
    edges = np.linspace(low, high, _SWAY_TONES + 1)
    tones = np.exp(edges[:-1] + (edges[1] - edges[0]) * rng.random((channels, _SWAY_TONES)))
    # tones are spaced evenly in log f, so a power density of f^-2 is a tone power of f^-1
    amplitudes = tones**-0.5
    amplitudes *= np.sqrt(2.0 / (amplitudes**2).sum(axis=1, keepdims=True))
    phases = rng.uniform(0.0, 2.0 * np.pi, tones.shape)
    return np.einsum("ck,tck->tc", amplitudes, np.sin(2 * np.pi * tones * time[:, None, None] + phases))


def soft_excess(value: np.ndarray, band: float) -> np.ndarray:
    """max(value, 0) with its corner rounded over ``-band < value < band``; three derivatives.

    The running integral of `min_jerk`, so it is exact outside the band.
    """
    s = np.clip((value + band) / (2.0 * band), 0.0, 1.0)
    rounded = 2.0 * band * s**4 * (2.5 - 3.0 * s + s**2)
    return np.where(value >= band, value, rounded)


def soft_limit(value: np.ndarray, limit: np.ndarray | float, band: float) -> np.ndarray:
    """min(value, limit) with its corner rounded over a band; never more than `limit`."""
    return value - soft_excess(value - limit, band)
