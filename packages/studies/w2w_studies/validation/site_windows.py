# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows of sensors at the same sites, as features."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal, NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.windows.inputs import cut_recordings
from w2w.core.windows.windows import WindowSpec

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
    unused = {"both": (), "acc": ("gyr",), "gyr": ("acc",)}[use]
    taken = [replace(one, **{name: np.zeros_like(one.acc) for name in unused}) for one in recordings]
    found = cut_recordings(taken, spec, inputs, view)
    skipped = {recordings[number].clip: why for number, why in found.skipped.items()}
    if not found.inputs:
        raise ValueError(f"no clip gives a window: {next(iter(skipped.values()))}")
    labels = [(one.activity, one.clip, one.subject) for one in (recordings[n] for n in found.used)]
    activity, clip, subject = np.repeat(np.array(labels).T, [len(mask) for mask in found.is_test], axis=1)
    features, is_test = np.concatenate(found.inputs), np.concatenate(found.is_test)
    return SiteWindows(features, activity, clip, subject, is_test, skipped)
