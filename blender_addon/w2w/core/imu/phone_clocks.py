# SPDX-License-Identifier: GPL-3.0-or-later
"""Clocks of what phones export: times in any unit or writing, and the rate that was meant."""

import re
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np

from ..wording import shown

CLOCKS = {"s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
FASTEST_S, SLOWEST_S = 1 / 1000, 1 / 4.5
"""Steps between samples that a phone or watch has; no two units of time can both be right."""

USUAL_HZ = (5, 10, 12.5, 15, 16, 18, 20, 25, 30, 32, 40, 50, 52, 60, 64, 75, 80, 100, 104, 120, 125, 128, 200,
            208, 250, 256, 400, 416, 500, 512, 800, 1000)  # fmt: skip
LOST_S = 0.1
"""Samples further apart, or than four steps, have lost what was between them."""


def number_in(cell: str, path: Path) -> float:
    text = cell.strip().replace("\N{MINUS SIGN}", "-")
    if not text or text.lower() in ("nan", "null", "na", "-"):
        return np.nan
    try:
        return float(text.replace(",", ".") if text.count(",") == 1 and "." not in text else text)
    except ValueError:
        raise ValueError(f"{shown(path.name)} has a field that is no number: {shown(text[:20])}") from None


def seconds_of(cells: Sequence[str], named: tuple[str, str], path: Path) -> np.ndarray:
    """Times in seconds from the first, whatever they count or however they are written."""
    first = next((cell.strip() for cell in cells if cell.strip()), "")
    if ":" in first or re.match(r"\d{4}-\d\d-\d\d", first):
        times = np.array([_clock(cell, path) for cell in cells])
        fell = np.concatenate([[0.0], np.cumsum(np.diff(times) < -43200)])
        times = times + 86400 * np.where(times < 86400, fell, 0)
        unit = 1.0
    else:
        start = int(re.sub(r"[.,].*", "", first) or 0) if re.match(r"-?\d+([.,]\d*)?$", first) else 0
        whole = all(re.fullmatch(r"-?\d*", cell.strip()) for cell in cells)
        # nanoseconds since 1970 have more digits than a double
        times = np.array([float(int(c) - start) if c.strip() else np.nan for c in cells] if whole else
                         [number_in(cell, path) for cell in cells])  # fmt: skip
        steps = np.diff(times[np.isfinite(times)])
        step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
        fit = [size for size in (1.0, 1e-3, 1e-6, 1e-9) if FASTEST_S * 0.9 <= step * size <= SLOWEST_S]
        ending = re.search(r"[ _](ms|us|ns)$", named[0])
        said = CLOCKS.get(named[1] or (ending[1] if ending else ""))
        if not fit or (said is not None and said != fit[0]):
            says = f" in {named[1]}" if named[1] else ""
            raise ValueError(
                f"{shown(path.name)}: steps of {step:g} in the column '{named[0]}'{says} are no times of a "
                "sensor: say its unit in the header, as in 'time (ms)'"
            )
        unit = fit[0]
    times = times * unit
    return times - times[np.isfinite(times)][0]


def _clock(cell: str, path: Path) -> float:
    """Seconds of a date and time, or of a time of day with milliseconds after a colon or a point."""
    text = cell.strip()
    if day := re.fullmatch(r"(\d{1,2}):(\d\d):(\d\d)(?:[:.,](\d{1,9}))?", text):
        return int(day[1]) * 3600 + int(day[2]) * 60 + int(day[3]) + float(f"0.{day[4] or 0}")
    try:
        plain = re.sub(r"\s+(?=[+-]\d\d:?\d\d$)", "", text).replace(",", ".")
        return datetime.fromisoformat(plain).timestamp()
    except ValueError:
        raise ValueError(f"{shown(path.name)} has a time that is none: {shown(text[:30])}") from None


def rate_of(times: np.ndarray, path: Path) -> float:
    """Samples per second: the usual rate within 4 %, else whole."""
    steps = np.diff(times)
    held = steps[steps <= max(LOST_S, 4 * float(np.median(steps)))]
    if len(held) < 2:
        raise ValueError(f"{shown(path.name)} holds too few samples")
    rate = 1 / float(held.mean())
    usual = min(USUAL_HZ, key=lambda known: abs(np.log(known / rate)))
    return float(usual if abs(usual / rate - 1) <= 0.04 else max(round(rate), 1))
