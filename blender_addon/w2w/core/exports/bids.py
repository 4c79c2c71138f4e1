# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's signals as a BIDS dataset with motion data (Brain Imaging Data Structure 1.9 and later)."""

import re
from collections import Counter, defaultdict
from collections.abc import Iterable
from itertools import chain, count
from pathlib import Path

from ..files import write_json, write_text
from ..imu.recording import ImuRecording
from .study_signals import StudySignals

SYSTEM = "imu"

TYPES = {
    "acc": ("ACCEL", "m/s^2", "sensor"),
    "gyr": ("GYRO", "rad/s", "sensor"),
    "orientation": ("ORNT", "n/a", "world"),
    "magnetometer": ("MAGN", "uT", "sensor"),
    "barometer": ("MISC", "Pa", "n/a"),
}
"""Reading -> BIDS's name of its channels, their unit and their frame."""

FRAMES = {
    "sensor": {"RotationRule": "right-hand", "Description": "The sensor's own axes"},
    "world": {"RotationRule": "right-hand", "Description": "z up; quaternions turn the sensor's axes to it"},
    "n/a": {"Description": "A reading without a direction"},
}

COLUMNS = {
    "participants.json": {"name": {"Description": "As the labels of the run call this person"}},
    "scans.json": {"clip": {"Description": "The clip of the run that this recording was simulated from"}},
}
"""File -> descriptions of the columns that BIDS does not know."""


def write_bids(folder: Path, signals: StudySignals) -> int:
    """Write a dataset, a folder a subject, a run a clip, tsv and json; returns the number of clips."""
    subjects = labels_of(clip.subject or "unknown" for clip in signals.study.clips)
    tasks = labels_of(clip.activity for clip in signals.study.clips)
    runs: Counter[tuple[str, str]] = Counter()
    scans: defaultdict[str, list[str]] = defaultdict(list)
    for recording in signals.recordings():
        subject, task = subjects[recording.subject or "unknown"], tasks[recording.activity]
        runs[subject, task] += 1
        motion = folder / f"sub-{subject}" / "motion"
        motion.mkdir(parents=True, exist_ok=True)
        stem = f"sub-{subject}_task-{task}_tracksys-{SYSTEM}_run-{runs[subject, task]}"
        values = recording.values.reshape(recording.n_samples, -1)
        cells = (("n/a" if value != value else f"{value:.9g}" for value in row) for row in values.tolist())
        # without a header, as BIDS wants it
        write_text(motion / f"{stem}_motion.tsv", "".join("\t".join(row) + "\n" for row in cells))
        write_text(motion / f"{stem}_channels.tsv", _channels(recording))
        # next to each: bids-validator 1.15 refuses one at the top that holds for all
        write_json(motion / f"{stem}_channels.json", {"reference_frame": {"Levels": FRAMES}})
        write_json(motion / f"{stem}_motion.json", _facts(recording, signals))
        scans[subject].append(f"motion/{stem}_motion.tsv\t{_cell(recording.clip)}")
    for subject, lines in scans.items():
        table = "\n".join(["filename\tclip", *lines]) + "\n"
        write_text(folder / f"sub-{subject}" / f"sub-{subject}_scans.tsv", table)
    people = [f"sub-{label}\t{_cell(name)}" for name, label in subjects.items()]
    write_text(folder / "participants.tsv", "\n".join(["participant_id\tname", *people]) + "\n")
    for name, columns in COLUMNS.items():
        write_json(folder / name, columns)
    description = {
        "Name": signals.config.title or "W2W: simulated inertial sensors",
        "BIDSVersion": "1.9.0",  # the first with motion data
        "DatasetType": "raw",
        "GeneratedBy": [{"Name": "W2W", "Description": "Signals are simulated from motion clips"}],
    }
    write_json(folder / "dataset_description.json", description)
    write_text(
        folder / "README",
        "Inertial sensors simulated by W2W from motion clips; no person wore them. Vectors are in the "
        "sensor's frame, quaternions turn it to a world whose z axis points up; acc is specific force.\n",
    )
    return len(signals.study.clips)


def labels_of(names: Iterable[str]) -> dict[str, str]:
    """A BIDS label of each name: letters and digits only, distinct even where case does not count."""
    label_of: dict[str, str] = {}
    used: set[str] = set()
    for name in sorted(set(names)):
        first, *others = re.findall(r"[0-9A-Za-z]+", name) or ["x"]
        plain = first + "".join(word[0].upper() + word[1:] for word in others)
        numbered = (f"{plain}{number}" for number in count(2))
        label_of[name] = next(label for label in chain([plain], numbered) if label.lower() not in used)
        used.add(label_of[name].lower())
    return label_of


def _channels(recording: ImuRecording) -> str:
    lines = ["name\tcomponent\ttype\ttracked_point\tunits\tplacement\treference_frame"]
    for site in recording.sites:
        point = site.replace(" ", "_")
        for reading in recording.readings:
            kind, unit, frame = TYPES[reading.name]
            for channel in reading.channels:
                axis = channel[-1] if channel[-2] == "_" else "n/a"
                component = channel if channel.startswith("quat") else axis
                lines.append(f"{point}_{channel}\t{component}\t{kind}\t{point}\t{unit}\t{site}\t{frame}")
    return "\n".join(lines) + "\n"


def _facts(recording: ImuRecording, signals: StudySignals) -> dict[str, object]:
    points = recording.n_sensors
    counts = {
        f"{TYPES[reading.name][0]}ChannelCount": len(reading.channels) * points
        for reading in recording.readings
    }
    return {
        "TaskName": recording.activity,
        "SamplingFrequency": recording.rate,
        "TrackingSystemName": SYSTEM,
        "Manufacturer": "W2W (simulated)",
        "ManufacturersModelName": signals.config.sensor,
        "MissingValues": "n/a",
        "TrackedPointsCount": points,
        "MotionChannelCount": sum(counts.values()),
        **counts,
        "RecordingDuration": (recording.n_samples - 1) / recording.rate,
    }


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip() or "n/a"
