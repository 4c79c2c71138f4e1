# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's windows as a data set of Parquet files, laid out as the Hugging Face Hub reads it."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import TEMPLATES
from ..files import write_text
from ..wording import restated
from .arrays import ClipArrays, facts_of, joined, windows_of
from .study_signals import StudySignals

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
