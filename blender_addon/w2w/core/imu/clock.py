# SPDX-License-Identifier: GPL-3.0-or-later
"""Clocks of sensors: times as tables and phones write them, and readings brought to one clock."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any

import numpy as np

from ..filtering import count_resampled, resample
from ..given import given_numbers
from ..motion.motion import LABELS
from ..wording import clean, restated
from .recording import READINGS, ImuRecording

SAME_RATE = 0.01
"""Share by which the rates of sensors may differ and count as one."""


def in_order(times: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Some rows of a table, by their times and one for each."""
    order = rows[np.argsort(times[rows], kind="stable")]
    return order[np.diff(times[order], prepend=-np.inf) > 0]


def shared_times(times: Sequence[np.ndarray], rate: float, shortest_s: float) -> np.ndarray:
    """Evenly spaced instants over the time that all sensors share.

    `times` (T,): increasing, s.
    Raises ValueError if they share less than `shortest_s`.
    """
    start, end = max(of[0] for of in times), min(of[-1] for of in times)
    if end - start < shortest_s:
        raise ValueError(f"its sensors share less than {shortest_s:g} s")
    return start + np.arange(int((end - start) * rate) + 1) / rate


def at_times(known: np.ndarray, values: np.ndarray, times: np.ndarray, longest_step_s: float) -> np.ndarray:
    """Straight lines between samples; NaN where samples were lost.

    `values` (T, K), `times` (M,).
    `known` (T,): when the samples were taken, increasing.
    `longest_step_s`: samples further apart have lost what was between them.
    Returns (M, K).
    """
    found = np.stack([np.interp(times, known, column) for column in values.T], axis=1)
    after = np.clip(np.searchsorted(known, times), 1, len(known) - 1)
    found[known[after] - known[after - 1] > longest_step_s] = np.nan
    return found


def at_rate(recording: ImuRecording, rate: float) -> ImuRecording:
    """Specific force and angular velocity at another rate, low-passed; what was lost stays lost."""
    if abs(recording.rate - rate) <= SAME_RATE * rate:
        return replace(recording, rate=rate)
    old, n, found = recording.time, recording.n_samples, []
    nearest = np.arange(count_resampled(n, recording.rate, rate)) * recording.rate / rate
    for values in (recording.acc, recording.gyr):
        flat = values.reshape(n, -1).astype(np.float64)
        lost = np.isnan(flat)
        for column, missing in zip(flat.T, lost.T, strict=True):
            if missing.any() and not missing.all():
                column[missing] = np.interp(old[missing], old[~missing], column[~missing])
        new = resample(flat.T, recording.rate, rate).T
        new[lost[np.clip(np.rint(nearest).astype(int), 0, n - 1)]] = np.nan
        found.append(new.reshape(-1, *values.shape[1:]))
    labels = {name: getattr(recording, name) for name in LABELS}
    return ImuRecording(found[0], found[1], rate, recording.sites, **labels)


CLOCKS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FASTEST_S, SLOWEST_S = 1 / 1100, 1 / 4.5
"""Steps between samples that a phone or watch has; no two units of time can both be right."""

USUAL_HZ = (5, 10, 12.5, 15, 16, 18, 20, 25, 30, 32, 40, 50, 52, 60, 64, 75, 80, 100, 104, 120, 125, 128, 200,
            208, 250, 256, 400, 416, 500, 512, 800, 1000)  # fmt: skip
LOST_S = 0.1
"""Samples further apart, or than four steps, have lost what was between them."""


def number_in(cell: str) -> float:
    """A number, with a point or a comma before its decimals; NaN for an empty field."""
    text = cell.strip().replace("\N{MINUS SIGN}", "-")
    if text.lower() in ("", "nan", "null", "na", "-"):
        return np.nan
    with restated(f"a field is no number: {clean(text[:20])}", ValueError):
        return float(text.replace(",", ".") if text.count(",") == 1 and "." not in text else text)


