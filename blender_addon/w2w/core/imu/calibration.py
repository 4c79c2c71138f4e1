# SPDX-License-Identifier: GPL-3.0-or-later
"""How a worn sensor differs from the simulated one: fitted to recordings of both of the same motion.

The fit is a property of the sensor and its site, not of a motion: how it sat, the soft tissue under it, its
noise. Each recording's shift in time is found on the way. The gain is measured on recordings or people that
were left out of the fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ..filtering import butterworth
from .errors import soft_tissue_artefact
from .recording import ImuRecording
from .sensor import SensorModel

ALIGNED_BELOW_HZ = 5.0

Pair = tuple[ImuRecording, ImuRecording]
"""A clip's real and simulated recording of one sensor, of the same rate."""


def mounting(pairs: Sequence[Pair]) -> Rotation:
    """The rotation that turns simulated signals to the real sensor's axes, over all pairs at once."""
    ours, theirs = [], []
    for real, made in pairs:
        n = min(real.n_samples, made.n_samples)
        for name in ("acc", "gyr"):
            worn, own = (smooth(getattr(r, name)[:n, 0], r.rate, ALIGNED_BELOW_HZ) for r in (real, made))
            size = np.sqrt((worn**2).mean()) + 1e-6
            theirs.append(worn / size)
            ours.append(own / size)
    rotation, _ = Rotation.align_vectors(np.concatenate(theirs), np.concatenate(ours))
    return rotation


def turned(recording: ImuRecording, rotation: Rotation) -> ImuRecording:
    """A one-sensor recording in other axes."""
    acc, gyr = (rotation.apply(values[:, 0])[:, None] for values in (recording.acc, recording.gyr))
    return replace(recording, acc=acc, gyr=gyr)


ROUNDS = 2
"""Times that shifts, rotation and tissue are fitted in turn: each needs the others."""

DAMPINGS = (0.1, 0.2, 0.4, 0.8)
STIFFNESSES = 14
SOFTEST_HZ, STIFFEST_HZ = 3.0, 25.0
"""Natural frequencies tried. If the softest fits best, the cause is not tissue: a noisy motion, too, asks
for a weaker signal."""

STIFFEST_OF_RATE = 0.4
"""Highest natural frequency tried, of the sensors' rate; stiffer tissue moves with the bone."""

NEARER = (0.8, 0.87, 0.93, 1.0, 1.07, 1.15, 1.25)
"""Factors by which frequency and damping are then varied around the best of them."""

DELAYS = (0, 1, 2)
"""Samples by which tissue may have delayed the signal: its delay looks like a shift."""

PARTS = 4
"""Parts of the recordings for cross-validation: tissue must help on parts it was not fitted to."""

LEAST_GAIN = 0.01
"""Least share of the squared difference there that tissue must explain."""

BLOCK_S = 2.0
"""Seconds of the blocks that long recordings are dealt in."""

QUIET = 0.1
"""Noise is measured on the quietest tenth of the signal."""
QUIET_SAMPLES = 16
FIT_BELOW_HZ = 15.0
"""Both signals are compared below this."""


class Tissue(NamedTuple):
    """A spring and damper under the sensor, as in `SensorModel`."""

    frequency_hz: float
    damping: float
    gain: float


@dataclass(frozen=True)
class Calibration:
    """The difference between a site's worn sensor and the simulated one."""

    turn: Rotation  # from the axes of the simulated sensor to those of the worn one
    tissue: Tissue | None  # None if it explains nothing
    # white, one-sided, m/s2/sqrt(Hz); an upper bound, since the quietest stretches may move, too
    acc_noise: float
    gyr_noise: float  # the same in rad/s/sqrt(Hz)
    shifts_s: tuple[float, ...]  # how much later each worn recording began to show the motion

    def applied(self, made: ImuRecording) -> ImuRecording:
        """A simulated recording as the worn sensor would have it, without its noise."""
        return turned(ridden(made, self.tissue), self.turn)

    def sensor(self, base: SensorModel, name: str) -> SensorModel:
        """The sensor with what was found: how it sat, its tissue and its noise; the rest as it was."""
        x, y, z = (round(float(angle), 3) for angle in self.turn.inv().as_rotvec(degrees=True))
        hertz, damping, gain = self.tissue or (None, base.soft_tissue_damping, base.soft_tissue_gain)
        return replace(
            base,
            name=name,
            accelerometer=replace(base.accelerometer, noise_density=self.acc_noise),
            gyroscope=replace(base.gyroscope, noise_density=self.gyr_noise),
            worn_turn_deg=(x, y, z),
            mounting_turn_deg=0.0,
            fixed_misalignment_deg=0.0,
            soft_tissue_hz=hertz,
            soft_tissue_damping=damping,
            soft_tissue_gain=gain,
        )


