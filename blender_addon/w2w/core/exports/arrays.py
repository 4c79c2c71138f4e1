# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows as arrays that aeon, sktime and PyTorch take, and signals as one Parquet table.

The arrays are (windows, channels, time) with labels; the table has a row a sample and sensor.
"""

from pathlib import Path

import numpy as np

from ..files import atomic_write, write_json, write_text
from ..ranking.windows import TooShortError, cut_alike, cut_windows
from .study_signals import StudySignals

DATASET_FILE = "w2w_windows.py"

TABLE_FILE = "signals.parquet"

FRAMES = {
    "acc": "m/s2, sensor frame",
    "gyr": "rad/s, sensor frame",
    "orientation": "quaternion, sensor to world, z up",
    "magnetometer": "uT, sensor frame",
    "barometer": "Pa",
}

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


def write_arrays(folder: Path, signals: StudySignals) -> int:
    """Write X.npy, y.npy and the labels of each window; returns the number of windows.

    A ValueError says that no clip gives a window.
    """
    windows, labels, is_test = [], [], []
    spec = signals.config.windows
    for recording in signals.recordings():
        try:
            cut = cut_windows(recording, spec)
            parts = [cut.signals.transpose(0, 1, 3, 2)]
            parts += [cut_alike(values, recording, spec) for values in recording.further.values()]
        except TooShortError:
            continue
        count = len(cut.is_test)
        windows.append(np.concatenate(parts, axis=2).reshape(count, -1, cut.signals.shape[2]))
        labels += [(recording.activity, recording.clip, recording.subject)] * count
        is_test.append(cut.is_test)
        rate = recording.rate
    if not windows:
        raise ValueError("no clip of the run is long enough for a window")
    arrays = {"X": np.concatenate(windows).astype(np.float32, copy=False), "is_test": np.concatenate(is_test)}
    for name, column in zip(("y", "clip", "subject"), zip(*labels, strict=True), strict=True):
        arrays[name] = np.array(column, dtype=np.str_)
    for name, values in arrays.items():
        with atomic_write(folder / f"{name}.npy") as stream:
            np.lib.format.write_array(stream, values, allow_pickle=False)
    channels = [(channel, reading.unit) for reading in signals.readings for channel in reading.channels]
    names = [f"{place} {channel.replace('_', ' ')}" for place in signals.names for channel, _ in channels]
    facts = {
        "channels": names,
        "units": [unit for _, unit in channels] * len(signals.names),
        "classes": sorted({activity for activity, *_ in labels}),
        "rate_hz": rate,
        "sensor": signals.config.sensor,
        "window_s": spec.length_s,
        "stride_s": spec.stride_s,
    }
    write_json(folder / "facts.json", facts)
    return len(labels)


def write_torch(folder: Path, signals: StudySignals) -> int:
    """Write the arrays and a PyTorch dataset that reads them; returns the number of windows."""
    count = write_arrays(folder, signals)
    write_text(folder / DATASET_FILE, DATASET)
    return count


def write_parquet(folder: Path, signals: StudySignals) -> int:
    """Write clip, activity, subject, place, time_s, then the readings; returns the number of clips.

    A ValueError says how to get pyarrow where it is missing.
    """
    try:
        import pyarrow as arrow
        import pyarrow.parquet as parquet
    except ImportError as error:  # not there, or for another numpy
        raise ValueError(f"Parquet files are written by pyarrow (pip install pyarrow): {error}") from error
    words = arrow.dictionary(arrow.int32(), arrow.string())
    labels = ("clip", "activity", "subject", "place")
    channels = [channel for reading in signals.readings for channel in reading.channels]
    schema = arrow.schema(
        [
            *(arrow.field(name, words) for name in labels),
            arrow.field("time_s", arrow.float64()),
            *(arrow.field(name, arrow.float32()) for name in channels),
        ],
        {
            **{reading.name: FRAMES[reading.name] for reading in signals.readings},
            "sensor": signals.config.sensor,
        },
    )
    count = 0
    with parquet.ParquetWriter(folder / TABLE_FILE, schema) as writer:
        for recording in signals.recordings():
            n_samples, n_sensors = recording.n_samples, recording.n_sensors
            values = recording.values.transpose(1, 0, 2).reshape(-1, len(channels))
            one = [[recording.clip], [recording.activity], [recording.subject], list(recording.sites)]
            numbers = [np.zeros(n_samples * n_sensors, dtype=np.int32)] * 3
            numbers.append(np.repeat(np.arange(n_sensors, dtype=np.int32), n_samples))
            columns = [
                arrow.DictionaryArray.from_arrays(arrow.array(index), arrow.array(words_of, arrow.string()))
                for index, words_of in zip(numbers, one, strict=True)
            ]
            columns.append(arrow.array(np.tile(recording.time, n_sensors)))
            columns += [arrow.array(np.ascontiguousarray(column)) for column in values.T]
            writer.write_table(arrow.Table.from_arrays(columns, schema=schema))
            count += 1
    return count
