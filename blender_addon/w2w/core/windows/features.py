# SPDX-License-Identifier: GPL-3.0-or-later
"""Statistics and spectra of windows: what the feature-based classifiers see."""

from collections.abc import Sequence
from functools import lru_cache, reduce

import numpy as np
from scipy.spatial.transform import Rotation

from ..blas import multiply
from ..imu.recording import ImuRecording
from ..threads import unthreaded_products
from .windows import WindowSpec, cut_at_windows

BAND_EDGES_HZ = np.array([0.3, 0.8, 1.3, 1.8, 2.4, 3.2, 4.2, 5.5, 7.5, 10.0, 15.0, 25.0])
"""Edges of the spectral bands; the bands that a rate and a length cannot resolve stay out."""

UNIT = np.array([4.0] * 3 + [1.0] * 3 + [4.0, 1.0], dtype=np.float32)
"""A middling signal in each channel, m/s2 and rad/s, so that features are of order one."""

EARTH_UT = 50.0
"""A middling magnetic field, uT."""

PA_PER_M = 12.0
"""Pressure lost with each metre near the sea."""

MOST_IN_EIGHTS = 128
"""Most numbers that NumPy's pairwise summation adds up in eight running sums, before it halves them."""

FLOOR = np.float32(0.0025)
"""Smallest distinguished amplitude, in units: about a good sensor's noise. Logarithms start there."""

CHANNELS = ("acc x", "acc y", "acc z", "gyr x", "gyr y", "gyr z", "|acc|", "|gyr|")


STATISTICS = ("mean", "std", "lowest", "highest", "skewness", "kurtosis", "slope", "crossings")


def feature_names(samples: int, rate: float) -> list[str]:
    """Name of each of the D features of windows of `samples` at `rate` Hz, such as "acc x mean"."""
    bands = _band_power(samples, rate).bands
    kinds = [*STATISTICS, *(f"log power {low:g}-{high:g} Hz" for low, high in bands)]
    pairs = zip(*np.triu_indices(6, 1), strict=True)
    return [f"{channel} {kind}" for kind in kinds for channel in CHANNELS] + [
        f"{CHANNELS[a]} * {CHANNELS[b]}" for a, b in pairs
    ]


def window_features(windows: np.ndarray, rate: float) -> np.ndarray:
    """Describe each window of each sensor by numbers that do not depend on the threads.

    Parameters
    ----------
    windows : ndarray, shape (W, N, samples, 6)
        Specific force (m/s2), angular velocity (rad/s). Fastest as `cut_windows`
        returns it, a view into a recording that lies sample by sample and channel by channel.
    rate : float
        Samples per second.

    Returns
    -------
    ndarray, shape (W, N, D), float32
        For the six channels and the two magnitudes, in UNIT: mean and extremes about it
        (inverse hyperbolic sine), std (logarithm of the standard deviation), skewness,
        kurtosis (its logarithm), slope (logarithm of the mean absolute
        derivative, per 0.1 s), crossings of the mean (logarithm of their rate), log power
        by band; then the correlations between channels. Constants make all of order one,
        so that no statistic of the library is needed to scale them.
    """
    samples, n_sensors = windows.shape[2], windows.shape[1]
    spectrum = _band_power(samples, rate)
    features = np.empty((len(windows), n_sensors, len(feature_names(samples, rate))), dtype=np.float32)
    with unthreaded_products():
        for window, row in zip(windows, features, strict=True):
            row[:] = _describe(window.transpose(1, 2, 0), spectrum)
    return features


