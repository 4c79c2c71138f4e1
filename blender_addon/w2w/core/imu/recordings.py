# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of worn sensors by clip and place: from arrays, from files, from a table."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from ..given import Clips, given_numbers, given_path
from ..motion.motion import LABELS
from ..wording import clean, join_words, plain_words
from .clock import SAME_RATE, at_rate, resampled, seconds, triples
from .formats import PHONE, format_of, read_recording
from .recording import ImuRecording
from .recording_folder import (
    LABEL_FILE,
    SUFFIXES,
    Known,
    all_but,
    label_rows,
    labelled_by,
    recording_files,
    tapped,
    without_hands,
)  # fmt: skip

if TYPE_CHECKING:
    from pandas import DataFrame


@dataclass(frozen=True, eq=False)
class Recordings(Clips[ImuRecording]):
    """Recordings of worn sensors, to be ranked as they are: no body and no motion is needed.

    Recordings of one clip at different places become one recording of all of them, cut to the shortest:
    sensors start together. If a place comes again, a new stretch of the clip begins. A sensor that a clip
    lacks is NaN.

    Parameters
    ----------
    recordings : sequence of ImuRecording
        Each of one sensor or several, with `sites`, `activity` and `clip`, and `subject` if it is known.
    skipped : tuple of (str, str)
        Files that could not be used, each with the reason.

    Raises
    ------
    ValueError
        If a recording lacks its place or activity, or rates differ; the message says which.

    Examples
    --------
    >>> at_rest = np.tile([0.0, 0.0, 9.81, 0.0, 0.0, 0.0], (100, 1))
    >>> shaken = at_rest + np.random.default_rng(0).normal(size=(100, 6))
    >>> worn = {"wrist": [at_rest, shaken], "my pocket": [at_rest, None]}
    >>> w2w.Recordings.from_arrays(worn, rate=50, activities=["still", "waving"])
    <Recordings: 2 of 2 activities at wrist, my pocket>
    """

    recordings: Sequence[ImuRecording]
    skipped: tuple[tuple[str, str], ...] = ()
    of_clips = ("recordings",)

    def __post_init__(self) -> None:
        given = list(self.recordings) if isinstance(self.recordings, Iterable) else []
        if not given or not all(isinstance(one, ImuRecording) for one in given):
            raise ValueError("there is no recording: give a list of ImuRecording, one at least")
        object.__setattr__(self, "recordings", tuple(_together(given)))

    @classmethod
    def from_arrays(
        cls,
        places: Mapping[str, Sequence[np.ndarray | None]],
        rate: float,
        activities: Sequence[str],
        subjects: Sequence[str] = (),
        clips: Sequence[str] = (),
    ) -> Self:
        """Make them from arrays.

        Parameters
        ----------
        places : mapping of str to sequence of ndarray, shape (T, 6)
            For each place an array per recording: specific force (m/s2), then angular velocity (rad/s); None
            where it was not worn.
        rate : float
            Samples per second.
        activities, subjects, clips : sequence of str
            One per recording. Recordings with one name in `clips` are stretches of one clip, and are never
            split between training and testing.

        Raises
        ------
        ValueError
            If numbers or shapes disagree; the message says which.
        """
        if not isinstance(places, Mapping) or not places:
            raise ValueError(
                f"places are given as {{'left wrist': [array, ...]}}, not as {type(places).__name__}"
            )
        given = {"activities": activities, **places, "subjects": subjects, "clips": clips}
        for name, entries in given.items():
            if isinstance(entries, str) or not isinstance(entries, Collection):
                raise ValueError(f"{name} must be a list with an entry per recording, not {entries!r}")
        count = len(activities)
        for name, entries in given.items():
            if len(entries) != count and (len(entries) or name in places):
                raise ValueError(f"{name} has {len(entries)} entries for {count} activities")
        recordings = []
        whose, of_clips = _texts(subjects) or [""] * count, _texts(clips)
        for number, activity in enumerate(_texts(activities)):
            labels = (activity, whose[number])
            clip = of_clips[number] if of_clips else f"recording {number + 1}"
            for place, arrays in places.items():
                if (worn := arrays[number]) is None:
                    continue
                values = given_numbers(worn, f"{clip} at {place}")
                if values.ndim != 2 or values.shape[1] != 6:
                    raise ValueError(f"{clip} at {place} must have shape (T, 6), not {values.shape}")
                acc, gyr = values[:, None, :3], values[:, None, 3:]
                recordings.append(ImuRecording(acc, gyr, rate, (place,), *labels, clip))
        return cls(recordings)

    @classmethod
    def from_frame(cls, frame: DataFrame, rate: float | None = None) -> Self:
        """Make them from a pandas table with a row per sample of a sensor.

        Parameters
        ----------
        frame : pandas.DataFrame
            Columns ``place``, ``clip``, ``t`` (seconds, one clock for all places of a clip), ``activity``;
            ``acc_x``, ``acc_y``, ``acc_z`` in m/s2 or ``acc`` with triples; likewise ``gyr`` in rad/s, and
            ``subject``, if they are known.
        rate : float, optional
            Samples per second to bring all to; that of most sensors by default.

        Raises
        ------
        ValueError
            If a column is missing, or sensors share no time; the message says which.
        """
        names = [str(name) for name in getattr(frame, "columns", ())]
        if missing := [name for name in ("place", "clip", "t", "activity") if name not in names]:
            raise ValueError(f"the table lacks the columns {', '.join(missing)}")
        values = np.concatenate([triples(frame, names, "acc"), triples(frame, names, "gyr")], axis=1)
        times = seconds(np.asarray(frame["t"]))
        texts = (_texts(frame[name]) if name in names else [""] * len(frame) for name in (*LABELS, "place"))
        rows: dict[tuple[str, ...], dict[str, list[int]]] = {}
        for number, (*label, place) in enumerate(zip(*texts, strict=True)):
            rows.setdefault(tuple(label), {}).setdefault(place, []).append(number)
        if rate is None:
            steps = [np.median(np.diff(times[some])) for of in rows.values() for some in of.values()]
            with np.errstate(divide="ignore"):
                rate = float(np.round(1 / np.median(steps), 2)) if steps else 0.0
        if not (isinstance(rate, Real) and np.isfinite(rate) and rate > 0):
            raise ValueError(
                f"the samples per second must be above 0, not {rate!r}; by default the steps of t say them"
            )
        return cls([resampled(of, times, values, rate, label) for label, of in rows.items()])

    @classmethod
    def read(
        cls,
        folder: str | Path,
        labels: str | Path | None = None,
        place: str = "",
        activities: Sequence[str] = (),
        rate: float | None = None,
    ) -> Self:
        """Read the recordings in a folder and its subfolders, in every format of `read_recording`.

        A label comes from the csv, else from the file itself, else from the folders:
        ``ACTIVITY/CLIP/PLACE.csv``. Of phones' files what lies between three taps on the sensor at rest
        counts, else all but three seconds at either end, where the phone was still, or again, in a hand.

        Parameters
        ----------
        folder : str or Path
        labels : str or Path, optional
            A csv with the columns ``file,activity[,subject][,clip][,place][,start][,end]``; ``labels.csv`` in
            the folder by default. `file` is a recording or a folder of them, as a path inside `folder`;
            `start` and `end` are seconds of it.
        place : str
            Where all were worn whose labels do not say it. Folders and file names then say activity and
            person: ``anna/walking.csv``.
        activities : sequence of str
            Activities that they may name; several in order, ``anna/walking sitting.csv``, if taps part them.
        rate : float, optional
            Samples per second to bring all to.

        Raises
        ------
        ValueError
            If no recording can be used; the message says why.
        """
        folder = given_path(folder, "a folder of recordings")
        if not folder.is_dir():
            raise ValueError(f"{clean(folder)} is no folder of recordings")
        table = given_path(labels, "a csv of labels") if labels is not None else folder / LABEL_FILE
        rows = label_rows(table) if labels is not None or table.is_file() else {}
        recordings, skipped, known = [], [], Known(place, activities)
        for path in recording_files(folder, table):
            file = path.relative_to(folder).as_posix()
            try:
                read, name, told = read_recording(path), path.relative_to(folder), rows
                if not rows and format_of(path, to_read=True) == PHONE:
                    taps = tapped(read, name, known)
                    told, read = ({file: taps}, read) if taps else (rows, without_hands(read))
                some = labelled_by(read, name, told, known)
                recordings += [one if rate is None else at_rate(one, rate) for one in some]
                if told is not rows:
                    skipped.append((file, all_but(told[file])))
            except (ValueError, OSError, KeyError) as error:
                skipped.append((file, str(error)))
        if not recordings:
            why = f"; {skipped[0][0]}: {skipped[0][1]}" if skipped else f": it holds no {', '.join(SUFFIXES)}"
            raise ValueError(f"no recording in {clean(folder)} can be used{why}")
        return cls(recordings, tuple(skipped))

    def __repr__(self) -> str:
        activities = {one.activity for one in self}
        return f"<Recordings: {len(self)} of {len(activities)} activities at {', '.join(self.places)}>"

    @property
    def places(self) -> tuple[str, ...]:
        """Where sensors were worn."""
        return self.recordings[0].sites

    @property
    def rate(self) -> float:
        """Samples per second."""
        return self.recordings[0].rate

    def at(self, *places: str) -> Self:
        """The recordings at some places, without clips that have none of them.

        Raises
        ------
        ValueError
            If no sensor was worn at one of them.
        """
        known = [plain_words(place) for place in self.places]
        if not places:
            raise ValueError(f"name a place at least; there are {', '.join(self.places)}")
        for place in places:
            if plain_words(place) not in known:
                raise ValueError(f"no sensor was worn at {place!r}; there are {', '.join(self.places)}")
        chosen = list(dict.fromkeys(known.index(plain_words(place)) for place in places))
        some = [one.at(chosen) for one in self]
        return replace(self, recordings=[one for one in some if not np.isnan(one.acc).all()])

    def lacking(self) -> dict[str, tuple[str, ...]]:
        """The places that clips lack, by the clip."""
        found: dict[str, dict[str, None]] = {}
        for one in self:
            for place in np.flatnonzero(np.isnan(one.acc).all(axis=(0, 2))).tolist():
                found.setdefault(one.clip, {})[self.places[place]] = None
        return {clip: tuple(places) for clip, places in found.items()}


