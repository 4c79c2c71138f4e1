# SPDX-License-Identifier: GPL-3.0-or-later
"""What `why_vigour` does about how hard simulated sensors are moved: to clips, windows and features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import STANDARD_GRAVITY
from w2w.core.windows.features import UNIT, feature_names

from ..comparisons.unpaired import Side
from ..validation.site_windows import SiteWindows

MIDDLING = (float(UNIT[0]), float(UNIT[3]))
"""How hard a sensor is moved after scaling, root mean square: m/s2 and rad/s."""

STILL = 1 / 16
"""What is moved less than this share of MIDDLING is not scaled up as if it were: it would be noise."""

MANY_TIMES = 0.5
"""Standard deviation of the logarithm of how hard a clip is done."""

MOST_SCALED = 3.0


def unit_windows(signals: np.ndarray) -> np.ndarray:
    """Windows (W, N, samples, 6), each moved equally hard about its own posture."""
    out = signals.copy()
    for first, middling in zip((0, 3), MIDDLING, strict=True):
        part = out[..., first : first + 3]
        moved = _moved(part, first)
        size = np.sqrt(np.square(moved).sum(axis=-1).mean(axis=-1))[..., None, None]
        part += moved * (middling / np.maximum(size, STILL * middling) - 1)
    return out


def compressed(signals: np.ndarray) -> np.ndarray:
    """Windows in which a movement ten times as hard counts 2.5 times as much, not ten times."""
    out = signals.copy()
    for first, middling in zip((0, 3), MIDDLING, strict=True):
        part = out[..., first : first + 3]
        moved = _moved(part, first)
        unit = middling / 4
        size = np.maximum(np.linalg.norm(moved, axis=-1, keepdims=True) / unit, 1e-6)
        part += moved * (np.log1p(size) / size - 1)
    return out


def directions(signals: np.ndarray) -> np.ndarray:
    """Windows that say only where specific force and angular velocity point, sample by sample."""
    out = signals.copy()
    for first, length, still in ((0, STANDARD_GRAVITY, 1e-3), (3, MIDDLING[1], STILL * MIDDLING[1])):
        part = out[..., first : first + 3]
        part *= length / np.sqrt(np.square(part).sum(axis=-1, keepdims=True) + still**2)
    return out


def _moved(part: np.ndarray, first: int) -> np.ndarray:
    """Specific force less its mean over a window, or angular velocity as it is."""
    return part - part.mean(axis=-2, keepdims=True) if first == 0 else part.copy()


def scaled(recording: ImuRecording, by: np.ndarray | float) -> ImuRecording:
    """A clip moved so many times as hard about its mean, by sensor or all alike."""
    by = np.asarray(by, dtype=np.float64)[..., None]
    still = np.nanmean(recording.acc, axis=0)
    acc, gyr = still + (recording.acc - still) * by, recording.gyr * by
    return replace(recording, acc=acc.astype(np.float32), gyr=gyr.astype(np.float32))


def hardness(recording: ImuRecording) -> np.ndarray:
    """Root mean square of each sensor's specific force less its mean, m/s2, shape (N,)."""
    moved = recording.acc - np.nanmean(recording.acc, axis=0)
    return np.sqrt(np.nanmean(np.square(moved).sum(axis=2), axis=0))


def unit_clips(recordings: Sequence[ImuRecording]) -> list[ImuRecording]:
    """Clips done equally hard, all sensors of one by the same factor."""
    out = []
    for recording in recordings:
        size = np.sqrt(np.square(hardness(recording)).mean())
        out.append(scaled(recording, MIDDLING[0] / max(size, STILL * MIDDLING[0])))
    return out


def varied_clips(recordings: Sequence[ImuRecording], seed: int = 0) -> list[ImuRecording]:
    """Clips done harder or less hard by chance, all sensors of one by the same factor."""
    factors = np.exp(np.random.default_rng(seed).normal(0, MANY_TIMES, len(recordings)))
    return [scaled(one, factor) for one, factor in zip(recordings, factors, strict=True)]


def as_hard_as_people(made: Side, worn: Side, site_of: np.ndarray) -> list[ImuRecording]:
    """Clips whose sensors are moved as hard as people's at that site in that activity, by the medians."""
    theirs, ours = _typical(worn, np.arange(site_of.max() + 1)), _typical(made, site_of)
    factors = {
        name: np.clip(theirs[name] / ours[name], 1 / MOST_SCALED, MOST_SCALED)[site_of]
        for name in set(ours) & set(theirs)
    }
    return [scaled(one, factors.get(one.activity, np.ones(len(site_of)))) for one in made.recordings]


def _typical(side: Side, site_of: np.ndarray) -> dict[str, np.ndarray]:
    """Median over clips of how hard each site is moved, by activity, shape (S,)."""
    found: dict[str, list[np.ndarray]] = {}
    of_site = site_of == np.arange(site_of.max() + 1)[:, None]
    for recording in side.recordings:
        size = hardness(recording)
        found.setdefault(recording.activity, []).append(
            np.array([np.nanmean(np.where(of, size, np.nan)) if np.isfinite(size[of]).any() else np.nan
                      for of in of_site])
        )  # fmt: skip
    return {name: np.nanmedian(sizes, axis=0) for name, sizes in found.items()}


class Sampled(NamedTuple):
    """How long windows are and how often they are sampled."""

    samples: int
    rate: float


def without_lengths(windows: SiteWindows, sampled: Sampled) -> SiteWindows:
    """Features less those of the lengths of specific force and angular velocity."""
    kept = [not name.startswith("|") for name in feature_names(*sampled)]
    return windows._replace(features=windows.features[..., kept])


def same_mean_by_source(windows: SiteWindows, source: np.ndarray) -> SiteWindows:
    """Features of each source about the mean of all: within a source every activity weighs the same."""
    features = windows.features.astype(np.float64)
    means = {name: _balanced_mean(features, windows.activity, source == name) for name in np.unique(source)}
    overall = np.mean(list(means.values()), axis=0)
    for name, mean in means.items():
        features[source == name] += overall - mean
    return windows._replace(features=features.astype(np.float32))


def _balanced_mean(features: np.ndarray, activity: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Mean over activities of the mean over their windows, shape (N, D)."""
    return np.mean([features[rows & (activity == one)].mean(axis=0) for one in np.unique(activity[rows])],
                   axis=0)  # fmt: skip