def calibrate(pairs: Sequence[Pair], longest_shift_s: float = 0.5) -> Calibration:
    """Fit a site's sensor to recordings without errors that were simulated of the same motions.

    `pairs` are worn and simulated recordings of one sensor, at one rate, at most `longest_shift_s` apart in
    time. Raises ValueError if a pair is too short, or the worn sensor hardly moves.
    """
    if not pairs:
        raise ValueError("there is nothing to calibrate with: no worn recording has a motion")
    tissue = None
    for _ in range(ROUNDS):
        shown = [(real, ridden(made, tissue)) for real, made in pairs]
        shifts = np.array([shift_between(*pair, longest_shift_s) for pair in shown])
        turn = mounting(_together(shown, shifts))
        plain = [(real, turned(made, turn)) for real, made in pairs]
        fits = {late: fit_tissue(_together(plain, shifts - late)) for late in DELAYS}
        late = min(fits, key=lambda delay: fits[delay][1])
        tissue, _ = fits[late]
        shifts -= late
    rate = pairs[0][0].rate
    acc, gyr = (rest_noise([getattr(real, kind)[:, 0] for real, _ in pairs], rate) for kind in ("acc", "gyr"))
    return Calibration(turn, tissue, acc, gyr, tuple((shifts / rate).tolist()))


def ridden(made: ImuRecording, tissue: Tissue | None) -> ImuRecording:
    """A recording as a sensor on soft tissue has it."""
    if tissue is None:
        return made
    acc, gyr = (
        soft_tissue_artefact(values.transpose(1, 2, 0), made.rate, *tissue).transpose(2, 0, 1)
        for values in (made.acc, made.gyr)
    )
    return replace(made, acc=acc, gyr=gyr)


def shift_between(real: ImuRecording, made: ImuRecording, longest_s: float) -> int:
    """Samples by which the worn recording is later, where turning rates and forces go together best.

    Raises ValueError if they are too short for it.
    """
    n, reach = min(real.n_samples, made.n_samples), round(longest_s * real.rate)
    if n - reach < 2 * real.rate / FIT_BELOW_HZ * 5:
        short = f"{real.clip or 'a recording'} is too short: {n / real.rate:.1f} s"
        raise ValueError(f"{short}, with shifts up to {longest_s:g} s")
    sizes = []
    for recording in (real, made):
        signals = (smooth(values[:n, 0], recording.rate) for values in (recording.acc, recording.gyr))
        lengths = (np.linalg.norm(values, axis=1) for values in signals)
        sizes.append(np.stack([(v - v.mean()) / (v.std() + 1e-9) for v in lengths]))
    a, b = sizes
    lags = np.arange(-reach, reach + 1)
    products = [(a[:, max(0, k) : n + min(0, k)] * b[:, max(0, -k) : n - max(0, k)]).mean() for k in lags]
    return int(lags[int(np.argmax(products))])


def shifted(real: ImuRecording, made: ImuRecording, shift: int) -> Pair:
    """Both recordings, cut to the time that both show."""
    first, second = max(0, shift), max(0, -shift)
    n = min(real.n_samples - first, made.n_samples - second)
    return real.between(first, first + n), made.between(second, second + n)


def _together(pairs: Sequence[Pair], shifts: np.ndarray) -> list[Pair]:
    return [shifted(*pair, shift) for pair, shift in zip(pairs, shifts, strict=True)]


