# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows of sensors at the same sites, as features."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.windows.features import window_features
from w2w.core.windows.windows import TooShortError, WindowSpec, cut_windows

from .some_windows import some_windows

Use = Literal["both", "acc", "gyr"]


class SiteWindows(NamedTuple):
    """Windows of sensors at the same sites, as what a classifier takes of them."""

    features: np.ndarray
    """(W, N, D): or the windows themselves, shape (W, N, samples, 6), for a classifier that takes those."""
    activity: np.ndarray
    clip: np.ndarray
    subject: np.ndarray
    """(W,) of str: an unknown subject is ""."""
    is_test: np.ndarray  # (W,) of bool
    skipped: dict[str, str]  # clips too short or too full of gaps, each with the reason

    def person_of(self) -> dict[str, str]:
        """Who is seen in each clip."""
        return dict(zip(self.clip.tolist(), self.subject.tolist(), strict=True))

    def ranked(
        self, activities: Sequence[str], by_subject: bool, folds: int = 5, seed: int = 0, **more: Any
    ) -> UtilityMap:
        """The map of all sensors, an expected one only where `halvings` are asked for; see `utility_map`."""
        subject = self.subject if by_subject else None
        protocol = CrossValidation(self.activity, self.clip, subject, self.is_test, activities, folds, seed)
        return utility_map(self.features, protocol, **{"halvings": 0} | more)

    some = some_windows


def site_windows(
    recordings: Sequence[ImuRecording],
    spec: WindowSpec,
    use: Use = "both",
    inputs: Literal["features", "windows"] = "features",
    view: Callable[[np.ndarray], np.ndarray] | None = None,
) -> SiteWindows:
    """Cut recordings of the same sites and rate into windows and describe these.

    `recordings`: each a clip with its labels.
    `use` {"both", "acc", "gyr"}: take no notice of the other kind, for sensors that lack it.
    `inputs` {"features", "windows"}: what the classifier takes (`utility.inputs_of`).
    `view`: what is made of windows (W, N, samples, 6) before anything else looks at them.
    Raises ValueError if no recording gives a window, or sites or rates differ.
    """
    if len({(recording.sites, recording.rate) for recording in recordings}) != 1:
        raise ValueError("recordings to be compared must share their sites and their rate")
    features, labels, is_test, skipped = [], [], [], {}
    for recording in recordings:
        unused = {"both": (), "acc": ("gyr",), "gyr": ("acc",)}[use]
        taken = replace(recording, **{name: np.zeros_like(recording.acc) for name in unused})
        try:
            windows = cut_windows(taken, spec)
        except TooShortError as error:
            skipped[recording.clip] = str(error)
            continue
        of_clip = windows.signals if view is None else view(windows.signals)
        features.append(window_features(of_clip, recording.rate) if inputs == "features" else of_clip)
        is_test.append(windows.is_test)
        labels += [(recording.activity, recording.clip, recording.subject)] * len(windows.is_test)
    if not features:
        raise ValueError(f"no clip gives a window: {next(iter(skipped.values()))}")
    activity, clip, subject = np.array(labels).T
    return SiteWindows(np.concatenate(features), activity, clip, subject, np.concatenate(is_test), skipped)
