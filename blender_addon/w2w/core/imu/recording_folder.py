# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder of recordings: its files, and their labels by a csv, folders or by triple taps, and outlines."""

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..csv_tables import read_table
from ..library.labels import same_label
from ..wording import clean, count, join_words, restated
from .formats import read_recording
from .phone_files import is_phone_folder
from .recording import ImuRecording

LABEL_FILE = "labels.csv"

SUFFIXES = (".npz", ".csv", ".txt")
X_IO = "Inertial.csv"
"""The file that makes a folder the log of an x-IMU3."""


IN_HAND_S = 3.0
"""Seconds at either end of a phone's recording in which it is still put in place, or taken off."""


class Known(NamedTuple):
    """What is known of all recordings of a folder."""

    place: str = ""  # where each was worn whose labels do not say it; paths then say activity and person
    activities: Sequence[str] = ()  # that paths may name


def recording_files(folder: Path, labels: Path) -> Iterator[Path]:
    """Recordings in a folder; those in several files, of an x-IMU3 or a phone, as their folders."""
    inside: list[Path] = []
    for path in sorted(folder.rglob("*")):
        if any(path.is_relative_to(one) for one in inside):
            continue
        if (path / X_IO).is_file() or is_phone_folder(path):
            inside.append(path)
            yield path
        elif path.is_file() and path.suffix.lower() in SUFFIXES and path.resolve() != labels.resolve():
            yield path


def label_rows(path: Path) -> dict[str, list[dict[str, str]]]:
    """Rows of a csv of labels by the file or folder that they are about, several for stretches of one."""
    rows: dict[str, list[dict[str, str]]] = {}
    optional = ("subject", "clip", "place", "start", "end")
    for number, row in read_table(path, ("file", "activity"), optional).rows:
        if not row["file"] or not row["activity"]:
            raise ValueError(f"{clean(path)}, line {number}: a row needs a file and its activity")
        rows.setdefault(row.pop("file").replace("\\", "/").strip("/"), []).append(row)
    return rows


def labelled_by(
    recording: ImuRecording, file: Path, rows: Mapping[str, Sequence[Mapping[str, str]]], known: Known
) -> Iterator[ImuRecording]:
    """The recording, or stretches of it, by the labels of its rows, else its own, else those of its path."""
    paths = [file.as_posix(), *(parent.as_posix() for parent in file.parents)]
    told = next((rows[path] for path in paths if path in rows), None)
    if rows and told is None:
        raise ValueError("the labels do not list it")
    for row in told or ({},):
        yield _labelled(_stretch(recording, row), file, row, known)


def _labelled(recording: ImuRecording, file: Path, told: Mapping[str, str], known: Known) -> ImuRecording:
    by_path = told.get("clip") or recording.clip or file.parent.as_posix()
    activity = told.get("activity") or recording.activity or next(iter(file.parent.parts), "")
    subject, place = told.get("subject") or recording.subject, told.get("place", "")
    sites = (place,) if place and recording.n_sensors == 1 else recording.sites or (file.stem,)
    if known.place:
        if not told and not recording.activity:
            named, who = _by_words(file, known.activities)
            if len({*named}) > 1:
                raise ValueError(
                    f"its path names {join_words(named)}, and no triple taps say which is when: list its "
                    f"stretches in {LABEL_FILE}"
                )
            activity, subject = named[0], subject or who
        sites = (place or known.place,) * recording.n_sensors
        by_path = told.get("clip") or recording.clip or file.with_suffix("").as_posix()
    if not activity:
        raise ValueError("nothing says its activity: list it in labels.csv, or put it into a folder named so")
    clip = file.stem if by_path == "." else by_path
    start = told.get("start", "")
    return recording.labelled(sites, activity, subject, f"{clip} from {start} s" if start else clip)


def _stretch(recording: ImuRecording, row: Mapping[str, str]) -> ImuRecording:
    """What lies between the seconds that a row names; all of it without."""
    if not (row.get("start") or row.get("end")):
        return recording
    with restated("start and end are seconds of the file:", ValueError):
        start, end = (float(row.get(name) or other) for name, other in (("start", 0.0), ("end", "inf")))
    length = recording.n_samples / recording.rate
    if not 0 <= start < min(end, length):
        raise ValueError(f"it lasts {length:.0f} s: {start:g} to {end:g} s is no part of it")
    return recording.between(round(start * recording.rate), round(min(end, length) * recording.rate))


def without_hands(recording: ImuRecording) -> ImuRecording:
    """The recording without its ends, if three quarters of it are left or more."""
    ends = round(IN_HAND_S * recording.rate) if recording.time[-1] >= 8 * IN_HAND_S else 0
    return recording.between(ends, recording.n_samples - ends)