def seconds_of(cells: Sequence[str], name: str, unit: str) -> np.ndarray:
    """Times of a column in seconds from the first, whatever they count or however they are written."""
    first = next((cell.strip() for cell in cells if cell.strip()), "")
    if ":" in first or re.match(r"\d{4}-\d\d-\d\d", first):
        times = np.array([_clock(cell.strip()) for cell in cells])
        fell = np.concatenate([[0.0], np.cumsum(np.diff(times) < -43200)])
        times += 86400 * np.where(times < 86400, fell, 0)
        return times - times[0]
    if all(re.fullmatch(r"-?\d*", cell.strip()) for cell in cells):  # ns since 1970 are too long for a float
        times = np.array([float(int(cell) - int(first)) if cell.strip() else np.nan for cell in cells])
    else:
        times = np.array([*map(number_in, cells)])
    steps = np.diff(times[np.isfinite(times)])
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    fit = [size for size in (1.0, 1e-3, 1e-6, 1e-9) if FASTEST_S <= step * size <= SLOWEST_S]
    ending = re.search(r"[ _](ms|us|ns)$", name)
    said = CLOCKS.get(unit or (ending[1] if ending else ""))
    if not fit or said not in (None, fit[0]):
        raise ValueError(
            f"steps of {step:g} in the column '{name}' are no times of a sensor in {unit or 'any unit'}: "
            "say its unit in the header, as in 'time (ms)'"
        )
    return (times - times[np.isfinite(times)][0]) * fit[0]


def _clock(text: str) -> float:
    """Seconds of a date and time, or of a time of day with milliseconds after a colon or a point."""
    if day := re.fullmatch(r"(\d{1,2}):(\d\d):(\d\d)(?::(\d{1,3})|[.,](\d{1,9}))?", text):
        seconds = int(day[1]) * 3600 + int(day[2]) * 60 + int(day[3])
        return seconds + (int(day[4]) / 1000 if day[4] else float(f"0.{day[5] or 0}"))
    with restated(f"a time is none: {clean(text[:30])}", ValueError):
        plain = re.sub(r"\s+(?=[+-]\d\d:?\d\d$)", "", text).replace(",", ".")
        return datetime.fromisoformat(plain).timestamp()


def rate_of(times: np.ndarray) -> float:
    """Samples per second: the usual rate within 4 %, else whole."""
    steps = np.diff(times)
    held = steps[steps <= max(LOST_S, 4 * float(np.median(steps)))]
    rate = 1 / float(held.mean())
    usual = min(USUAL_HZ, key=lambda known: abs(np.log(known / rate)))
    return float(usual if abs(usual / rate - 1) <= 0.04 else max(round(rate), 1))


LONGEST_STEP_S = 0.1
"""Samples of a table that are further apart have lost what was between them."""


def triples(frame: Any, names: Sequence[str], kind: str) -> np.ndarray:
    """The readings of a kind, shape (rows, 3); zeros for angular velocity that is not there."""
    if kind in names:
        triples = given_numbers(list(frame[kind]), f"the column {kind}")
        if triples.shape != (len(frame), 3):
            raise ValueError(f"the column {kind} must hold three numbers a row: x, y and z")
        return triples
    channels = next(reading.channels for reading in READINGS if reading.name == kind)
    if not any(channel in names for channel in channels) and kind == "gyr":
        return np.zeros((len(frame), 3))
    if missing := [channel for channel in channels if channel not in names]:
        raise ValueError(f"the table lacks the columns {', '.join(missing)}")
    return np.stack([given_numbers(frame[one], f"the column {one}") for one in channels], axis=1)


def seconds(stamps: np.ndarray) -> np.ndarray:
    """Time stamps in seconds."""
    if stamps.dtype.kind in "mM":
        return (stamps - stamps.min()) / np.timedelta64(1, "s")
    found = given_numbers(stamps, "the column t")
    if not np.isfinite(found).all():
        raise ValueError("the column t lacks the time of some rows")
    return found


def resampled(
    of_place: Mapping[str, list[int]],
    seconds: np.ndarray,
    values: np.ndarray,
    rate: float,
    label: tuple[str, ...],
) -> ImuRecording:
    """One clip's sensors on one even clock."""
    known = {place: in_order(seconds, np.array(some)) for place, some in of_place.items()}
    with restated(f"{label[2]} is of no use:", ValueError):
        times = shared_times([seconds[rows] for rows in known.values()], rate, 2 / rate)
    longest = max(LONGEST_STEP_S, 2 / rate)
    found = [at_times(seconds[rows], values[rows], times, longest) for rows in known.values()]
    both = np.stack(found, axis=1)
    return ImuRecording(both[..., :3], both[..., 3:], rate, tuple(known)).labelled(tuple(known), *label)
