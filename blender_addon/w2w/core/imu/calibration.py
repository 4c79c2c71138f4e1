# SPDX-License-Identifier: GPL-3.0-or-later
"""How a worn sensor differs from the simulated one: fitted to recordings of both of the same motion.

The fit is a property of the sensor and its site, not of a motion: how it sat, the soft tissue under it, its
noise. Each recording's shift in time is found on the way.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

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
            values = [
                butterworth(getattr(r, name)[:n, 0].T.astype(np.float64), r.rate, ALIGNED_BELOW_HZ, 2, True).T
                for r in (real, made)
            ]
            size = np.sqrt((values[0] ** 2).mean()) + 1e-6
            theirs.append(values[0] / size)
            ours.append(values[1] / size)
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
"""Natural frequencies tried. Where the softest fits best it is not tissue: a noisy motion, too, asks for
a weaker signal."""

STIFFEST_OF_RATE = 0.4
"""Highest natural frequency tried, of the sensors' rate; stiffer tissue moves with the bone."""

NEARER = (0.8, 0.87, 0.93, 1.0, 1.07, 1.15, 1.25)
"""Factors by which frequency and damping are then varied around the best of them."""

DELAYS = (0, 1, 2)
"""Samples by which tissue may have delayed the signal."""

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
    tissue: Tissue | None  # None where it explains nothing
    # white, one-sided, m/s2/sqrt(Hz); an upper bound, since the quietest stretches may move, too
    acc_noise: float
    gyr_noise: float  # the same in rad/s/sqrt(Hz)
    shifts_s: tuple[float, ...]  # how much later each worn recording began to show the motion

    def applied(self, made: ImuRecording) -> ImuRecording:
        """A simulated recording as the worn sensor would have it, without its noise."""
        return turned(ridden(made, self.tissue), self.turn)

    def sensor(self, base: SensorModel, name: str) -> SensorModel:
        """The sensor with what was found: how it sat, its tissue and its noise; the rest as it was."""
        worn = self.turn.inv().as_rotvec(degrees=True)
        names = ("soft_tissue_hz", "soft_tissue_damping", "soft_tissue_gain")
        tissue: dict[str, Any] = dict(zip(names, self.tissue or (None,), strict=self.tissue is not None))
        return replace(
            base,
            name=name,
            accelerometer=replace(base.accelerometer, noise_density=self.acc_noise),
            gyroscope=replace(base.gyroscope, noise_density=self.gyr_noise),
            worn_turn_deg=tuple(round(float(angle), 3) for angle in worn),
            mounting_turn_deg=0.0,
            fixed_misalignment_deg=0.0,
            **tissue,
        )


def calibrate(pairs: Sequence[Pair], longest_shift_s: float = 0.5, with_tissue: bool = True) -> Calibration:
    """Fit a site's sensor to recordings without errors that were simulated of the same motions.

    `pairs` are worn and simulated recordings of one sensor, at one rate, at most `longest_shift_s` apart in
    time. Raises ValueError if a pair is too short, or the worn sensor hardly moves.
    """
    if not pairs:
        raise ValueError("there is nothing to calibrate with: no worn recording has a motion")
    tissue = None
    for _ in range(ROUNDS):
        shown = [(real, ridden(made, tissue)) for real, made in pairs]
        shifts = [shift_between(*pair, longest_shift_s) for pair in shown]
        turn = mounting([shifted(*pair, shift) for pair, shift in zip(shown, shifts, strict=True)])
        if not with_tissue:
            break
        plain = [(real, turned(made, turn)) for real, made in pairs]
        tissue, late = _tissue_and_delay(plain, shifts)
        shifts = [shift - late for shift in shifts]
    rate = pairs[0][0].rate
    noise = (rest_noise([getattr(real, kind)[:, 0] for real, _ in pairs], rate) for kind in ("acc", "gyr"))
    return Calibration(turn, tissue, *noise, tuple(shift / rate for shift in shifts))


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
    alike = [(a[:, max(0, k) : n + min(0, k)] * b[:, max(0, -k) : n - max(0, k)]).mean() for k in lags]
    return int(lags[int(np.argmax(alike))])


