# SPDX-License-Identifier: GPL-3.0-or-later
"""The single errors of an inertial sensor, as functions on signals of shape (sensors, axes, samples)."""

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache
from typing import Any, cast

import numpy as np
import scipy
from numpy.random.bit_generator import ISeedSequence
from scipy.spatial.transform import Rotation

from ..rotations import skew_matrix

DRIFT_STEP_S = 0.1
"""Biases drift slowly: they are drawn ten times a second at any rate, and joined by straight lines."""

FLICKER_FLOOR = np.sqrt(2 * np.log(2) / np.pi)
"""Allan deviation of flicker noise over its bias instability coefficient, .664 (IEEE Std 952-1997, C.1.3)."""

GAUSS_MARKOV_PEAK = 0.6174
"""Highest Allan deviation of a first-order Gauss-Markov process over its standard deviation, reached at
1.89 correlation times (IEEE Std 952-1997, C.1.5)."""

PARTS = ("constants", "acc drift", "gyr drift", "acc noise", "gyr noise", "jitter", "drops")
"""Parts of the errors, each with its own stream, so that switching one off leaves the others as they were."""

CONSTANTS = {
    "mounting": slice(0, 6),
    "g-sensitivity": slice(6, 15),
    "acc axes": slice(15, 24),
    "gyr axes": slice(24, 33),
    "acc bias": slice(33, 36),
    "gyr bias": slice(36, 39),
}
"""Places of a sensor's constant errors among the numbers of the stream "constants"."""

ALL_CLIPS = "\0all clips"
"""The clip's name in draws that are the same in all clips; no clip is called that."""

SFC64_WORDS = 3
"""64-bit words that seed an SFC64 generator."""

PHILOX_WORDS = 4
"""64-bit words that a Philox generator gives in one step of its counter."""


class _Words(ISeedSequence):
    """Seeds generators, one after another, with rows of words that are already mixed."""

    def __init__(self, words: np.ndarray) -> None:
        self._words = iter(words)

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> np.ndarray:  # noqa: ARG002
        """The next words, for a generator that wants just these."""
        assert n_words == SFC64_WORDS
        return next(self._words)


