# SPDX-License-Identifier: GPL-3.0-or-later
"""Train on one kind of signals, test on another: real and simulated recordings of the same clips."""

from collections.abc import Sequence
from itertools import product
from typing import NamedTuple

import numpy as np

from w2w.core.imu.calibration import Pair, mounting, turned
from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.f1 import confusion_of, score_patches
from w2w.core.ranking.folds import ALWAYS_TRAIN
from w2w.core.windows.features import window_features
from w2w.core.windows.windows import WindowSpec, cut_windows

REAL, SIMULATED = "real", "simulated"
RESAMPLES = 1000


class Transfer(NamedTuple):
    """How well a classifier trained on one side names the other."""

    trained: str
    tested: str
    macro_f1: float
    low: float
    high: float
    """And the 95 % interval by a bootstrap over clips."""
    accuracy: float
    f1: np.ndarray  # (A,)
    confusion: np.ndarray  # (A, A)


def transfer(
    pairs: Sequence[Pair], activities: Sequence[str], spec: WindowSpec, seed: int = 0
) -> list[Transfer]:
    """All four ways to train and test, each leaving out the person tested.

    Nobody knows how a real sensor sat on the skin: the one rotation from the simulated to the real axes is
    found from the pairs of the people trained on, never of the one tested.

    `pairs`: with subjects.
    `spec`: one window a clip is used, its first.
    In this order: real to real, real to simulated, simulated to real, simulated to simulated.
    Raises ValueError if there are fewer than two subjects.
    """
    subject = np.array([real.subject for real, _ in pairs])
    people = np.unique(subject)
    if len(people) < 2:
        raise ValueError("to leave one person out there must be two at least")
    truth = np.array([list(activities).index(real.activity) for real, _ in pairs])
    clips = np.array([real.clip for real, _ in pairs])
    real = np.stack([first_window(recording, spec) for recording, _ in pairs])
    named = {way: np.empty(len(pairs), dtype=np.int16) for way in product((REAL, SIMULATED), repeat=2)}
    for person in people:
        out = subject == person
        turn = mounting([pair for pair, left in zip(pairs, out, strict=True) if not left])
        sides = {
            REAL: real,
            SIMULATED: np.stack([first_window(turned(made, turn), spec) for _, made in pairs]),
        }
        for trained, tested in named:
            features = np.concatenate([sides[trained][~out], sides[tested][out]])
            labels = np.concatenate([truth[~out], truth[out]])
            fold = np.repeat([ALWAYS_TRAIN, 0], [(~out).sum(), out.sum()])
            found = Ridge(seed=seed).predict_folds(features, labels, fold, fold == 0)
            named[trained, tested][out] = found[:, 0]
    return [
        scored(trained, tested, truth, found, clips, len(activities), seed)
        for (trained, tested), found in named.items()
    ]


def first_window(recording: ImuRecording, spec: WindowSpec) -> np.ndarray:
    """Features of a one-sensor recording's first window, shape (1, D)."""
    return window_features(cut_windows(recording, spec).signals[:1], recording.rate)[0]


def scored(
    trained: str,
    tested: str,
    truth: np.ndarray,
    named: np.ndarray,
    clips: np.ndarray,
    n_activities: int,
    seed: int,
) -> Transfer:
    """What windows were named against what they show."""
    f1, boot = score_patches(truth, named[:, None], clips, n_activities, RESAMPLES, 0.95, seed)
    return Transfer(
        trained, tested, float(f1[0].mean()), float(boot.mean_low[0]), float(boot.mean_high[0]),
        float((truth == named).mean()), f1[0], confusion_of(truth, named[:, None], n_activities)[0],
    )  # fmt: skip
