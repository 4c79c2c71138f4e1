# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of UP-Fall: 17 people, six daily activities and five falls, five worn sensors.

Martinez-Villasenor et al., Sensors 2019 (doi:10.3390/s19091988). What is known here of the file was read in
public programs that load it; tried on nine people's files of single trials, put together. All in SI units and
the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

import csv
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from w2w.core.imu.clock import at_times, shared_times
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.vendor_formats import ACC_UNITS, GYR_UNITS

UPFALL_FILE = "CompleteDataSet.csv"
TRIAL_FILES = "Subject*Activity*Trial*.csv"
UPFALL_RATE = 18.0
"""Hz that the readings are brought to; the rows come about 18 times a second, not evenly."""

UPFALL_SITES = ("ankle", "right pocket", "belt", "neck", "wrist")
UPFALL_ACTIVITIES = {
    6: "walking", 7: "standing", 8: "sitting", 9: "picking up an object", 10: "jumping", 11: "laying",
}  # fmt: skip
"""The daily ones; 1 to 5 are falls, and 20 stands where somebody was on their knees."""

KINDS = {"Accelerometer": ("(g)", ACC_UNITS["g"]), "AngularVelocity": ("(deg/s)", GYR_UNITS["deg/s"])}
FACTS = ("Subject", "Activity", "Trial")
LONGEST_STEP_S = 0.35
"""Rows further apart than this have lost what was between them."""

SHORTEST_S = 2.0
WRONG = "is not UP-Fall's CompleteDataSet.csv"

Row = tuple[float, list[float]]


def read_upfall(path: str | Path) -> tuple[tuple[ImuRecording, ...], tuple[str, ...]]:
    """Read the daily activities of UP-Fall.

    `path`: ``CompleteDataSet.csv``, or the folder that holds it or the trials' files as downloaded
    (``Subject1Activity6Trial1.csv``, at any depth): two lines of headings, then a time,
    the sensors' readings in g and degrees a second, and subject, activity and trial by number.
    Returns `recordings`: one a trial, five sites at 18 Hz; lost samples and sensors are NaN;
    `left_out`: trials of no use, each with the reason.
    Raises ValueError if it is no such file; the message says what is wrong with it.
    Raises OSError if it cannot be read.
    """
    path = Path(path)
    trials: dict[tuple[int, ...], list[Row]] = {}
    for file in _files(path):
        try:
            with file.open(newline="", encoding="utf-8-sig") as stream:
                trials |= _trials(file, csv.reader(stream))
        except (UnicodeDecodeError, csv.Error) as error:
            raise ValueError(f"{file} {WRONG}: it is no text of comma-separated cells") from error
    recordings, left_out = [], []
    for facts, rows in sorted(trials.items()):
        try:
            recordings.append(_recording(facts, rows))
        except ValueError as error:
            left_out.append(f"subject {facts[0]}, activity {facts[1]}, trial {facts[2]}: {error}")
    if not recordings:
        raise ValueError(f"{path} {WRONG}: no trial of a daily activity can be read")
    return tuple(recordings), tuple(left_out)


def _files(path: Path) -> list[Path]:
    """The one file of all trials, or a file of each."""
    if not path.is_dir():
        return [path]
    whole = path / UPFALL_FILE
    return [whole] if whole.exists() else sorted(path.rglob(TRIAL_FILES)) or [whole]


def _trials(path: Path, lines: Iterator[list[str]]) -> dict[tuple[int, ...], list[Row]]:
    """Times and readings of each subject, activity and trial; falls are passed over."""
    names, units = ([cell.strip() for cell in next(lines, [])] for _ in range(2))
    columns, facts = _columns(path, names, units)
    trials: dict[tuple[int, ...], list[Row]] = {}
    for number, cells in enumerate(lines, start=3):
        if not any(cells):
            continue
        try:
            who = tuple(int(cells[column]) for column in facts)
            if who[1] not in UPFALL_ACTIVITIES:
                continue
            seconds = datetime.fromisoformat(cells[names.index("TimeStamps")]).timestamp()
            values = [float(cells[column]) if cells[column].strip() else np.nan for column in columns]
        except (ValueError, IndexError) as error:
            raise ValueError(f"{path} is damaged: line {number}: {error}") from error
        trials.setdefault(who, []).append((seconds, values))
    return trials


def _columns(path: Path, names: Sequence[str], units: Sequence[str]) -> tuple[list[int], list[int]]:
    """Columns of the readings, site by site and kind by kind, and of the facts of a row."""
    if missing := [name for name in ("TimeStamps", *FACTS) if name not in names]:
        raise ValueError(f"{path} {WRONG}: its first line lacks {', '.join(missing)}")
    columns = []
    for site in UPFALL_SITES:
        for kind, (unit, _) in KINDS.items():
            name = f"{site.title().replace(' ', '')}{kind}"
            if name not in names:
                raise ValueError(f"{path} {WRONG}: its first line lacks {name}")
            first = names.index(name)
            wanted = [f"{axis}-axis {unit}" for axis in "xyz"]
            if list(units[first : first + 3]) != wanted:
                raise ValueError(
                    f"{path} {WRONG}: below {name} its second line must have {', '.join(wanted)}"
                )
            columns += range(first, first + 3)
    return columns, [names.index(name) for name in FACTS]


def _recording(facts: tuple[int, ...], rows: Sequence[Row]) -> ImuRecording:
    seconds = np.array([row[0] for row in rows])
    values = np.array([row[1] for row in rows])
    later = np.concatenate([[True], np.diff(np.maximum.accumulate(seconds)) > 0])
    worn = np.isfinite(values).any(axis=0)  # two people lack a sensor
    kept = later & np.isfinite(values[:, worn]).all(axis=1)
    if kept.sum() < 2:
        raise ValueError("it has no two whole rows")
    times = shared_times([seconds[kept] - seconds[0]], UPFALL_RATE, SHORTEST_S)
    found = at_times(seconds[kept] - seconds[0], values[kept], times, LONGEST_STEP_S)
    found = found.reshape(len(times), len(UPFALL_SITES), 2, 3)
    acc, gyr = (found[:, :, number] * factor for number, (_, factor) in enumerate(KINDS.values()))
    subject, activity, trial = facts
    return ImuRecording(
        acc, gyr, UPFALL_RATE, UPFALL_SITES, UPFALL_ACTIVITIES[activity], f"s{subject:02d}",
        f"s{subject:02d}_a{activity:02d}_t{trial}",
    )  # fmt: skip