class SensorStreams:
    """Random numbers of sensors: one stream per sensor and part, in any order of the calls."""

    def __init__(self, seed: int, clip: str, sensors: Sequence[int]) -> None:
        self.seed, self.clip, self.sensors = seed, clip, sensors
        digest = hashlib.sha256(clip.encode("utf-8")).digest()
        entropy = [seed, *np.frombuffer(digest[:16], dtype="<u4").tolist()]
        # Philox counts, so the seeds of any range of sensors come in one call (Salmon et al. 2011,
        # doi:10.1145/2063384.2063405); each sensor takes whole steps of the counter
        key = np.random.SeedSequence(entropy).generate_state(2, np.uint64)
        steps = -(-len(PARTS) * SFC64_WORDS // PHILOX_WORDS)
        width, first = PHILOX_WORDS * steps, min(sensors)
        counter = np.random.Philox(key=key, counter=steps * first)
        words = counter.random_raw(width * (max(sensors) - first + 1)).reshape(-1, width)
        words = words[np.subtract(sensors, first)]
        self._states = words[:, : len(PARTS) * SFC64_WORDS].reshape(-1, len(PARTS), SFC64_WORDS)
        self._constants = self.normal("constants", 39)

    def of_clip(self, clip: str) -> "SensorStreams":
        """The streams of the same sensors in another clip."""
        return SensorStreams(self.seed, clip, self.sensors)

    def generators(self, part: str) -> list[np.random.Generator]:
        """One generator a sensor for one of `PARTS`."""
        return [np.random.Generator(bits) for bits in self._bits(part)]

    def normal(self, part: str, *shape: int) -> np.ndarray:
        """Standard normal numbers, shape (sensors, *shape), float32."""
        count = math.prod(shape)
        words = np.array([bits.random_raw(-(-count // 2)) for bits in self._bits(part)])
        return _normal(words)[:, :count].reshape(-1, *shape)

    def constants(self, name: str, *shape: int) -> np.ndarray:
        """Numbers behind one of the `CONSTANTS`, shape (sensors, *shape)."""
        return self._constants[:, CONSTANTS[name]].reshape(len(self._states), *shape)

    def _bits(self, part: str) -> list[np.random.SFC64]:
        words = cast(Any, _Words(self._states[:, PARTS.index(part)]))
        return [np.random.SFC64(words) for _ in self.sensors]


def _normal(words: np.ndarray) -> np.ndarray:
    """Two standard normal numbers of each 64 random bits, (n, W) -> (n, 2 W), float32.

    By whole arrays this is four times as fast as rejection, number by number (Box and Muller 1958,
    doi:10.1214/aoms/1177706645). 32 bits of radius reach 6.6 standard deviations.
    """
    halves = words.view(np.int32).reshape(len(words), 2, -1)
    chance, angle = np.array(halves.swapaxes(0, 1), dtype=np.float32, order="C")
    np.abs(chance, out=chance)
    chance += np.float32(0.5)
    chance *= np.float32(2.0**-31)
    radius = np.sqrt(np.log(chance, out=chance) * np.float32(-2), out=chance)
    angle *= np.float32(np.pi * 2.0**-31)
    numbers = np.empty(halves.shape, dtype=np.float32)
    np.multiply(np.cos(angle), radius, out=numbers[:, 0])
    np.multiply(np.sin(angle, out=angle), radius, out=numbers[:, 1])
    return numbers.reshape(len(words), -1)


def mount(
    acc: np.ndarray, gyr: np.ndarray, rate: float, turns: np.ndarray, shifts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Move rigidly attached sensors: the lever arm's acceleration, then the turn of the axes.

    Signals are (n, 3, T), float32. `turns` (n, 3), rad, are rotation vectors from the moved frame to the
    nominal one; `shifts` (n, 3), m, are the places of the moved sensors in the nominal frame.
    """
    if shifts.any():
        lever = shifts[:, :, None].astype(gyr.dtype)
        spin_up = (
            np.gradient(gyr, 1 / rate, axis=-1, edge_order=2) if gyr.shape[-1] > 2 else np.zeros_like(gyr)
        )
        # w' x l + w x (w x l) = -l x w' + w (w l) - l w^2
        acc = acc - skew_matrix(shifts).astype(gyr.dtype) @ spin_up
        acc += gyr * (lever.transpose(0, 2, 1) @ gyr)
        acc -= lever * np.einsum("nat,nat->nt", gyr, gyr)[:, None]
    back = Rotation.from_rotvec(turns).inv().as_matrix().astype(acc.dtype)
    return back @ acc, back @ gyr


def soft_tissue_artefact(
    values: np.ndarray, rate: float, frequency_hz: float, damping: float, gain: float
) -> np.ndarray:
    """Soft-tissue artefact: a sensor rides on a spring and damper, a second-order system moved at its base.

    The transmissibility (2 z w s + w^2) / (s^2 + 2 z w s + w^2) is mixed in with weight `gain`.
    """
    b, a, at_rest = (part.astype(values.dtype) for part in _tissue(rate, frequency_hz, damping))
    ridden = scipy.signal.lfilter(b, a, values, axis=-1, zi=at_rest * values[..., :1])[0]
    return values + values.dtype.type(gain) * (ridden - values)


@lru_cache(maxsize=32)
def _tissue(rate: float, frequency_hz: float, damping: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Numerator, denominator and state at rest of the tissue's digital filter."""
    omega = 2 * rate * np.tan(np.pi * frequency_hz / rate)
    b, a = scipy.signal.bilinear([2 * damping * omega, omega**2], [1, 2 * damping * omega, omega**2], fs=rate)
    return b, a, scipy.signal.lfilter_zi(b, a)


def axes_matrix(scale: np.ndarray, turns: np.ndarray, shears: np.ndarray) -> np.ndarray:
    """Matrices (n, 3, 3) of triads with scale errors, a common turn and axes that are not square.

    Relative scale errors, rotation vectors (rad) and the angles (rad) by which y leans towards x, z towards x
    and z towards y, all (n, 3).
    """
    lean = np.tile(np.eye(3), (len(shears), 1, 1))
    lean[:, 1, 0], lean[:, 2, 0], lean[:, 2, 1] = np.sin(shears).T
    turned = Rotation.from_rotvec(turns).inv().as_matrix()
    return (1 + scale)[:, :, None] * (lean @ turned)


def bias_drift(
    numbers: np.ndarray, deviation: float, correlation_s: float, walk_density: float
) -> np.ndarray:
    """A wandering bias (n, 3, K), float64: a first-order Gauss-Markov process plus a random walk from zero.

    `numbers` (n, 2, 3, K) are standard normal, one every `DRIFT_STEP_S`, for the two processes. The
    Gauss-Markov process is in its steady state from the start, with this standard deviation, and after
    `correlation_s` its correlation has fallen to 1/e. The random walk strays as its density times sqrt(time).
    """
    memory = np.exp(-DRIFT_STEP_S / correlation_s)
    driven = numbers[:, 0] * np.float64(deviation)
    driven[..., 1:] *= np.sqrt(1 - memory**2)
    steps = numbers[:, 1] * np.float64(walk_density * np.sqrt(DRIFT_STEP_S))
    steps[..., 0] = 0
    return scipy.signal.lfilter([1.0], [1.0, -memory], driven, axis=-1) + np.cumsum(steps, axis=-1)


def join(knots: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Straight lines between values `DRIFT_STEP_S` apart, at some times; float32."""
    at = times / DRIFT_STEP_S
    left = at.astype(int)
    slopes = np.diff(knots, axis=-1).astype(np.float32)
    joined = slopes[..., left]
    joined *= (at - left).astype(np.float32)
    joined += knots.astype(np.float32)[..., left]
    return joined


def noise_deviation(density: float, rate: float, lowpass_hz: float | None, order: int) -> float:
    """Standard deviation of a sample of white noise.

    Density times the square root of the bandwidth: half the rate or, if the part's own filter is wider
    than that, the noise bandwidth of the filter, all of which folds into the samples.
    """
    bandwidth = rate / 2
    if lowpass_hz is not None and lowpass_hz >= bandwidth:
        bandwidth = lowpass_hz * (np.pi / (2 * order)) / np.sin(np.pi / (2 * order))
    return density * np.sqrt(bandwidth)


def jitter(values: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """Values at instants off by `offsets` sample intervals, shape (n, T), by parabolas through neighbours."""
    if values.shape[-1] < 3:
        return values
    offsets = np.clip(offsets, -0.5, 0.5)[:, None, 1:-1]
    before, here, after = values[..., :-2], values[..., 1:-1], values[..., 2:]
    moved = values.copy()
    # here + d ((after - before) + d (after - 2 here + before)) / 2
    bend = after + before
    bend -= 2 * here
    bend *= offsets
    bend += after
    bend -= before
    bend *= 0.5 * offsets
    moved[..., 1:-1] += bend
    return moved


def quantise(values: np.ndarray, limit: float | None, step: float) -> None:
    """Clip to +-limit and round to whole steps, in place."""
    if limit is not None:
        np.clip(values, -limit, limit, out=values)
    if step:
        values *= values.dtype.type(1 / step)
        np.rint(values, out=values)
        values *= values.dtype.type(step)


def kept_samples(
    generator: np.random.Generator, n_samples: int, fraction: float, mean_length: float
) -> np.ndarray:
    """Which samples arrive, shape (T,), bool; the first always does.

    Losses come in runs of geometric length (Gilbert 1960, doi:10.1002/j.1538-7305.1960.tb03959.x).
    """
    mean_between = mean_length * (1 - fraction) / fraction
    n_runs = int(1.5 * n_samples / (mean_length + mean_between)) + 10
    lengths = np.zeros(0, dtype=int)
    while lengths.sum() < n_samples:
        good = generator.geometric(min(1.0, 1 / mean_between), n_runs)
        bad = generator.geometric(1 / mean_length, n_runs)
        lengths = np.concatenate([lengths, np.stack([good, bad], axis=1).ravel()])
    return np.repeat(np.arange(len(lengths)) % 2 == 0, lengths)[:n_samples]


def lose(values: np.ndarray, kept: np.ndarray, dropped: str) -> None:
    """Hold the last sample that arrived, or write NaN, in place; shape (3, T)."""
    lost = np.flatnonzero(~kept)
    if dropped == "nan":
        values[:, lost] = np.nan
    else:
        arrived = np.flatnonzero(kept)
        values[:, lost] = values[:, arrived[np.searchsorted(arrived, lost) - 1]]
