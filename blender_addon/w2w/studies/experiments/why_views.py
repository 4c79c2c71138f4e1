# SPDX-License-Identifier: GPL-3.0-or-later
"""What `why_truth` takes from signals, and how fast it calls a movement."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from w2w.core.imu.recording import ImuRecording

from ..validation.calibrated_transfer import limited
from ..validation.site_transfer import magnitudes

SLOWEST_HZ, FASTEST_HZ = 0.2, 3.0
"""Tempo is the root mean square frequency of specific force in this band."""


def tempo(recordings: Sequence[ImuRecording]) -> dict[str, float]:
    """Median over clips of the root mean square frequency of specific force, by activity."""
    found: dict[str, list[float]] = {}
    for recording in recordings:
        acc = filled(recording.acc)
        acc = (acc - acc.mean(axis=0)) * np.hanning(len(acc))[:, None, None]
        n = max(len(acc), round(4 * recording.rate))
        hertz = np.fft.rfftfreq(n, 1 / recording.rate)
        band = (hertz >= SLOWEST_HZ) & (hertz <= FASTEST_HZ)
        power = np.square(np.abs(np.fft.rfft(acc, n, axis=0)[band])).sum(axis=(1, 2))
        if power.sum() > 0:
            mean = np.sqrt((np.square(hertz[band]) * power).sum() / power.sum())
            found.setdefault(recording.activity, []).append(float(mean))
    return {name: float(np.median(values)) for name, values in found.items()}


def filled(acc: np.ndarray) -> np.ndarray:
    """Signals (T, N, 3) whose lost samples are bridged by straight lines, however many there are."""
    out = acc.reshape(len(acc), -1).astype(np.float64)
    for column in out.T:
        lost_here = np.isnan(column)
        if lost_here.all():
            column[:] = 0.0
        elif lost_here.any():
            column[lost_here] = np.interp(
                np.flatnonzero(lost_here), np.flatnonzero(~lost_here), column[~lost_here]
            )
    return out.reshape(acc.shape)


def below(recording: ImuRecording, hertz: float) -> ImuRecording:
    """A recording below a frequency; what is lost stays lost."""
    smooth = limited(replace(recording, acc=filled(recording.acc), gyr=filled(recording.gyr)), hertz)
    acc, gyr = (
        np.where(np.isnan(before), np.nan, after).astype(np.float32)
        for before, after in ((recording.acc, smooth.acc), (recording.gyr, smooth.gyr))
    )
    return replace(recording, acc=acc, gyr=gyr)


def without_posture(signals: np.ndarray) -> np.ndarray:
    """Windows (W, N, samples, 6) less their mean specific force."""
    out = signals.copy()
    out[..., :3] -= out[..., :3].mean(axis=-2, keepdims=True)
    return out


VIEWS: dict[str, Callable[[np.ndarray], np.ndarray] | None] = {
    "": None, "band": None, "posture": without_posture, "magnitudes": magnitudes,
    "low magnitudes": magnitudes,
}  # fmt: skip
"""What is made of windows; the band is taken from whole recordings."""