def _together(given: Sequence[ImuRecording]) -> Iterator[ImuRecording]:
    """Recordings of all places, one for each stretch of a clip, in the order of the clips."""
    stretches: dict[str, list[dict[str, tuple[ImuRecording, int]]]] = {}
    rate, place_of = given[0].rate, dict[str, str]()
    for number, one in enumerate(given, start=1):
        clip = one.clip or f"recording {number}"
        if not one.activity:
            raise ValueError(f"{clip} has no activity: label it")
        if not all(one.sites) or not one.sites:
            raise ValueError(f"{clip} does not say where its sensors were worn: give it sites")
        if abs(one.rate - rate) > SAME_RATE * rate:
            raise ValueError(
                f"{clip} has {one.rate:g} samples per second and {given[0].clip or 'the first'} {rate:g}: "
                "bring all to one rate first"
            )
        parts = stretches.setdefault(clip, [{}])
        sites = [place_of.setdefault(plain_words(site), site) for site in one.sites]
        if not parts[-1].keys().isdisjoint(sites):
            parts.append({})
        parts[-1] |= {site: (one, sensor) for sensor, site in enumerate(sites)}
    for clip, parts in stretches.items():
        yield from (_stretch(clip, part, tuple(place_of.values()), rate) for part in parts)
        _check_labels(clip, parts)


def _stretch(
    clip: str, part: Mapping[str, tuple[ImuRecording, int]], places: tuple[str, ...], rate: float
) -> ImuRecording:
    length = min(one.n_samples for one, _ in part.values())
    arrays = np.full((2, length, len(places), 3), np.nan, dtype=np.float32)
    for site, (one, sensor) in part.items():
        for array, values in zip(arrays, (one.acc, one.gyr), strict=True):
            array[:, places.index(site)] = values[:length, sensor]
    first = next(iter(part.values()))[0]
    return ImuRecording(arrays[0], arrays[1], rate, places, first.activity, first.subject, clip)


def _check_labels(clip: str, parts: Sequence[Mapping[str, tuple[ImuRecording, int]]]) -> None:
    """Refuse a clip whose recordings have several activities or subjects."""
    for what in ("activity", "subject"):
        several = sorted({getattr(one, what) for part in parts for one, _ in part.values()})
        if len(several) > 1:
            raise ValueError(f"{clip} is labelled with more than one {what}: {join_words(several)}")


def _texts(values: Iterable[Any]) -> list[str]:
    """Labels as texts, "" for what a table lacks (None or NaN)."""
    return ["" if value is None or value != value else str(value) for value in values]
