# SPDX-License-Identifier: GPL-3.0-or-later
"""Learn from simulated sensors, be tested on worn ones of other people, whose axes and gain nobody knows."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import STANDARD_GRAVITY
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import ClipUnits, f1_scores
from w2w.core.ranking.folds import ALWAYS_TRAIN
from w2w.core.windows.features import window_features
from w2w.core.windows.windows import TooShortError, WindowSpec, cut_windows

CANDIDATES = 4000
"""Rotations tried for how a sensor sat; the best of them is then refined."""

MOST_WINDOWS = 2000
"""Windows of a site that are used at most, evenly spaced."""

AT_ONCE = 256
"""Windows described at once, which stay in cache."""

ROUNDS, SPREAD = 4, np.radians(12.0)
"""Rounds of as many small turns about the best, each with half the spread of the one before."""


@dataclass(frozen=True, eq=False)
class SiteSignals:
    """Windows of one site's sensors."""

    signals: np.ndarray  # (W, samples, 6): of all sensors of the site, one after the other
    label: np.ndarray  # (W,) of int
    person: np.ndarray  # (W,) of str
    rate: float

    @property
    def level(self) -> float:
        """Median of the windows' mean magnitude of specific force, m/s2."""
        return float(np.median(np.linalg.norm(self.signals[..., :3], axis=2).mean(axis=1)))


class WayFound(NamedTuple):
    """Macro F1 by site, shape (S,), trained on one side and tested on people who were not seen."""

    way: str  # what was done about axes and gain
    simulated: np.ndarray
    real: np.ndarray
    """Trained on all simulated clips, and on the other people."""


def site_signals(
    recordings: Sequence[ImuRecording],
    activities: Sequence[str],
    spec: WindowSpec,
    site_of: np.ndarray,
    use: str,
) -> list[SiteSignals]:
    """Windows that do not overlap, site by site.

    `site_of` (P,) of int.
    `activities`: others stay out.
    `use` {"both", "acc", "gyr"}: the other kind is set to 0.
    """
    signals, labels, people = [], [], []
    for recording in recordings:
        if recording.activity not in activities:
            continue
        try:
            windows = cut_windows(recording, spec)
        except TooShortError:
            continue
        kept = windows.signals[windows.is_test].astype(np.float32)
        signals.append(kept)
        labels += [list(activities).index(recording.activity)] * len(kept)
        people += [recording.subject] * len(kept)
    together = np.concatenate(signals)
    together[..., {"both": slice(0, 0), "acc": slice(3, 6), "gyr": slice(0, 3)}[use]] = 0
    label, person = np.array(labels), np.array(people)
    found = []
    for site in range(int(site_of.max()) + 1):
        sensors = np.flatnonzero(site_of == site)
        of_site = together[:, sensors].transpose(1, 0, 2, 3).reshape(-1, *together.shape[2:])
        whose = [np.tile(of, len(sensors)) for of in (label, person)]
        kept = np.unique(np.linspace(0, len(of_site) - 1, min(len(of_site), MOST_WINDOWS)).astype(int))
        found.append(SiteSignals(of_site[kept], *(of[kept] for of in whose), recordings[0].rate))
    return found


def as_they_are(signals: np.ndarray) -> np.ndarray:
    """Windows unchanged."""
    return signals


def magnitudes(signals: np.ndarray) -> np.ndarray:
    """Lengths of specific force and angular velocity alone, which no rotation changes."""
    out = np.zeros_like(signals)
    out[..., 0] = np.linalg.norm(signals[..., :3], axis=-1)
    out[..., 3] = np.linalg.norm(signals[..., 3:], axis=-1)
    return out


def by_gravity(signals: np.ndarray) -> np.ndarray:
    """Parts along and across the window's mean specific force, which no rotation changes either."""
    up = signals[..., :3].mean(axis=1, keepdims=True)
    up /= np.maximum(np.linalg.norm(up, axis=-1, keepdims=True), 1e-6)
    out = np.zeros_like(signals)
    for first in (0, 3):
        vector = signals[..., first : first + 3]
        along = (vector * up).sum(axis=-1)
        out[..., first] = along
        out[..., first + 1] = np.linalg.norm(vector - along[..., None] * up, axis=-1)
    return out


