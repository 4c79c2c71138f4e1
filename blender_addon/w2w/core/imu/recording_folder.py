# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of recordings: its files, and the labels that a csv or the folders give them."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from ..csv_tables import read_table
from ..wording import shown
from .recording import ImuRecording

LABEL_FILE = "labels.csv"

SUFFIXES = (".npz", ".csv", ".txt")
X_IO = "Inertial.csv"
"""The file that makes a folder the log of an x-IMU3."""


def recording_files(folder: Path, labels: Path) -> Iterator[Path]:
    """Recordings in a folder, logs of an x-IMU3 as their folders."""
    for path in sorted(folder.rglob("*")):
        if (path / X_IO).is_file():
            yield path
            continue
        held = path.is_file() and path.suffix.lower() in SUFFIXES and not (path.parent / X_IO).is_file()
        if held and path.resolve() != labels.resolve():
            yield path


def label_rows(path: Path) -> dict[str, dict[str, str]]:
    """Rows of a csv of labels by the file or folder that they are about."""
    rows = {}
    for number, row in read_table(path, ("file", "activity"), ("subject", "clip", "place")).rows:
        if not row["file"] or not row["activity"]:
            raise ValueError(f"{shown(path)}, line {number}: a row needs a file and its activity")
        rows[row.pop("file").replace("\\", "/").strip("/")] = row
    return rows


def labelled_by(recording: ImuRecording, file: Path, rows: Mapping[str, Mapping[str, str]]) -> ImuRecording:
    """The recording with the labels of its row, else its own, else those of its folders."""
    paths = [file.as_posix(), *(parent.as_posix() for parent in file.parents)]
    told = next((rows[path] for path in paths if path in rows), None)
    if rows and told is None:
        raise ValueError("the labels do not list it")
    told = told or {}
    in_folders = [*file.parent.parts]
    clip = told.get("clip") or recording.clip or file.parent.as_posix()
    activity = told.get("activity") or recording.activity or (in_folders[0] if in_folders else "")
    place = told.get("place", "")
    sites = (place,) if place and recording.n_sensors == 1 else recording.sites or (file.stem,)
    if not activity:
        raise ValueError("nothing says its activity: list it in labels.csv, or put it into a folder named so")
    if clip == ".":
        clip = file.stem
    return recording.labelled(sites, activity, told.get("subject") or recording.subject, clip)