def smooth(values: np.ndarray, rate: float, below_hz: float = FIT_BELOW_HZ) -> np.ndarray:
    """Signals (T, 3) below a frequency, in double precision."""
    if rate / 2 <= below_hz:
        return values.astype(np.float64)
    return butterworth(values.T.astype(np.float64), rate, below_hz, 2, zero_phase=True).T


def fit_tissue(pairs: Sequence[Pair]) -> tuple[Tissue | None, float]:
    """The spring and damper that bring simulated signals nearest to worn ones, and the mean square left.

    Both are in the same axes. None if tissue does not help on parts of the recordings that it was not
    fitted to.
    """
    samples = sum(real.n_samples for real, _ in pairs)
    rate = pairs[0][0].rate
    stiffest = min(STIFFEST_HZ, STIFFEST_OF_RATE * rate)
    sides = _prepared(pairs)
    if stiffest <= SOFTEST_HZ:
        return None, float(np.square(sides[1]).sum()) / samples
    tried = list(product(np.geomspace(SOFTEST_HZ, stiffest, STIFFNESSES), DAMPINGS))
    moments = np.stack([_moments(sides, rate, frequency, damping) for frequency, damping in tried])
    parts = np.arange(moments.shape[1]) * PARTS // moments.shape[1]
    before = after = 0.0
    for part in np.unique(parts):
        number, gain = _best(moments[:, parts != part].sum(axis=1))
        here = moments[number][parts == part].sum(axis=0)
        before += float(here[0])
        after += float(_left(here, gain))
    helps = len(np.unique(parts)) > 1 and after < (1 - LEAST_GAIN) * before
    number, gain = _best(moments.sum(axis=1))
    if not helps or tried[number][0] == SOFTEST_HZ:
        return None, before / samples
    near = np.multiply(tried[number], list(product(NEARER, NEARER)))
    sums = np.stack([_moments(sides, rate, *tissue).sum(axis=0) for tissue in near])
    number, gain = _best(sums)
    frequency, damping, gain = (round(float(value), 3) for value in (*near[number], gain))
    return Tissue(frequency, damping, gain), float(_left(sums[number], gain)) / samples


