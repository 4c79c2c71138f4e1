# SPDX-License-Identifier: GPL-3.0-or-later
"""Gait phases of short windows, and how well simulated sensors teach what worn ones show of them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from w2w.core.filtering import butterworth
from w2w.core.imu.calibration import Pair, calibrate, turned
from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import score_patches
from w2w.core.ranking.folds import ALWAYS_TRAIN
from w2w.core.windows.features import window_features

from ..datasets.gait import GaitTrial
from ..validation.site_windows import SiteWindows

PHASES = ("double support", "left swing", "right swing")
SWING_SPEED = 0.3
"""A foot swings while its ankle is faster than this part of its fast speed (its 95th percentile)."""

ANKLE_HZ = 10.0
"""Band of the ankles' paths."""

WINDOW, STRIDE = 20, 5
"""Samples of a phase's window and from one to the next, at 100 Hz; every fourth is tested on."""

BLOCKS = 10
"""Stretches of the walk that are never split between training and test."""


def phases(worn: GaitTrial) -> np.ndarray:
    """Phase of each sample by the speeds of Vicon's ankles, shape (T,), as indices into `PHASES`."""
    swings = []
    for side in "LR":
        path = butterworth(worn.vicon[f"{side}TIO"].T, worn.recording.rate, ANKLE_HZ, 2, zero_phase=True).T
        speed = np.linalg.norm(np.gradient(path, 1 / worn.recording.rate, axis=0), axis=1)
        swings.append(speed > SWING_SPEED * np.percentile(speed, 95))
    left, right = swings
    return np.where(left & ~right, 1, np.where(right & ~left, 2, 0))


def phase_windows(recording: ImuRecording, phase: np.ndarray) -> SiteWindows:
    """Short windows, each named by the phase in its middle; none reaches from one block into the next."""
    signals = np.concatenate([recording.acc, recording.gyr], axis=2)[: len(phase)]
    views = np.lib.stride_tricks.sliding_window_view(signals, WINDOW, axis=0)[::STRIDE].transpose(0, 1, 3, 2)
    starts = np.arange(len(views)) * STRIDE
    block = starts * BLOCKS // len(phase)
    whole = block == (starts + WINDOW - 1) * BLOCKS // len(phase)
    named = np.array(PHASES)[phase[starts + WINDOW // 2]]
    return SiteWindows(
        window_features(views[whole], recording.rate),
        named[whole],
        np.array([f"block {number}" for number in block[whole]]),
        np.full(int(whole.sum()), ""),
        (starts[whole] // STRIDE) % (WINDOW // STRIDE) == 0,
        {},
    )


class PhasesTaught(NamedTuple):
    """Macro F1 of worn sensors' phases, each half of the walk named by what was learned from the other."""

    way: str  # what was learned from
    mean: float
    low: float
    high: float
    """Over the sites, and the 95 % interval over stretches of the walk."""
    by_site: np.ndarray  # (S,)


def taught_phases(
    pairs: Sequence[Pair], phase: np.ndarray, longest_shift_s: float, seed: int = 0
) -> list[PhasesTaught]:
    """Train on one half of the walk, test on the worn sensors of the other; both ways.

    `phase` int (T,).
    `pairs`: worn and simulated, site by site.
    `longest_shift_s`: as for `calibrate`, which sees the half that is trained on.
    What was learned from: simulated sensors as they are, turned as each sat, with soft tissue too, and from
    worn ones.
    """
    middle, named, asked = len(phase) // 2, {}, []
    worn = phase_windows(_together([real for real, _ in pairs]), phase)
    for number, used in enumerate((slice(middle, None), slice(0, middle))):
        known = [calibrate([tuple(cut(one, used) for one in pair)], longest_shift_s) for pair in pairs]
        shown = {
            "simulated, as it is": [made for _, made in pairs],
            "simulated, turned to its angle": [
                turned(made, one.turn) for (_, made), one in zip(pairs, known, strict=True)
            ],
            "simulated, and on its soft tissue": [
                one.applied(made) for (_, made), one in zip(pairs, known, strict=True)
            ],
        }
        sides = {way: phase_windows(_together(made), phase) for way, made in shown.items()} | {"worn": worn}
        tested = _half(worn) == number
        asked.append(worn.some(tested & worn.is_test))
        for way, side in sides.items():
            named.setdefault(way, []).append(_named(side.some(~tested), asked[-1], seed))
    truth = np.concatenate([_numbers(test) for test in asked])
    clips = np.concatenate([test.clip for test in asked])
    found = []
    for way, parts in named.items():
        f1, boot = score_patches(truth, np.concatenate(parts), clips, len(PHASES), 1000, 0.95, seed)
        low, high = np.quantile(boot.mean_samples.mean(axis=1), [0.025, 0.975])
        found.append(PhasesTaught(way, float(f1.mean()), float(low), float(high), f1.mean(axis=1)))
    return found


def cut(recording: ImuRecording, part: slice) -> ImuRecording:
    """A stretch of a recording."""
    return ImuRecording(recording.acc[part], recording.gyr[part], recording.rate, recording.sites)


def _together(recordings: Sequence[ImuRecording]) -> ImuRecording:
    acc, gyr = (np.concatenate([getattr(one, kind) for one in recordings], axis=1) for kind in ("acc", "gyr"))
    return ImuRecording(acc, gyr, recordings[0].rate)


def _numbers(windows: SiteWindows) -> np.ndarray:
    return np.array([PHASES.index(name) for name in windows.activity.tolist()])


def _half(windows: SiteWindows) -> np.ndarray:
    """In which half of the walk each window is, 0 or 1."""
    return np.array([int(clip.split()[1]) * 2 // BLOCKS for clip in windows.clip.tolist()])


def _named(train: SiteWindows, test: SiteWindows, seed: int) -> np.ndarray:
    """Phases (W, S) that each site names."""
    fold = np.repeat([ALWAYS_TRAIN, 0], [len(train.features), len(test.features)])
    labels = np.concatenate([_numbers(train), _numbers(test)])
    features = np.concatenate([train.features, test.features])
    return Ridge(seed=seed).predict_folds(features, labels, fold, fold == 0)
