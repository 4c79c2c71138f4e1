# SPDX-License-Identifier: GPL-3.0-or-later
"""Windows as arrays (windows, channels, time) that aeon, sktime, PyTorch and Hugging Face take."""

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import TEMPLATES
from ..files import atomic_write, write_json, write_text
from ..imu.recording import READINGS
from ..windows.windows import TooShortError, cut_at_windows, cut_windows
from ..wording import restated
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
            cut = cut_windows(recording, spec)
            parts = [cut.signals.transpose(0, 1, 3, 2)]
            parts += [cut_at_windows(values, recording, spec) for values in recording.further.values()]
        except TooShortError:
            continue
        x = np.concatenate(parts, axis=2).reshape(len(cut.is_test), -1, cut.signals.shape[2])
        yield ClipArrays(
            clip=recording.clip, activity=recording.activity, subject=recording.subject,
            x=x.astype(np.float32, copy=False), starts=cut.starts, is_test=cut.is_test, rate=recording.rate,
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


PART_BYTES = 128 * 2**20
"""Signals in a file: the Hub asks for files that are neither many nor of gigabytes."""

GROUP_BYTES = 16 * 2**20
"""Signals in a row group, which readers hold in memory."""

CARD = TEMPLATES / "parquet_card.md"


def write_parquet(folder: Path, signals: StudySignals) -> int:
    """Write `data/part-00000.parquet` and further parts, one row per window, and the data set's card.

    Returns the number of windows. Raises ValueError if pyarrow is missing, with how to get it, or no clip
    gives a window.
    """
    # not there, or for another numpy
    with restated("Parquet files are written by pyarrow (pip install pyarrow):", ImportError):
        import pyarrow as arrow
        import pyarrow.parquet as parquet
    (folder / "data").mkdir(exist_ok=True)
    count, size, part, writer, facts = 0, 0, 0, None, None
    for group in _groups(signals):
        facts = facts_of(signals, group[0].rate)
        table = _table(arrow, group, facts)
        if writer is None or size > PART_BYTES:
            if writer is not None:
                writer.close()
            writer = parquet.ParquetWriter(folder / "data" / f"part-{part:05d}.parquet", table.schema)
            part, size = part + 1, 0
        writer.write_table(table)
        count, size = count + len(table), size + sum(clip.x.nbytes for clip in group)
    if writer is None or facts is None:
        raise ValueError("no clip of the run is long enough for a window")
    writer.close()
    kind = table.schema.field("signals").type
    channels = enumerate(zip(facts["channels"], facts["units"], strict=True))
    facts |= {
        "title": signals.config.title or "Simulated inertial sensors",
        "n_channels": kind.list_size,
        "n_samples": kind.value_type.list_size,
        "channels": "\n".join(f"{number}. {name}, {unit}" for number, (name, unit) in channels),
    }
    write_text(folder / "README.md", CARD.read_text(encoding="utf-8").format(**facts))
    return count


def _groups(signals: StudySignals) -> Iterator[list[ClipArrays]]:
    """The windows of some clips at a time."""
    group: list[ClipArrays] = []
    for clip in windows_of(signals):
        group.append(clip)
        if sum(member.x.nbytes for member in group) >= GROUP_BYTES:
            yield group
            group = []
    if group:
        yield group


def _table(arrow: Any, group: list[ClipArrays], facts: dict[str, Any]) -> Any:
    """A row a window; the channels and their units are in the table's metadata."""
    windows = joined(group)
    x = windows["x"]
    samples = arrow.FixedSizeListArray.from_arrays(arrow.array(x.ravel()), x.shape[2])
    columns = {name: arrow.array(windows[name]) for name in ("clip", "activity", "subject")}
    columns["start"] = arrow.array(windows["starts"].astype(np.int32))
    columns["is_test"] = arrow.array(windows["is_test"])
    columns["signals"] = arrow.FixedSizeListArray.from_arrays(samples, x.shape[1])
    metadata = {name: json.dumps(value) for name, value in facts.items()}
    return arrow.table(columns).replace_schema_metadata(metadata)