class _BandPower:
    """Log power by frequency band, as one matrix product with a Hann-windowed Fourier basis."""

    def __init__(self, samples: int, rate: float) -> None:
        self.rate = rate
        frequencies = np.arange(1, samples // 2 + 1) * rate / samples
        band = np.searchsorted(BAND_EDGES_HZ, frequencies, side="right") - 1
        used = (band >= 0) & (band < len(BAND_EDGES_HZ) - 1)
        phase = 2 * np.pi * np.outer(frequencies[used] / rate, np.arange(samples))
        taper = np.hanning(samples + 1)[:-1]
        taper *= np.sqrt(2 / (samples * (taper**2).sum()))
        self.basis = (np.concatenate([np.cos(phase), np.sin(phase)]) * taper).astype(np.float32)
        present, self.start = np.unique(band[used], return_index=True)
        self.bands = [(BAND_EDGES_HZ[b], BAND_EDGES_HZ[b + 1]) for b in present]

    def __call__(self, centred: np.ndarray) -> np.ndarray:
        """(samples, M) -> (bands, M) mean square in each band."""
        squares = multiply(self.basis, centred)
        squares *= squares
        power = squares[: len(squares) // 2]
        power += squares[len(power) :]
        return np.stack([sum_rows(rows) for rows in np.split(power, self.start[1:])])


def sum_rows(rows: np.ndarray) -> np.ndarray:
    """Sum of rows (n, M), rounded as `np.add.reduceat` rounds it, which takes three times as long."""
    return rows[0] + _pairwise(rows[1:]) if len(rows) > 1 else rows[0]


def _pairwise(rows: np.ndarray) -> np.ndarray:
    """Sum of rows in the order of NumPy's pairwise summation."""
    if len(rows) > MOST_IN_EIGHTS:
        half = len(rows) // 16 * 8
        return _pairwise(rows[:half]) + _pairwise(rows[half:])
    whole = len(rows) // 8 * 8
    total = np.add.reduce(rows[:whole].reshape(-1, 8, rows.shape[1]), axis=0) if whole else rows[:1]
    while len(total) > 1:
        total = total[::2] + total[1::2]
    return reduce(np.add, rows[max(whole, 1) :], total[0])


_band_power = lru_cache(maxsize=8)(_BandPower)


def _describe(slab: np.ndarray, spectrum: _BandPower) -> np.ndarray:
    """(samples, 6, N) -> (N, D)."""
    samples, _, n_sensors = slab.shape
    channels = np.empty((samples, 8, n_sensors), dtype=np.float32)  # the six and two magnitudes, in UNIT
    channels[:, :6] = slab
    for magnitude, axes in ((6, channels[:, 0:3]), (7, channels[:, 3:6])):
        np.sqrt(np.einsum("tan,tan->tn", axes, axes), out=channels[:, magnitude])
    channels /= UNIT[:, None]

    mean = channels.mean(axis=0)
    lowest, highest = channels.min(axis=0) - mean, channels.max(axis=0) - mean
    steps = channels[1:] - channels[:-1]
    slope = np.abs(steps, out=steps).mean(axis=0)
    channels -= mean
    square = channels**2
    deviation = np.sqrt(square.mean(axis=0) + FLOOR**2)
    skewness = _mean_product(square, channels) / deviation**3
    kurtosis = _mean_product(square, square) / deviation**4
    above = channels > 0
    crossings = (above[1:] != above[:-1]).mean(axis=0, dtype=np.float32)
    power = spectrum(channels.reshape(samples, -1)).reshape(-1, 8, n_sensors)
    first, second = np.triu_indices(6, 1)
    products = [_mean_product(channels[:, a], channels[:, a + 1 : 6]) for a in range(5)]
    correlations = np.concatenate(products) / (deviation[first] * deviation[second])

    columns = [
        np.arcsinh(mean),
        np.log(deviation) / 1.5,
        np.arcsinh(lowest),
        np.arcsinh(highest),
        np.arcsinh(skewness),
        2 * np.log1p(kurtosis) - 3,
        np.log(slope * (spectrum.rate / 10) + FLOOR) / 1.5,
        np.log1p(crossings * spectrum.rate / 4) - 1,
        *(np.log(power + FLOOR**2) / 2.5 + 2),
        2 * correlations,
    ]
    return np.concatenate(columns).T


def _mean_product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Mean over samples of the product of channels (samples, ..., N), in one pass over both."""
    return np.einsum("t...n,t...n->...n", a, b) / np.float32(len(a))


def further_features(recording: ImuRecording, spec: WindowSpec, names: Sequence[str]) -> np.ndarray:
    """Describe each window of each sensor by the further readings recorded, those of `names`.

    None depends on the direction of north or on the weather: these distinguish clips, not activities.

    Returns
    -------
    ndarray, shape (W, N, D), float32
        For each channel: mean, extremes about it, logarithms of the standard deviation and of the mean
        absolute derivative. Orientation has six channels, what points up in the sensor's frame and the turn
        since the window's middle (rad); the magnetometer four, the field and its magnitude (50 uT); the
        barometer one, the height about the window's mean (m), without a mean.
    """
    blocks = []
    for name in names:
        windows = cut_at_windows(recording.further[name], recording, spec)
        rows = [_statistics(_further_channels(window, name), recording.rate, name) for window in windows]
        blocks.append(np.stack(rows))
    return np.concatenate(blocks, axis=2)


def _statistics(channels: np.ndarray, rate: float, name: str) -> np.ndarray:
    """(N, k, samples) -> (N, D)."""
    mean = channels.mean(axis=2)
    centred = channels - mean[..., None]
    slope = np.abs(np.diff(channels, axis=2)).mean(axis=2) * (rate / 10)
    columns = [
        np.log(centred.std(axis=2) + FLOOR) / 1.5,
        np.arcsinh(centred.min(axis=2)),
        np.arcsinh(centred.max(axis=2)),
        np.log(slope + FLOOR) / 1.5,
    ]
    if name != "barometer":  # whose mean is zero
        columns.insert(0, np.arcsinh(mean))
    return np.concatenate(columns, axis=1).astype(np.float32)


def _further_channels(window: np.ndarray, name: str) -> np.ndarray:
    """Readings (N, channels, samples) as channels of order one, (N, k, samples)."""
    if name == "magnetometer":
        length = np.linalg.norm(window, axis=1, keepdims=True)
        return np.concatenate([window, length], axis=1) / EARTH_UT
    if name == "barometer":
        pressure = window.astype(np.float64)
        return (pressure.mean(axis=2, keepdims=True) - pressure) / PA_PER_M
    n_sensors, _, samples = window.shape
    turned = Rotation.from_quat(window[:, [1, 2, 3, 0]].transpose(0, 2, 1).reshape(-1, 4))
    up = turned.inv().apply([0.0, 0.0, 1.0])
    middle = np.repeat(np.arange(n_sensors) * samples + samples // 2, samples)
    turn = (turned[middle].inv() * turned).as_rotvec()
    return np.concatenate([up, turn], axis=1).reshape(n_sensors, samples, 6).transpose(0, 2, 1)
