# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows as arrays (windows, channels, time) that aeon, sktime and PyTorch take, with their labels."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..files import atomic_write, write_json, write_text
from ..ranking.windows import TooShortError, cut_alike, cut_windows, window_starts
from .study_signals import StudySignals

DATASET_FILE = "w2w_windows.py"

ARRAYS = {"X": "x", "is_test": "is_test"}
LABELS = {"y": "activity", "clip": "clip", "subject": "subject"}
"""Files, and what of each clip's windows they hold."""

DATASET = '''"""The windows of this folder for PyTorch; needs numpy and torch, not W2W.

    from w2w_windows import Windows
    loader = torch.utils.data.DataLoader(Windows(".", train=True), batch_size=64, shuffle=True)

Windows of one clip overlap and are alike: split by `clips`, never by window. `train=True` gives all windows
of the clips, `train=False` only those that do not overlap one another, to test on.
"""

import json
from pathlib import Path

import numpy as np
import torch


class Windows(torch.utils.data.Dataset):
    """Pairs of a window (channels, time), float32, and its activity's number in `classes`."""

    def __init__(self, folder, clips=None, train=True):
        folder = Path(folder)
        self.x = np.load(folder / "X.npy", mmap_mode="r")
        facts = json.loads((folder / "facts.json").read_text(encoding="utf-8"))
        self.classes, self.channels, self.rate = facts["classes"], facts["channels"], facts["rate_hz"]
        labels, clip = np.load(folder / "y.npy"), np.load(folder / "clip.npy")
        number = {name: k for k, name in enumerate(self.classes)}
        wanted = np.ones(len(labels), bool) if clips is None else np.isin(clip, list(clips))
        if not train:
            wanted &= np.load(folder / "is_test.npy")
        self.rows = np.flatnonzero(wanted)
        self.y = np.array([number[name] for name in labels])[self.rows]
        self.clips = clip[self.rows]
        self.subjects = np.load(folder / "subject.npy")[self.rows]

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        window = torch.from_numpy(np.array(self.x[self.rows[index]]))
        return window, int(self.y[index])
'''


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
            parts += [cut_alike(values, recording, spec) for values in recording.further.values()]
        except TooShortError:
            continue
        x = np.concatenate(parts, axis=2).reshape(len(cut.is_test), -1, cut.signals.shape[2])
        labels = recording.clip, recording.activity, recording.subject
        yield ClipArrays(*labels, x.astype(np.float32, copy=False), starts, cut.is_test, recording.rate)


def facts_of(signals: StudySignals, rate: float) -> dict[str, Any]:
    """What the windows hold: names and units of channels, rate, sensor, length."""
    channels = [(channel, reading.unit) for reading in signals.readings for channel in reading.channels]
    spec = signals.config.windows
    return {
        "channels": [
            f"{place} {channel.replace('_', ' ')}" for place in signals.names for channel, _ in channels
        ],
        "units": [unit for _, unit in channels] * len(signals.names),
        "rate_hz": rate,
        "sensor": signals.config.sensor,
        "window_s": spec.length_s,
        "stride_s": spec.stride_s,
    }


def write_arrays(folder: Path, signals: StudySignals) -> int:
    """Write X.npy, y.npy and the labels of each window; returns the number of windows.

    A ValueError says that no clip gives a window.
    """
    clips = list(windows_of(signals))
    if not clips:
        raise ValueError("no clip of the run is long enough for a window")
    counts = [len(clip.x) for clip in clips]
    arrays = {name: np.concatenate([getattr(clip, of) for clip in clips]) for name, of in ARRAYS.items()}
    for name, of in LABELS.items():
        arrays[name] = np.repeat(np.array([getattr(clip, of) for clip in clips], dtype=np.str_), counts)
    for name, values in arrays.items():
        with atomic_write(folder / f"{name}.npy") as stream:
            np.lib.format.write_array(stream, values, allow_pickle=False)
    classes = sorted({clip.activity for clip in clips})
    write_json(folder / "facts.json", {**facts_of(signals, clips[0].rate), "classes": classes})
    return sum(counts)


def write_torch(folder: Path, signals: StudySignals) -> int:
    """Write the arrays and a PyTorch dataset that reads them; returns the number of windows."""
    count = write_arrays(folder, signals)
    write_text(folder / DATASET_FILE, DATASET)
    return count
