# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's signals as one Parquet table: a row a sample and sensor."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from .study_signals import StudySignals

FILE = "signals.parquet"

FRAMES = {
    "acc": "m/s2, sensor frame",
    "gyr": "rad/s, sensor frame",
    "orientation": "quaternion, sensor to world, z up",
    "magnetometer": "uT, sensor frame",
    "barometer": "Pa",
}


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
    with parquet.ParquetWriter(folder / FILE, schema) as writer:
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
            columns += [
                arrow.array(np.ascontiguousarray(values[:, channel])) for channel in range(len(channels))
            ]
            writer.write_table(arrow.Table.from_arrays(columns, schema=schema))
            count += 1
    return count
