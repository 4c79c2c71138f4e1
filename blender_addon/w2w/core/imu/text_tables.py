# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as text tables, and their units: what the text formats of recordings share."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

ACC_UNITS = {"m/s2": 1.0, "g": 9.80665}
"""Units of specific force, in m/s2."""

GYR_UNITS = {"rad/s": 1.0, "deg/s": np.pi / 180}
"""Units of angular velocity, in rad/s."""

REGULARITY = 0.1
"""Largest deviation of a time stamp from a regular grid, in sample intervals."""


def text_lines(path: str | Path) -> list[str]:
    """Lines of a UTF-8 text, ended by line feeds alone: labels may hold other separators."""
    return Path(path).read_text(encoding="utf-8-sig").rstrip("\n").split("\n")


def unit_factor(units: dict[str, float], unit: str, name: str) -> float:
    if unit not in units:
        raise ValueError(f"{name} must be one of {', '.join(units)}, not {unit!r}")
    return units[unit]


def table_text(starts: Iterable[object], values: np.ndarray, separator: str) -> str:
    """Rows of what each begins with and its values, by enough digits to give single precision back."""
    return "".join(
        separator.join([str(start), *(f"{value:.12g}" for value in row)]) + "\n"
        for start, row in zip(starts, values.tolist(), strict=True)
    )


def parse_fact(line: str) -> tuple[str, object]:
    """Name and value of a line above the table; what is not JSON is taken as text."""
    name, value = line.removeprefix("#").split(":", 1)
    try:
        return name.strip(), json.loads(value)
    except json.JSONDecodeError:
        return name.strip(), value.strip()


def read_numbers(lines: list[str], separator: str, n_columns: int, path: str | Path) -> np.ndarray:
    """Numbers of a text table, shape (rows, columns), float64; empty fields are NaN."""
    rows = [line.split(separator) for line in lines if line.strip()]
    if not rows:
        raise ValueError(f"{path} holds no samples")
    for number, row in enumerate(rows, start=1):
        if len(row) != n_columns:
            raise ValueError(f"{path}: row {number} has {len(row)} fields where its header has {n_columns}")
    try:
        return np.array([[field.strip() or "nan" for field in row] for row in rows], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{path} has a field that is no number: {error}") from error


def rate_of_stamps(stamps: np.ndarray, path: str | Path, resolution: float) -> float:
    """Sample rate of regular time stamps in seconds, the roundest that their resolution allows."""
    if len(stamps) < 2 or not stamps[-1] > stamps[0]:
        raise ValueError(f"{path} does not say its rate, and its time stamps do not grow")
    n_steps, span = len(stamps) - 1, stamps[-1] - stamps[0]
    rate = n_steps / span
    grid = stamps[0] + np.arange(len(stamps)) / rate
    if np.abs(stamps - grid).max() * rate > REGULARITY:
        raise ValueError(f"{path} has irregular time stamps: resample it to a fixed rate first")
    rounder = (round(rate, digits) for digits in range(4))
    return float(next((r for r in rounder if r > 0 and abs(n_steps / r - span) <= 2 * resolution), rate))
