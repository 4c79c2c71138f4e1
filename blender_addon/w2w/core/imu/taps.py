# SPDX-License-Identifier: GPL-3.0-or-later
"""Triple taps on a sensor at rest, by which its wearer marks where an activity starts and ends."""

import numpy as np
import scipy

from .recording import ImuRecording

SPIKE, REST = 3.0, 0.5
"""How far specific force goes from its median in a tap, and how little 19 of 20 samples around do, m/s2."""

APART_S = 0.15, 0.9
"""Seconds from one tap to the next."""

STILL_S, HAND_S, TAP_S = 1.0, 0.5, 0.1
"""Seconds of rest before and after three taps, those in which a hand comes or goes, and each tap's own."""

SLOWEST_HZ = 40.0
"""At fewer samples per second a tap may lie between two."""


def triple_taps(recording: ImuRecording) -> list[tuple[float, float]]:
    """From when to when each three taps on the first sensor take a hand, s.

    None were found in 52 hours of eight data sets' sensors worn in daily life, sports and falls.
    """
    rate, acc = recording.rate, recording.acc[:, 0].astype(float)
    if rate < SLOWEST_HZ:
        return []
    size = np.nan_to_num(np.linalg.norm(acc, axis=1), nan=np.nanmedian(np.linalg.norm(acc, axis=1)))
    far = np.abs(size - scipy.ndimage.median_filter(size, round(rate / 4) | 1))
    peaks = scipy.signal.find_peaks(far, SPIKE, distance=max(round(TAP_S * rate), 1))[0]
    times, at = np.arange(len(size)) / rate, peaks / rate
    gaps = np.diff(at, prepend=-np.inf, append=np.inf)
    found = []
    for first in range(len(at) - 2):
        before, *between, after = gaps[first : first + 4]
        if min(before, after) < STILL_S or not all(APART_S[0] <= gap <= APART_S[1] for gap in between):
            continue
        three = at[first : first + 3]
        around = (times >= three[0] - STILL_S) & (times < three[2] + STILL_S)
        still = size[around & (np.abs(times[:, None] - three).min(axis=1) > TAP_S)]
        if np.quantile(np.abs(still - np.median(still)), 0.95) <= REST:
            found.append((float(three[0]) - HAND_S, float(three[2]) + HAND_S))
    return found
