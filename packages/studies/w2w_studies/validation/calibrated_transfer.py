# SPDX-License-Identifier: GPL-3.0-or-later
"""Train on simulated signals, test on a person never seen, calibrated step by step on other people."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.filtering import butterworth
from w2w.core.imu.calibration import Pair, calibrate, mounting, shift_between, shifted, turned
from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.folds import ALWAYS_TRAIN
from w2w.core.windows.windows import WindowSpec

from .transfer import REAL, Transfer, first_window, scored

COPIES = 8
"""Copies of a simulated window, each with another difference."""

LONGEST_SHIFT_S = 0.5
"""Most seconds that worn and simulated recordings are apart."""

AS_SIMULATED = "as simulated"
TURNED = "turned to its angle"
TISSUE = "and on its soft tissue"
ONE_BAND = "and both sides below {:g} Hz"
DIFFERENCES = "and told how windows differ"
OTHER_ACTIONS = "the same, from other actions"


def calibrated_transfer(
    pairs: Sequence[Pair], activities: Sequence[str], spec: WindowSpec, band_hz: float, seed: int = 0
) -> list[Transfer]:
    """Simulated to real, one step of the calibration after the other.

    Each is fitted to the pairs of the people who are not tested. The last but one adds to the simulated
    windows what worn windows differ by, whatever they show: every activity gets the same differences, so
    nothing of the real activities is learned. The last takes all this from half of the activities and is
    tested on the other half.

    `pairs`: worn and simulated, with subjects.
    `spec`: one window a clip is used, its first.
    `band_hz`: of the motions: above it simulation knows nothing.
    `Transfer.trained` says what was done.
    Raises ValueError if there are fewer than two subjects.
    """
    subject = np.array([real.subject for real, _ in pairs])
    if len(set(subject.tolist())) < 2:
        raise ValueError("to leave one person out there must be two at least")
    truth = np.array([list(activities).index(real.activity) for real, _ in pairs])
    worn = {
        None: _described((real for real, _ in pairs), spec),
        band_hz: _described((limited(real, band_hz) for real, _ in pairs), spec),
    }
    steps = (AS_SIMULATED, TURNED, TISSUE, ONE_BAND.format(band_hz), DIFFERENCES, OTHER_ACTIONS)
    named = {step: np.empty(len(pairs), dtype=np.int16) for step in steps}
    for person in np.unique(subject):
        out = subject == person
        known = calibrate(_some(pairs, ~out))
        sides = {
            AS_SIMULATED: (None, lambda made: made),
            TURNED: (None, lambda made, known=known: turned(made, known.turn)),
            TISSUE: (None, known.applied),
            steps[3]: (band_hz, lambda made, known=known: limited(known.applied(made), band_hz)),
        }
        for step, (band, view) in sides.items():
            made = _described((view(made) for _, made in pairs), spec)
            named[step][out] = _named(made[~out], truth[~out], worn[band][out], seed)
        differ = (worn[band_hz] - made)[~out]
        named[DIFFERENCES][out] = _told(made[~out], truth[~out], differ, worn[band_hz][out], seed)
        for odd in (0, 1):
            tested, used = out & (truth % 2 == odd), ~out & (truth % 2 != odd)
            sat = _sat(_some(pairs, used))
            made = _described((limited(turned(made, sat), band_hz) for _, made in pairs), spec)
            differ = (worn[band_hz] - made)[used]
            named[OTHER_ACTIONS][tested] = _told(made[~out], truth[~out], differ, worn[band_hz][tested], seed)
    clips = np.array([real.clip for real, _ in pairs])
    return [scored(step, REAL, truth, found, clips, len(activities), seed) for step, found in named.items()]


def _sat(pairs: Sequence[Pair]) -> Rotation:
    """How the sensor sat, whatever tissue was under it."""
    return mounting([shifted(*pair, shift_between(*pair, LONGEST_SHIFT_S)) for pair in pairs])


def _some(pairs: Sequence[Pair], taken: np.ndarray) -> list[Pair]:
    return [pair for pair, use in zip(pairs, taken, strict=True) if use]


def _described(recordings: Iterable[ImuRecording], spec: WindowSpec) -> np.ndarray:
    """Features (W, D) of each recording's first window."""
    return np.concatenate([first_window(recording, spec) for recording in recordings])


def _told(
    made: np.ndarray, label: np.ndarray, differ: np.ndarray, tested: np.ndarray, seed: int
) -> np.ndarray:
    """What a classifier of simulated windows names others, if it is told how worn windows differ."""
    return _named(*with_differences(made, label, differ, seed), tested, seed)


def with_differences(
    made: np.ndarray, label: np.ndarray, differ: np.ndarray, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Copies of simulated windows (W, D), each with a difference drawn from (V, D), and their labels."""
    rng = np.random.default_rng(seed)
    drawn = rng.integers(len(differ), size=(COPIES, len(made)))
    return (made[None] + differ[drawn]).reshape(-1, made.shape[1]), np.tile(label, COPIES)


def limited(recording: ImuRecording, band_hz: float) -> ImuRecording:
    """A recording below a frequency."""
    if band_hz >= recording.rate / 2:
        return recording
    acc, gyr = (
        butterworth(values.transpose(1, 2, 0).astype(np.float64), recording.rate, band_hz, 4, True)
        for values in (recording.acc, recording.gyr)
    )
    return replace(recording, acc=acc.transpose(2, 0, 1), gyr=gyr.transpose(2, 0, 1))


def _named(trained: np.ndarray, label: np.ndarray, tested: np.ndarray, seed: int) -> np.ndarray:
    """What a classifier of some windows names others."""
    features = np.concatenate([trained, tested])[:, None]
    fold = np.repeat([ALWAYS_TRAIN, 0], [len(trained), len(tested)])
    labels = np.concatenate([label, np.zeros(len(tested), dtype=label.dtype)])
    return Ridge(seed=seed).predict_folds(features.astype(np.float32), labels, fold, fold == 0)[:, 0]
