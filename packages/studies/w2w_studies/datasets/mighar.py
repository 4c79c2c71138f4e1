# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of the MIG HAR dataset: 396 sensors sewn into a garment, 12 people, 14 activities.

Tsukamoto, Yoshida, Yonezawa, Mase and Enokibori, UbiComp/ISWC Adjunct 2023 (doi:10.1145/3594739.3610736).
What is known here of the files was read in the data set's description and in its authors' reader; nothing
could be tried on the download itself. Where the sensors are is published as pictures alone, so
a user says it in a csv.
"""

import gzip
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, NamedTuple

import numpy as np

from w2w.core.csv_tables import read_table
from w2w.core.filtering import butterworth
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.trajectory import runs
from w2w.core.imu.vendor_formats import ACC_UNITS, GYR_UNITS

MIGHAR_SENSORS = 396
MIGHAR_ACTIVITIES = (
    "walking", "jogging", "goingupstairs", "goingdownstairs", "standing", "sitting", "typing", "writing",
    "eatingcookie", "eatingpasta", "ironing", "folding", "toothbrushing", "vacuuming",
)  # fmt: skip
"""Names of the folders below each subject's."""

MOVING = MIGHAR_ACTIVITIES[:4]
"""Begun from standing still, so that their first `SETTLING_S` are cut, as the data set's description asks."""

SETTLING_S = 2.0
FILE_RATE, MIGHAR_RATE = 100.0, 50.0
"""Hz of the files, and what they are brought to."""

BAND_HZ = 20.0
CHANNELS = 9
"""Columns of a sensor: accelerometer, gyroscope, magnetometer."""

LONGEST_GAP_S = 0.2
MOST_ROWS = 60_000
"""Ten minutes; an activity lasts 40 s."""


class WornAt(NamedTuple):
    """Where sensors of the garment are."""

    sensors: tuple[int, ...]  # their numbers, from 0, in the order of the files' columns
    sites: dict[str, str | int]
    """Words for regions of the body, or vertices of W2W's body, by the name of the site."""
    site_of: np.ndarray  # site of each sensor


def read_positions(path: str | Path) -> WornAt:
    """Read where the sensors are: a csv of columns sensor, region, vertex.

    `path`: rows with neither region nor vertex are passed over; sensors of one region, or vertex, are one
    site.
    Raises ValueError if it cannot be understood, or holds fewer than three sites; the message says where.
    """
    where: dict[int, str | int] = {}
    for number, row in read_table(path, ("sensor",), ("region", "vertex")).rows:
        if not (row["region"] or row["vertex"]):
            continue
        line = f"{path}, line {number}"
        if row["region"] and row["vertex"]:
            raise ValueError(f"{line}: give the sensor a region or a vertex, not both")
        sensor = _whole(row["sensor"], f"{line}: the sensor", MIGHAR_SENSORS - 1)
        if sensor in where:
            raise ValueError(f"{line}: sensor {sensor} is listed twice")
        where[sensor] = row["region"].lower() or _whole(row["vertex"], f"{line}: the vertex", 10**7)
    names = {place: f"vertex {place}" if isinstance(place, int) else place for place in where.values()}
    if len(names) < 3:
        raise ValueError(
            f"{path} places sensors at {len(names)} sites, and a ranking needs three: fill in region or "
            "vertex by the data set's pictures of the garment (imuposition_image)"
        )
    order = list(names)
    return WornAt(
        tuple(where),
        {name: place for place, name in names.items()},
        np.array([order.index(place) for place in where.values()]),
    )


def _whole(text: str, what: str, most: int) -> int:
    if not (text.isascii() and text.isdigit() and int(text) <= most):
        raise ValueError(f"{what} must be a whole number from 0 to {most}, not '{text}'")
    return int(text)


