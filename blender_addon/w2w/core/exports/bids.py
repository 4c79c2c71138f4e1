# SPDX-License-Identifier: GPL-3.0-or-later
"""A run's signals as a BIDS dataset with motion data (Brain Imaging Data Structure 1.9 and later)."""

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from ..files import write_json, write_text
from ..imu.recording import ImuRecording
from .study_signals import StudySignals

BIDS_VERSION = "1.9.0"
"""The first with motion data."""

SYSTEM = "imu"

TYPES = {
    "acc": ("ACCEL", "m/s^2"),
    "gyr": ("GYRO", "rad/s"),
    "orientation": ("ORNT", "n/a"),
    "magnetometer": ("MAGN", "uT"),
    "barometer": ("MISC", "Pa"),
}
"""Reading -> BIDS's name of its channels, and their unit."""

FRAMES = {
    "sensor": {"RotationRule": "right-hand", "Description": "The sensor's own axes"},
    "world": {"RotationRule": "right-hand", "Description": "z up; quaternions turn the sensor's axes to it"},
    "n/a": {"Description": "A reading without a direction"},
}

FRAME_OF = {"orientation": "world", "barometer": "n/a"}
"""Reading -> its reference frame where that is not the sensor's."""

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
    scans: dict[str, list[str]] = {}
    for recording in signals.recordings():
        subject, task = subjects[recording.subject or "unknown"], tasks[recording.activity]
        runs[subject, task] += 1
        motion = folder / f"sub-{subject}" / "motion"
        motion.mkdir(parents=True, exist_ok=True)
        stem = f"sub-{subject}_task-{task}_tracksys-{SYSTEM}_run-{runs[subject, task]}"
        write_text(motion / f"{stem}_motion.tsv", _samples(recording))
        write_text(motion / f"{stem}_channels.tsv", _channels(recording))
        # beside each: bids-validator 1.15 refuses one at the top that holds for all
        write_json(motion / f"{stem}_channels.json", {"reference_frame": {"Levels": FRAMES}})
        write_json(motion / f"{stem}_motion.json", _facts(recording, signals))
        scans.setdefault(subject, []).append(f"motion/{stem}_motion.tsv\t{_cell(recording.clip)}")
    for subject, lines in scans.items():
        table = "\n".join(["filename\tclip", *lines]) + "\n"
        write_text(folder / f"sub-{subject}" / f"sub-{subject}_scans.tsv", table)
    people = [f"sub-{label}\t{_cell(name)}" for name, label in subjects.items()]
    write_text(folder / "participants.tsv", "\n".join(["participant_id\tname", *people]) + "\n")
    for name, columns in COLUMNS.items():
        write_json(folder / name, columns)
    write_json(
        folder / "dataset_description.json",
        {
            "Name": signals.config.title or "W2W: simulated inertial sensors",
            "BIDSVersion": BIDS_VERSION,
            "DatasetType": "raw",
            "GeneratedBy": [{"Name": "W2W", "Description": "Signals are simulated from motion clips"}],
        },
    )
    write_text(
        folder / "README",
        "Inertial sensors simulated by W2W from motion clips; no person wore them. Vectors are in the "
        "sensor's frame, quaternions turn it to a world whose z axis points up; acc is specific force.\n",
    )
    return sum(runs.values())


def labels_of(names: Iterable[str]) -> dict[str, str]:
    """A BIDS label of each name: letters and digits only, distinct even where case does not count."""
    found: dict[str, str] = {}
    used: set[str] = set()
    for name in sorted(set(names)):
        words = re.findall(r"[0-9A-Za-z]+", name)
        plain = words[0] + "".join(word[:1].upper() + word[1:] for word in words[1:]) if words else "x"
        label, number = plain, 1
        while label.lower() in used:
            number += 1
            label = f"{plain}{number}"
        used.add(label.lower())
        found[name] = label
    return found


def _samples(recording: ImuRecording) -> str:
    """Rows of samples, columns as in the channels' table, without a header, as BIDS wants it."""
    values = recording.values.reshape(recording.n_samples, -1)
    return "".join(
        "\t".join("n/a" if value != value else f"{value:.9g}" for value in row) + "\n"
        for row in values.tolist()
    )


def _channels(recording: ImuRecording) -> str:
    lines = ["name\tcomponent\ttype\ttracked_point\tunits\tplacement\treference_frame"]
    for site in recording.sites:
        point = site.replace(" ", "_")
        for reading in recording.readings:
            kind, unit = TYPES[reading.name]
            frame = FRAME_OF.get(reading.name, "sensor")
            for channel in reading.channels:
                axis = channel[-1] if channel[-2] == "_" else "n/a"
                component = channel if channel.startswith("quat") else axis
                lines.append(f"{point}_{channel}\t{component}\t{kind}\t{point}\t{unit}\t{site}\t{frame}")
    return "\n".join(lines) + "\n"


def _facts(recording: ImuRecording, signals: StudySignals) -> dict[str, object]:
    counts = {
        f"{TYPES[reading.name][0]}ChannelCount": len(reading.channels) * recording.n_sensors
        for reading in recording.readings
    }
    return {
        "TaskName": recording.activity,
        "SamplingFrequency": recording.rate,
        "TrackingSystemName": SYSTEM,
        "Manufacturer": "W2W (simulated)",
        "ManufacturersModelName": signals.config.sensor,
        "MissingValues": "n/a",
        "TrackedPointsCount": recording.n_sensors,
        "MotionChannelCount": sum(counts.values()),
        **counts,
        "RecordingDuration": (recording.n_samples - 1) / recording.rate,
    }


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).strip() or "n/a"
