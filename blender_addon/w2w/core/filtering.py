# SPDX-License-Identifier: GPL-3.0-or-later
"""Low-pass filters and resampling along the last axis of regularly sampled signals."""

from fractions import Fraction
from functools import lru_cache

import numpy as np
import scipy


def butterworth(
    values: np.ndarray, rate: float, cutoff_hz: float, order: int = 2, zero_phase: bool = False
) -> np.ndarray:
    """Butterworth low-pass along the last axis; the result has the dtype of `values`.

    The gain of the whole operation is -3 dB at `cutoff_hz`, below half the rate (samples per second). Run
    forwards and backwards (`zero_phase`) instead of causally, the roll-off is that of twice the order, and
    the cut-off is corrected for the second pass (Winter 2009, Biomechanics and Motor Control of Human
    Movement, 2.2.4.4).

    Raises ValueError if the cut-off is not between 0 and half the rate.
    """
    if not 0 < cutoff_hz < rate / 2:
        raise ValueError(
            f"the cut-off must lie between 0 and {rate / 2:g} Hz (half the rate), not {cutoff_hz}"
        )
    if not zero_phase:
        sos, at_rest = (part.astype(values.dtype) for part in _sections(order, cutoff_hz, rate))
        state = at_rest.reshape(len(sos), *(1,) * (values.ndim - 1), 2) * values[None, ..., :1]
        return scipy.signal.sosfilt(sos, values, axis=-1, zi=state)[0]
    # The bilinear transform bends the frequency axis, so the correction is made on its tangent.
    bent = np.tan(np.pi * cutoff_hz / rate) / (np.sqrt(2) - 1) ** (1 / (2 * order))
    sos, _ = _sections(order, np.arctan(bent) * rate / np.pi, rate)
    padding = min(int(3 * rate / cutoff_hz), values.shape[-1] - 1)
    return scipy.signal.sosfiltfilt(sos, values, axis=-1, padlen=padding).astype(values.dtype, copy=False)


@lru_cache(maxsize=32)
def _sections(order: int, cutoff_hz: float, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Second-order sections and their state at rest."""
    sos = scipy.signal.butter(order, cutoff_hz, fs=rate, output="sos")
    return sos, scipy.signal.sosfilt_zi(sos)


def resample(values: np.ndarray, rate: float, new_rate: float) -> np.ndarray:
    """Resample along the last axis with a linear-phase anti-aliasing filter; rates are in samples per second.

    From the first sample to the last, both included if they meet.
    """
    if rate == new_rate:
        return values
    ratio = Fraction(new_rate / rate).limit_denominator(1000)
    if abs(float(ratio) * rate / new_rate - 1) > 1e-6:
        raise ValueError(
            f"cannot resample from {rate:g} to {new_rate:g} Hz: their ratio is no small fraction"
        )
    new = scipy.signal.resample_poly(values, ratio.numerator, ratio.denominator, axis=-1, padtype="edge")
    return new[..., : count_resampled(values.shape[-1], rate, new_rate)].astype(values.dtype, copy=False)


def sampled(values: np.ndarray, rate: float, new_rate: float) -> np.ndarray:
    """Values along the last axis at a new rate, unfiltered: what lies above half of it folds back."""
    if rate == new_rate:
        return values
    at = np.arange(count_resampled(values.shape[-1], rate, new_rate)) * (rate / new_rate)
    before = np.minimum((at + 1e-6).astype(int), values.shape[-1] - 1)
    share = np.maximum(at - before, 0).astype(values.dtype)
    after = values[..., np.minimum(before + 1, values.shape[-1] - 1)]
    return values[..., before] + share * (after - values[..., before])


def count_resampled(n_samples: int, rate: float, new_rate: float) -> int:
    """Samples at the new rate from the first to the last at the old, both included if they meet."""
    return int(np.floor((n_samples - 1) * new_rate / rate + 1e-6)) + 1