def mounting_rotation(worn: SiteSignals, made: SiteSignals, seed: int = 0) -> Rotation:
    """The rotation from a worn sensor's axes to the simulated one's, by what each activity looks like.

    Unpaired: mean and covariance of specific force, activity by activity, are brought together.
    """
    shared = sorted(set(worn.label.tolist()) & set(made.label.tolist()))
    (means_w, covs_w), (means_m, covs_m) = (_moments(side, shared) for side in (worn, made))
    best, spread = Rotation.identity(), None
    rng = np.random.default_rng(seed)
    for _ in range(1 + ROUNDS):
        if spread is None:
            tried, spread = Rotation.random(CANDIDATES, random_state=rng), SPREAD
        else:
            tried = Rotation.from_rotvec(rng.normal(0, spread, (CANDIDATES, 3))) * best
            spread /= 2
        r = np.concatenate([best.as_matrix()[None], tried.as_matrix()])
        cost = np.square(np.einsum("nij,aj->nai", r, means_w) - means_m).sum(axis=(1, 2))
        cost += np.square(np.einsum("nij,ajk,nlk->nail", r, covs_w, r, optimize=True) - covs_m).sum(
            axis=(1, 2, 3)
        )
        best = Rotation.from_matrix(r[int(cost.argmin())])
    return best


def _moments(side: SiteSignals, labels: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Mean direction (A, 3) and covariance (A, 3, 3) of specific force, both of order one."""
    means, covs = [], []
    for label in labels:
        acc = side.signals[side.label == label][..., :3].astype(np.float64)
        mean = acc.mean(axis=(0, 1))
        means.append(mean / max(np.linalg.norm(mean), 1e-9))
        moving = (acc - acc.mean(axis=1, keepdims=True)).reshape(-1, 3)
        cov = moving.T @ moving / len(moving)
        covs.append(cov / max(np.trace(cov), 1e-9))
    return np.array(means), np.array(covs)


class Way(NamedTuple):
    """What is done about axes and gain: a view of the signals, and whether gain and rotation are found."""

    name: str
    view: Callable[[np.ndarray], np.ndarray]
    level: bool = True
    turn: bool = False


WAYS = (
    Way("axes and gain as they are", as_they_are, level=False),
    Way("gain set to 1 g", as_they_are),
    Way("gain, magnitudes alone", magnitudes),
    Way("gain, along and across gravity", by_gravity),
    Way("gain, one rotation a site", as_they_are, turn=True),
)


def try_ways(
    worn: Sequence[SiteSignals], made: Sequence[SiteSignals], n_activities: int, seed: int = 0
) -> list[WayFound]:
    """Macro F1 by site of every way to deal with axes and gain.

    `worn`, `made`: site by site.
    A site's gain is found without labels from all its windows, as a sensor at rest would show it; its
    rotation from the people who are not tested.
    """
    found = []
    for way in WAYS:
        simulated = [_tested(w, m, way, n_activities, seed) for w, m in zip(worn, made, strict=True)]
        real = [_tested(w, None, way._replace(turn=False), n_activities, seed) for w in worn]
        found.append(WayFound(way.name, np.array(simulated), np.array(real)))
    return found


def _tested(worn: SiteSignals, made: SiteSignals | None, way: Way, n_activities: int, seed: int) -> float:
    """Macro F1 on each person in turn, trained on simulated windows, or on the other people's."""
    named = np.empty(len(worn.label), dtype=np.int64)
    trained = None if made is None else _features(way.view(_levelled(made, way)), worn.rate)
    signals = _levelled(worn, way)
    features = None if way.turn else _features(way.view(signals), worn.rate)
    for person in np.unique(worn.person):
        out = worn.person == person
        if way.turn:
            others = SiteSignals(worn.signals[~out], worn.label[~out], worn.person[~out], worn.rate)
            tested = _features(
                way.view(turned(signals[out], mounting_rotation(others, made, seed))), worn.rate
            )
        else:
            tested = features[out]
        x, y = (features[~out], worn.label[~out]) if made is None else (trained, made.label)
        fold = np.repeat([ALWAYS_TRAIN, 0], [len(x), len(tested)])
        labels = np.concatenate([y, worn.label[out]])
        found = Ridge(seed=seed).predict_folds(np.concatenate([x, tested])[:, None], labels, fold, fold == 0)
        named[out] = found[:, 0]
    counts = ClipUnits(worn.label, worn.person, n_activities).count(named[:, None])
    return float(f1_scores(counts, np.ones((1, len(counts.size)))).mean())


def _levelled(side: SiteSignals, way: Way) -> np.ndarray:
    """Windows with specific force scaled to 1 g, where the way asks for it."""
    gain = STANDARD_GRAVITY / side.level if way.level else 1.0
    return side.signals * np.array([gain] * 3 + [1.0] * 3, dtype=side.signals.dtype)


def turned(signals: np.ndarray, rotation: Rotation) -> np.ndarray:
    """Windows (W, samples, 6) in other axes."""
    r = rotation.as_matrix().astype(signals.dtype)
    return np.concatenate([signals[..., :3] @ r.T, signals[..., 3:] @ r.T], axis=-1)


def _features(signals: np.ndarray, rate: float) -> np.ndarray:
    """Features (W, D) of windows (W, samples, 6), taken as sensors of one window each, which is faster."""
    parts = [signals[first : first + AT_ONCE] for first in range(0, len(signals), AT_ONCE)]
    return np.concatenate([window_features(part[None], rate)[0] for part in parts])
