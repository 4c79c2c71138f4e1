# SPDX-License-Identifier: GPL-3.0-or-later
"""The gain from a calibration, on recordings or people that it was not fitted to."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .calibration import Calibration, Pair, calibrate, shift_between, shifted, smooth
from .recording import ImuRecording


class Alike(NamedTuple):
    """How a simulated recording goes together with the worn one: r over samples and axes at once."""

    force: tuple[float, float]  # of specific force, as simulated and calibrated
    turning: tuple[float, float]  # of angular velocity


def held_out(pairs: Sequence[Pair], longest_shift_s: float = 0.5) -> tuple[str, list[Alike]]:
    """Calibrate without each person in turn, or each recording, or each half of the only one, and test there.

    Returns the kind that was left out, "person", "recording" or "half", and the likeness of each recording or
    half. Raises ValueError as `calibrate` does.
    """
    people = [real.subject for real, _ in pairs]
    if len(pairs) == 1:
        what, pairs = "half", halves(*pairs[0], longest_shift_s)
    else:
        what = "person" if all(people) and len(set(people)) > 1 else "recording"
    groups = people if what == "person" else list(range(len(pairs)))
    found = {}
    for group in dict.fromkeys(groups):
        others = [pair for pair, of in zip(pairs, groups, strict=True) if of != group]
        known = calibrate(others, longest_shift_s)
        for number, (pair, of) in enumerate(zip(pairs, groups, strict=True)):
            if of == group:
                found[number] = alike(*pair, known, longest_shift_s)
    return what, [found[number] for number in sorted(found)]


def halves(real: ImuRecording, made: ImuRecording, longest_shift_s: float) -> list[Pair]:
    """Both halves of a pair, brought together in time."""
    real, made = shifted(real, made, shift_between(real, made, longest_shift_s))
    middle = real.n_samples // 2
    return [
        tuple(replace(one, acc=one.acc[part], gyr=one.gyr[part]) for one in (real, made))
        for part in (slice(0, middle), slice(middle, None))
    ]


def alike(real: ImuRecording, made: ImuRecording, known: Calibration, longest_shift_s: float) -> Alike:
    """Compare a pair before and after a calibration, each shifted to where it fits best."""
    sides = []
    for simulated in (made, known.applied(made)):
        one, other = shifted(real, simulated, shift_between(real, simulated, longest_shift_s))
        signals = ((one.acc, other.acc), (one.gyr, other.gyr))
        sides.append([vector_r(first[:, 0], second[:, 0], one.rate) for first, second in signals])
    before, after = sides
    return Alike(*zip(before, after, strict=True))


def vector_r(first: np.ndarray, second: np.ndarray, rate: float) -> float:
    """Pearson's r of two signals (T, 3), over samples and axes at once, each axis about its own mean."""
    a, b = (smooth(values, rate) for values in (first, second))
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float((a * b).sum() / max(np.sqrt((a * a).sum() * (b * b).sum()), 1e-12))