def read_mighar(
    folder: str | Path, sensors: Sequence[int]
) -> tuple[tuple[ImuRecording, ...], tuple[str, ...]]:
    """Read some sensors of every trial.

    `folder`: holds ``subject1`` to ``subject12``, or the folder ``data`` that does: in each a folder an
    activity with ``data1.csv.gz`` and ``data2.csv.gz``.
    `sensors`: numbers from 0, in the order of the columns.
    Returns `recordings`: at 50 Hz; gaps longer than 0.2 s are NaN; `left_out`: files that cannot be read,
    each with the reason.
    Raises ValueError if no file can be read.
    """
    folder = Path(folder)
    inside = folder / "data" if (folder / "data").is_dir() else folder
    recordings, left_out = [], []
    for path in sorted(inside.glob("subject*/*/data[12].csv.gz")):
        activity, subject = path.parts[-2], path.parts[-3]
        if activity not in MIGHAR_ACTIVITIES:
            left_out.append(f"{path.relative_to(inside)}: the data set has no activity '{activity}'")
            continue
        try:
            values = _resampled(_table(path, sensors), activity)
        except (ValueError, OSError, EOFError, zlib.error) as error:
            left_out.append(f"{path.relative_to(inside)}: {error}")
            continue
        names = tuple(f"sensor {sensor}" for sensor in sensors)
        clip = f"{subject} {activity} {path.name[4]}"
        acc, gyr = values[..., :3] * ACC_UNITS["g"], values[..., 3:] * GYR_UNITS["deg/s"]
        recordings.append(ImuRecording(acc, gyr, MIGHAR_RATE, names, activity, subject, clip))
    if not recordings:
        why = f"; the first of {len(left_out)} that cannot be read: {left_out[0]}" if left_out else ""
        raise ValueError(
            f"{folder} holds no subject1/walking/data1.csv.gz and so on of the MIG HAR dataset{why}"
        )
    return tuple(recordings), tuple(left_out)


def _table(path: Path, sensors: Sequence[int]) -> np.ndarray:
    """Accelerations and rates of some sensors, shape (T, P, 6); NaN where a reading is missing."""
    columns = [CHANNELS * sensor + channel for sensor in sensors for channel in range(6)]
    with gzip.open(path, "rt", encoding="utf-8") as stream:
        header = stream.readline(2**20).split(",")
        if len(header) != CHANNELS * MIGHAR_SENSORS:
            raise ValueError(f"it has {len(header)} columns, not {CHANNELS * MIGHAR_SENSORS}")
        table = np.loadtxt(
            _filled(stream), np.float32, delimiter=",", usecols=columns, ndmin=2, max_rows=MOST_ROWS + 1
        )
    if not FILE_RATE < len(table) <= MOST_ROWS:
        raise ValueError(f"it has {len(table)} rows: between {FILE_RATE:g} and {MOST_ROWS} are a recording")
    return table.reshape(len(table), len(sensors), 6)


def _filled(stream: IO[str]) -> Iterator[str]:
    """Lines whose empty cells say that they are no numbers."""
    for line in stream:
        text = f",{line.strip()},"
        while ",," in text:
            text = text.replace(",,", ",nan,")
        yield text[1:-1]


def _resampled(values: np.ndarray, activity: str) -> np.ndarray:
    """Readings at `MIGHAR_RATE`, less the start of what began from standing still."""
    if activity in MOVING:
        values = values[round(SETTLING_S * FILE_RATE) :]
    time = np.arange(len(values))
    lost = np.isnan(values).any(axis=2)
    if lost.all(axis=0).any():
        raise ValueError("a sensor has no reading")
    for sensor in np.flatnonzero(lost.any(axis=0)):
        known = ~lost[:, sensor]
        for channel in range(values.shape[2]):
            values[:, sensor, channel] = np.interp(time, time[known], values[known, sensor, channel])
    values = np.moveaxis(butterworth(np.moveaxis(values, 0, -1), FILE_RATE, BAND_HZ, zero_phase=True), -1, 0)
    for sensor in np.flatnonzero(lost.any(axis=0)):
        for start, stop in runs(lost[:, sensor]):
            if stop - start > LONGEST_GAP_S * FILE_RATE:
                values[start:stop, sensor] = np.nan
    return values[:: round(FILE_RATE / MIGHAR_RATE)]