def tapped(recording: ImuRecording, file: Path, known: Known) -> list[dict[str, str]]:
    """Rows of a recording's stretches between triple taps, of the activities that its path names, in order.

    None without taps; three mark the start or end of an activity, or the step from one to the next.
    """
    taps, names, who = triple_taps(recording), [""], ""
    if taps and known.place and not recording.activity:
        names, who = _by_words(file, known.activities)
    if len(taps) not in (0, len(names) + 1, 2 * len(names)):
        raise ValueError(
            f"it has {count('triple tap', len(taps))}: tap at start and end of all {len(names)} that its "
            f"path names, in order, or from one to the next; or list its stretches in {LABEL_FILE}"
        )
    ends = [*pairwise(taps)][:: 2 if len(taps) == 2 * len(names) else 1]
    return [
        {"activity": name, "subject": who, "start": f"{start:.2f}", "end": f"{end:.2f}"}
        for name, ((_, start), (end, _)) in zip(names, ends, strict=bool(taps))
    ]


def all_but(rows: Sequence[Mapping[str, str]]) -> str:
    """What taps leave out, in words."""
    spans = [f"{row['start']} to {row['end']} s {row['activity']}".strip() for row in rows]
    return f"all but {join_words(spans, len(spans))}, by its triple taps"


def _by_words(file: Path, activities: Sequence[str]) -> tuple[list[str], str]:
    """The activities that a path names, in order, and who the innermost other folder, or file, names."""
    known = {same_label(one): one for one in activities}
    longest = sorted(map(re.escape, known), key=len, reverse=True)
    naming = re.compile(rf"(?<![^_])({'|'.join(longest) or '(?!)'})(?![^_])")
    labels = [same_label(part) for part in (*file.parent.parts, file.stem)]
    parts = [part if part in known else re.sub(r"[\W\d_]+", "_", part) for part in labels]
    found = [naming.findall(part) for part in parts]
    order: list[str] = next(filter(None, reversed(found)), [])
    if not order or any(name not in " ".join(order) for names in found for name in names):
        named = join_words(sorted({name for names in found for name in names}))
        what = f"names {named}" if named else "names no activity of the study"
        raise ValueError(
            f"its path {what}: name a folder {join_words(list(activities), 9)}, or use {LABEL_FILE}"
        )
    others = [folder for folder, names in zip(file.parent.parts, found, strict=False) if not names]
    rest = re.sub(r"[\W\d_]+", " ", naming.sub("_", parts[-1])).strip()
    return [known[name] for name in order], others[-1] if others else rest


SPIKE, REST = 3.0, 0.5
"""How far specific force goes from its median in a tap, and how little 19 of 20 samples around do, m/s2."""

APART_S = 0.15, 0.9
"""Seconds from one tap to the next."""

STILL_S, HAND_S, TAP_S = 1.0, 0.5, 0.1
"""Seconds of rest before and after three taps, those in which a hand comes or goes, and each tap's own."""

SLOWEST_HZ = 40.0
"""At fewer samples per second a tap may lie between two."""


def triple_taps(recording: ImuRecording) -> list[tuple[float, float]]:
    """From when to when each three taps on the first sensor take a hand, s.

    None were found in 52 hours of eight data sets' sensors worn in daily life, sports and falls.
    """
    rate, acc = recording.rate, recording.acc[:, 0].astype(float)
    if rate < SLOWEST_HZ:
        return []
    size = np.nan_to_num(np.linalg.norm(acc, axis=1), nan=np.nanmedian(np.linalg.norm(acc, axis=1)))
    far = np.abs(size - scipy.ndimage.median_filter(size, round(rate / 4) | 1))
    peaks = scipy.signal.find_peaks(far, SPIKE, distance=max(round(TAP_S * rate), 1))[0]
    times, at = np.arange(len(size)) / rate, peaks / rate
    gaps = np.diff(at, prepend=-np.inf, append=np.inf)
    found = []
    for first in range(len(at) - 2):
        before, *between, after = gaps[first : first + 4]
        if min(before, after) < STILL_S or not all(APART_S[0] <= gap <= APART_S[1] for gap in between):
            continue
        three = at[first : first + 3]
        around = (times >= three[0] - STILL_S) & (times < three[2] + STILL_S)
        still = size[around & (np.abs(times[:, None] - three).min(axis=1) > TAP_S)]
        if np.quantile(np.abs(still - np.median(still)), 0.95) <= REST:
            found.append((float(three[0]) - HAND_S, float(three[2]) + HAND_S))
    return found


PIECES = 400


def outlines(folder: Path) -> dict[str, Any]:
    """Each recording in a folder as plain values, and what cannot be read, with the reason."""
    shown, skipped = [], []
    for path in recording_files(folder, folder / LABEL_FILE):
        file = path.relative_to(folder).as_posix()
        try:
            shown.append({"file": file} | _outline(read_recording(path)))
        except (ValueError, OSError, KeyError) as error:
            skipped.append((file, str(error)))
    return {"recordings": shown, "skipped": skipped}


def _outline(recording: ImuRecording) -> dict[str, Any]:
    """Seconds of a recording, and least and most specific force of its first sensor in each piece, m/s2."""
    size = np.linalg.norm(recording.acc[:, 0].astype(float), axis=1)
    first = np.unique(np.arange(PIECES) * len(size) // PIECES)
    ends = np.stack([of.reduceat(size, first) for of in (np.fmin, np.fmax)], axis=1).round(2)
    known = [pair.tolist() if np.isfinite(pair).all() else None for pair in ends]
    return {"seconds": round(recording.n_samples / recording.rate, 2), "signal": known}