def _prepared(pairs: Sequence[Pair]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulated signals (R, 6, T), worn less simulated, and which samples there are (R, 1, T).

    Each kind is taken by its size; shorter recordings hold their last value.
    """
    sizes = {
        kind: np.sqrt(np.mean([getattr(real, kind).astype(np.float64).var() for real, _ in pairs]))
        for kind in ("acc", "gyr")
    }
    longest = max(real.n_samples for real, _ in pairs)

    def side(recording: ImuRecording) -> np.ndarray:
        signals = ((getattr(recording, kind)[:, 0], size) for kind, size in sizes.items())
        values = [smooth(signal, recording.rate).T / size for signal, size in signals]
        return np.pad(np.concatenate(values), ((0, 0), (0, longest - recording.n_samples)), mode="edge")

    made = np.stack([side(made) for _, made in pairs])
    there = np.arange(longest) < np.array([real.n_samples for real, _ in pairs])[:, None]
    return made, (np.stack([side(real) for real, _ in pairs]) - made) * there[:, None], there[:, None]


def _moments(
    sides: tuple[np.ndarray, np.ndarray, np.ndarray], rate: float, frequency: float, damping: float
) -> np.ndarray:
    """Dot products d.d, d.e and e.e of each block of each recording, shape (blocks, 3).

    d is worn less simulated, e the difference that tissue in full would make to the simulated.
    """
    made, d, there = sides
    e = (soft_tissue_artefact(made, rate, frequency, damping, 1.0) - made) * there
    starts = np.arange(0, made.shape[2], max(1, round(BLOCK_S * rate)))
    sums = [
        np.add.reduceat(np.einsum("rct,rct->rt", a, b), starts, axis=1) for a, b in ((d, d), (d, e), (e, e))
    ]
    return np.stack(sums, axis=-1).reshape(-1, 3)


def _left(moments: np.ndarray, gain: float | np.ndarray) -> np.ndarray:
    """Squared difference that is left: (d - g e)^2."""
    dd, de, ee = np.moveaxis(moments, -1, 0)
    return dd - 2 * gain * de + gain**2 * ee


def _best(moments: np.ndarray) -> tuple[int, float]:
    """The spring and damper, by number, that leave least, and their gain, from 0 to 1."""
    gains = np.clip(moments[:, 1] / np.maximum(moments[:, 2], 1e-12), 0.0, 1.0)
    number = int(np.argmin(_left(moments, gains)))
    return number, float(gains[number])


def rest_noise(signals: Sequence[np.ndarray], rate: float) -> float:
    """White noise of sensors by their quietest stretches, per root of Hz.

    Third differences see little of a motion; of white noise their variance is twenty times its own.
    """
    variances = []
    for values in signals:
        steps = np.diff(values.astype(np.float64), n=3, axis=0)
        whole = len(steps) // QUIET_SAMPLES * QUIET_SAMPLES
        variances += np.square(steps[:whole]).reshape(-1, QUIET_SAMPLES, 3).mean(axis=(1, 2)).tolist()
    if not variances:
        raise ValueError("the recordings are too short to find the sensor's noise")
    return float(np.sqrt(np.quantile(variances, QUIET) / 20 / (rate / 2)))


class Correlations(NamedTuple):
    """Correlation r of a simulated recording with the worn one, over samples and axes at once."""

    force: tuple[float, float]  # of specific force, as simulated and calibrated
    turning: tuple[float, float]  # of angular velocity


def held_out(pairs: Sequence[Pair], longest_shift_s: float = 0.5) -> tuple[str, list[Correlations]]:
    """Calibrate without each person in turn, or each recording, or each half of the only one, and test there.

    Returns the kind that was left out, "person", "recording" or "half", and the correlations of each
    recording or half. Raises ValueError as `calibrate` does.
    """
    people = [real.subject for real, _ in pairs]
    if len(pairs) == 1:
        what, pairs = "half", halves(*pairs[0], longest_shift_s)
    else:
        what = "person" if all(people) and len(set(people)) > 1 else "recording"
    groups = people if what == "person" else list(range(len(pairs)))
    known = {}
    for group in dict.fromkeys(groups):
        others = [pair for pair, own in zip(pairs, groups, strict=True) if own != group]
        known[group] = calibrate(others, longest_shift_s)
    fits = (known[group] for group in groups)
    return what, [correlations(*pair, fit, longest_shift_s) for pair, fit in zip(pairs, fits, strict=True)]


def halves(real: ImuRecording, made: ImuRecording, longest_shift_s: float) -> list[Pair]:
    """Both halves of a pair, aligned in time."""
    real, made = shifted(real, made, shift_between(real, made, longest_shift_s))
    whole, middle = real.n_samples, real.n_samples // 2
    return [(real.between(*part), made.between(*part)) for part in ((0, middle), (middle, whole))]


def correlations(
    real: ImuRecording, made: ImuRecording, known: Calibration, longest_shift_s: float
) -> Correlations:
    """Compare a pair before and after a calibration, each shifted to where it fits best."""
    sides = []
    for simulated in (made, known.applied(made)):
        worn, fitted = shifted(real, simulated, shift_between(real, simulated, longest_shift_s))
        signals = ((worn.acc, fitted.acc), (worn.gyr, fitted.gyr))
        sides.append([vector_r(first[:, 0], second[:, 0], worn.rate) for first, second in signals])
    before, after = sides
    return Correlations(*zip(before, after, strict=True))


def vector_r(first: np.ndarray, second: np.ndarray, rate: float) -> float:
    """Pearson's r of two signals (T, 3), over samples and axes at once, each axis about its own mean."""
    a, b = (smooth(values, rate) for values in (first, second))
    a, b = a - a.mean(axis=0), b - b.mean(axis=0)
    return float((a * b).sum() / max(np.sqrt((a * a).sum() * (b * b).sum()), 1e-12))
