# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics and spectra of windows: what the feature-based classifiers see."""

from __future__ import annotations

import numpy as np

BAND_EDGES_HZ = np.array([0.3, 0.8, 1.3, 1.8, 2.4, 3.2, 4.2, 5.5, 7.5, 10.0, 15.0, 25.0])
"""Edges of the spectral bands; the bands that a rate and a length cannot resolve stay out."""

FLOOR = np.array([1e-2] * 3 + [1e-3] * 3 + [1e-2, 1e-3], dtype=np.float32)
"""Smallest amplitude told apart, m/s2 and rad/s, about a good sensor's noise: logarithms start there."""

CHANNELS = ("acc x", "acc y", "acc z", "gyr x", "gyr y", "gyr z", "|acc|", "|gyr|")


def window_features(windows: np.ndarray, rate: float) -> np.ndarray:
    """Describe each window of each sensor by numbers.

    Parameters
    ----------
    windows : ndarray, shape (W, N, samples, 6)
        Specific force (m/s2), angular velocity (rad/s). Fastest as `cut_windows`
        returns it, a view into a time-major recording.
    rate : float
        Samples per second.

    Returns
    -------
    ndarray, shape (W, N, D), float32
        For the six channels and the two magnitudes: mean, standard deviation and its
        logarithm, extremes, skewness, kurtosis, mean absolute slope, rate of crossing
        the mean, log power by band; then the correlations between the channels.
    """
    samples, n_sensors = windows.shape[2], windows.shape[1]
    spectrum = _BandPower(samples, rate)
    rows = [_describe(np.ascontiguousarray(window.transpose(1, 0, 2)), spectrum) for window in windows]
    return np.stack(rows) if rows else np.empty((0, n_sensors, 0), np.float32)


class _BandPower:
    """Log power by frequency band, as one matrix product with a Hann-windowed Fourier basis."""

    def __init__(self, samples: int, rate: float) -> None:
        frequencies = np.arange(1, samples // 2 + 1) * rate / samples
        band = np.searchsorted(BAND_EDGES_HZ, frequencies, side="right") - 1
        used = (band >= 0) & (band < len(BAND_EDGES_HZ) - 1)
        phase = 2 * np.pi * np.outer(frequencies[used] / rate, np.arange(samples))
        taper = np.hanning(samples + 1)[:-1]
        taper /= np.sqrt(samples * (taper**2).sum() / 2)
        self.basis = np.concatenate([np.cos(phase), np.sin(phase)]).astype(np.float32) * taper.astype(
            np.float32
        )
        _, start = np.unique(band[used], return_index=True)
        self.start = start

    def __call__(self, centred: np.ndarray) -> np.ndarray:
        """(samples, M) -> (bands, M) mean square in each band."""
        amplitude = self.basis @ centred
        half = len(amplitude) // 2
        power = amplitude[:half] ** 2 + amplitude[half:] ** 2
        return np.add.reduceat(power, self.start, axis=0)


def _describe(slab: np.ndarray, spectrum: _BandPower) -> np.ndarray:
    """(samples, N, 6) -> (N, D)."""
    samples, n_sensors, _ = slab.shape
    channels = np.empty((samples, 8, n_sensors), dtype=np.float32)
    channels[:, :6] = slab.transpose(0, 2, 1)
    np.sqrt((channels[:, 0:3] ** 2).sum(axis=1), out=channels[:, 6])
    np.sqrt((channels[:, 3:6] ** 2).sum(axis=1), out=channels[:, 7])

    floor = FLOOR[:, None]
    mean = channels.mean(axis=0)
    low, high = channels.min(axis=0) - mean, channels.max(axis=0) - mean
    slope = np.abs(np.diff(channels, axis=0)).mean(axis=0)
    channels -= mean
    square = channels**2
    variance = square.mean(axis=0)
    deviation = np.sqrt(variance + floor**2)
    skewness = (square * channels).mean(axis=0) / deviation**3
    kurtosis = np.log1p((square**2).mean(axis=0) / deviation**4)
    above = channels > 0
    crossings = (above[1:] != above[:-1]).mean(axis=0, dtype=np.float32)
    power = spectrum(channels.reshape(samples, -1)).reshape(-1, 8, n_sensors)

    columns = [
        mean,
        np.log(deviation),
        deviation,
        low,
        high,
        skewness,
        kurtosis,
        np.log(slope + floor),
        crossings,
    ]
    columns += list(np.log(power + floor**2))
    stacked = np.concatenate(columns)
    return np.concatenate([stacked, _correlations(channels[:, :6], deviation[:6])]).T


def _correlations(centred: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Correlations between the six channels: (samples, 6, N), (6, N) -> (15, N)."""
    first, second = np.triu_indices(6, 1)
    pairs = [(centred[:, a] * centred[:, b]).mean(axis=0) for a, b in zip(first, second, strict=True)]
    return np.stack(pairs) / (deviation[first] * deviation[second])
