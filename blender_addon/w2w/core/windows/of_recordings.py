# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows of many recordings, simulated or worn, as what a classifier takes of them."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from ..imu.recording import ImuRecording
from .features import window_features
from .windows import TooShortError, WindowSpec, cut_windows


class CutRecordings(NamedTuple):
    """Windows of the recordings that give some."""

    used: list[int]  # the numbers of these recordings
    inputs: list[np.ndarray]  # of each: features (W, N, D), or windows (W, N, samples, 6)
    is_test: list[np.ndarray]  # of each: the mask (W,) of test windows
    skipped: dict[int, str]  # the numbers of the others, each with the reason


def cut_recordings(
    recordings: Sequence[ImuRecording],
    spec: WindowSpec,
    inputs: str = "features",
    view: Callable[[np.ndarray], np.ndarray] | None = None,
) -> CutRecordings:
    """Cut recordings into windows and describe these.

    `inputs` {"features", "windows"} is what the classifier takes (`utility.inputs_of`); `view` is what is
    made of windows (W, N, samples, 6) before anything else looks at them.
    """
    found = CutRecordings([], [], [], {})
    for number, recording in enumerate(recordings):
        try:
            windows = cut_windows(recording, spec)
        except TooShortError as error:
            found.skipped[number] = str(error)
            continue
        cut = windows.signals if view is None else view(windows.signals)
        found.inputs.append(window_features(cut, recording.rate) if inputs == "features" else cut)
        found.is_test.append(windows.is_test)
        found.used.append(number)
    return found
