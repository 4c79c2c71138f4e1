# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows as arrays (windows, channels, time) that aeon, sktime and PyTorch take, with their labels."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import TEMPLATES
from ..files import atomic_write, write_json, write_text
from ..imu.recording import READINGS
from ..windows.windows import TooShortError, cut_at_windows, cut_windows, window_starts
from .study_signals import StudySignals

FILES = {"X": "x", "is_test": "is_test", "y": "activity", "clip": "clip", "subject": "subject"}
"""Files, and what of each window they hold."""

DATASET = TEMPLATES / "w2w_windows.py"


@dataclass(frozen=True, eq=False)
class ClipArrays:
    """The W windows of a clip."""

    clip: str
    activity: str
    subject: str
    x: np.ndarray  # (W, channels, samples), float32
    starts: np.ndarray  # (W,), int: the first sample of each
    is_test: np.ndarray  # (W,), bool
    rate: float


def windows_of(signals: StudySignals) -> Iterator[ClipArrays]:
    """The windows of each clip that is long enough for one, with all channels of `facts_of`."""
    spec = signals.config.windows
    for recording in signals.recordings():
        try:
            starts = window_starts(recording, spec)
            cut = cut_windows(recording, spec, starts)
            parts = [cut.signals.transpose(0, 1, 3, 2)]
            parts += [cut_at_windows(values, recording, spec) for values in recording.further.values()]
        except TooShortError:
            continue
        x = np.concatenate(parts, axis=2).reshape(len(cut.is_test), -1, cut.signals.shape[2])
        yield ClipArrays(
            clip=recording.clip, activity=recording.activity, subject=recording.subject,
            x=x.astype(np.float32, copy=False), starts=starts, is_test=cut.is_test, rate=recording.rate,
        )  # fmt: skip


def joined(clips: Sequence[ClipArrays]) -> dict[str, np.ndarray]:
    """Arrays and labels of several clips' windows, one row or label a window."""
    counts = [len(clip.x) for clip in clips]
    arrays, labels = ("x", "starts", "is_test"), ("clip", "activity", "subject")
    columns = {name: np.concatenate([getattr(clip, name) for clip in clips]) for name in arrays}
    return columns | {name: np.repeat([getattr(clip, name) for clip in clips], counts) for name in labels}


def facts_of(signals: StudySignals, rate: float) -> dict[str, Any]:
    """Names and units of the windows' channels, rate, sensor and length."""
    recorded = [kind for kind in READINGS if kind.name in ("acc", "gyr", *signals.config.further.record)]
    channels = [(channel, reading.unit) for reading in recorded for channel in reading.channels]
    words = [channel.replace("_", " ") for channel, _ in channels]
    spec = signals.config.windows
    return {
        "channels": [f"{place} {channel}" for place in signals.names for channel in words],
        "units": [unit for _, unit in channels] * len(signals.names),
        "rate_hz": rate,
        "sensor": signals.config.sensor,
        "window_s": spec.length_s,
        "stride_s": spec.stride_s,
    }


def write_arrays(folder: Path, signals: StudySignals) -> int:
    """Write X.npy, y.npy and the labels of each window; returns the number of windows.

    Raises ValueError if no clip gives a window.
    """
    clips = list(windows_of(signals))
    if not clips:
        raise ValueError("no clip of the run is long enough for a window")
    windows = joined(clips)
    for name, held in FILES.items():
        with atomic_write(folder / f"{name}.npy") as stream:
            np.lib.format.write_array(stream, windows[held], allow_pickle=False)
    classes = sorted({clip.activity for clip in clips})
    write_json(folder / "facts.json", {**facts_of(signals, clips[0].rate), "classes": classes})
    return len(windows["x"])


def write_torch(folder: Path, signals: StudySignals) -> int:
    """Write the arrays and a PyTorch dataset that reads them; returns the number of windows."""
    count = write_arrays(folder, signals)
    write_text(folder / DATASET.name, DATASET.read_text(encoding="utf-8"))
    return count