def shifted(real: ImuRecording, made: ImuRecording, shift: int) -> Pair:
    """Both recordings, cut to the time that both show."""
    first, second = max(0, shift), max(0, -shift)
    n = min(real.n_samples - first, made.n_samples - second)
    return tuple(
        replace(recording, acc=recording.acc[start : start + n], gyr=recording.gyr[start : start + n])
        for recording, start in ((real, first), (made, second))
    )


def smooth(values: np.ndarray, rate: float) -> np.ndarray:
    """Signals (T, 3) below `FIT_BELOW_HZ`, in double precision."""
    if rate / 2 <= FIT_BELOW_HZ:
        return values.astype(np.float64)
    return butterworth(values.T.astype(np.float64), rate, FIT_BELOW_HZ, 2, zero_phase=True).T


def _tissue_and_delay(pairs: Sequence[Pair], shifts: Sequence[int]) -> tuple[Tissue | None, int]:
    """The tissue, and the samples by which the shifts are too long: its delay looks like a shift."""
    found = {}
    for late in DELAYS:
        together = [shifted(*pair, shift - late) for pair, shift in zip(pairs, shifts, strict=True)]
        found[late] = fit_tissue(together)
    late = min(found, key=lambda one: found[one][1])
    return found[late][0], late


def fit_tissue(pairs: Sequence[Pair]) -> tuple[Tissue | None, float]:
    """The spring and damper that bring simulated signals nearest to worn ones, and the mean square left.

    Both are in the same axes. None where tissue does not help on parts of the recordings that it was not
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
        one = _best(moments[:, parts != part].sum(axis=1))
        here = moments[one[0]][parts == part].sum(axis=0)
        before += here[0]
        after += _left(here, one[1])
    if len(np.unique(parts)) < 2 or not after < (1 - LEAST_GAIN) * before:
        return None, before / samples
    number, gain = _best(moments.sum(axis=1))
    if tried[number][0] == SOFTEST_HZ:
        return None, before / samples
    near = [(tried[number][0] * one, tried[number][1] * other) for one, other in product(NEARER, NEARER)]
    sums = np.stack([_moments(sides, rate, *tissue).sum(axis=0) for tissue in near])
    number, gain = _best(sums)
    tissue = Tissue(*(round(float(value), 3) for value in (*near[number], gain)))
    return tissue, float(_left(sums[number], gain)) / samples


def _prepared(pairs: Sequence[Pair]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulated signals (R, 6, T), worn less simulated, and which samples there are (R, 1, T).

    Each kind is taken by its size; shorter recordings hold their last value.
    """
    sizes = {
        kind: np.sqrt(np.mean([getattr(real, kind).astype(np.float64).var() for real, _ in pairs]))
        for kind in ("acc", "gyr")
    }
    longest = max(real.n_samples for real, _ in pairs)

    def side(one: ImuRecording) -> np.ndarray:
        parts = [smooth(getattr(one, kind)[:, 0], one.rate).T / size for kind, size in sizes.items()]
        return np.pad(np.concatenate(parts), ((0, 0), (0, longest - one.n_samples)), mode="edge")

    made = np.stack([side(made) for _, made in pairs])
    there = np.arange(longest) < np.array([real.n_samples for real, _ in pairs])[:, None]
    return made, (np.stack([side(real) for real, _ in pairs]) - made) * there[:, None], there[:, None]


def _moments(
    sides: tuple[np.ndarray, np.ndarray, np.ndarray], rate: float, frequency: float, damping: float
) -> np.ndarray:
    """Of each block of each recording: d.d, d.e and e.e, shape (blocks, 3).

    d is worn less simulated, e the difference that tissue in full would make to the simulated.
    """
    made, d, there = sides
    e = (soft_tissue_artefact(made, rate, frequency, damping, 1.0) - made) * there
    starts = np.arange(0, made.shape[2], max(1, round(BLOCK_S * rate)))
    sums = [
        np.add.reduceat(np.einsum("rct,rct->rt", one, other), starts, axis=1)
        for one, other in ((d, d), (d, e), (e, e))
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
