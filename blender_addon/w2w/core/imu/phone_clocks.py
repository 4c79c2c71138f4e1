# SPDX-License-Identifier: GPL-3.0-or-later
"""Clocks of what phones export: times in any unit or writing, and the rate that was meant."""

import re
from collections.abc import Sequence
from datetime import datetime

import numpy as np

from ..wording import clean, restated

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
