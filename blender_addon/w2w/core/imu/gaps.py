# SPDX-License-Identifier: GPL-3.0-or-later
"""Missing and repeated frames of a clip, bridged by splines through the frames around them."""

import numpy as np
import scipy

from ..rotations import unroll

REPEAT_LIMIT_S = 0.1
"""A pose held for longer than this is rest; a shorter hold between movements is a frame written twice."""


def bridge(
    positions: np.ndarray, quaternions: np.ndarray, rate: float, max_gap_s: float, first_sensor: int = 0
) -> None:
    """Fill missing and repeated frames of positions (3, T, N) and quaternions (4, T, N), float64, in place.

    Missing frames hold NaN. Repeated ones equal the frame before to the last bit, for no longer than
    `REPEAT_LIMIT_S` between frames that differ: a converter's way to change the frame rate, or animation
    "on twos". Left alone they would be read as sudden stops.

    Raises ValueError if a gap is longer than `max_gap_s`, or stands at the beginning or end of the clip; the
    message counts sensors from `first_sensor`.
    """
    doubtful = _repeats(positions, quaternions, rate)
    if not np.isfinite(positions.sum() + quaternions.sum()):
        lost = ~(np.isfinite(positions).all(axis=0) & np.isfinite(quaternions).all(axis=0))
        _refuse_long_gaps(lost, rate, max_gap_s, first_sensor)
        doubtful |= lost
    affected = np.flatnonzero(doubtful.any(axis=0))
    if len(affected) == 0:
        return
    patterns, member = np.unique(doubtful[:, affected], axis=1, return_inverse=True)
    for number, pattern in enumerate(patterns.T):
        sensors = affected[member.ravel() == number]
        given, wanted = np.flatnonzero(~pattern), np.flatnonzero(pattern)
        for values in (positions, quaternions):
            known = values[:, given[:, None], sensors]
            if values is quaternions:
                unroll(known)
            values[:, wanted[:, None], sensors] = scipy.interpolate.CubicSpline(given, known, axis=1)(wanted)
    unroll(quaternions)


def _repeats(positions: np.ndarray, quaternions: np.ndarray, rate: float) -> np.ndarray:
    """Frames equal to the one before, in short runs between movement; shape (T, N), bool."""
    repeated = np.zeros(positions.shape[1:], dtype=bool)
    repeated[1:] = True
    for component in (*positions, *quaternions):
        repeated[1:] &= component[1:] == component[:-1]
        if not repeated.any():
            return repeated  # as in most clips, after the first component
    for sensor in np.flatnonzero(repeated.any(axis=0)):
        for start, stop in runs(repeated[:, sensor]):
            if stop - start > REPEAT_LIMIT_S * rate or start == 1 or stop == len(repeated):
                repeated[start:stop, sensor] = False
    return repeated


def runs(flags: np.ndarray) -> np.ndarray:
    """Start and stop of every run of true values, shape (runs, 2)."""
    edges = np.diff(np.concatenate([[0], flags.astype(np.int8), [0]]))
    return np.stack([np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)], axis=1)


def _refuse_long_gaps(lost: np.ndarray, rate: float, max_gap_s: float, first_sensor: int) -> None:
    for sensor in np.flatnonzero(lost.any(axis=0)):
        for start, stop in runs(lost[:, sensor]):
            span = f"{start / rate:.2f} s to {stop / rate:.2f} s"
            where = f"sensor {first_sensor + sensor} has no pose from {span}"
            if start == 0 or stop == len(lost):
                raise ValueError(f"{where}, at the clip's edge: cut the clip to where it has poses")
            if (stop - start) / rate > max_gap_s:
                raise ValueError(f"{where}, longer than max_gap_s = {max_gap_s:g}: cut the clip there")
