# SPDX-License-Identifier: GPL-3.0-or-later
"""Numbers as text tables, and their units: what the text formats of recordings share."""

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from ..files import write_text
from ..wording import restated

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


def write_table(
    path: str | Path, head: list[str], names: Iterable[str], starts: Iterable, values: np.ndarray, mark: str
) -> None:
    """Write rows of what each starts with and its values, by enough digits to give single precision back.

    Lines of the head and the columns' names stand above them; `mark` separates fields.
    """
    rows = (
        mark.join([str(start), *(f"{value:.12g}" for value in row)])
        for start, row in zip(starts, values.tolist(), strict=True)
    )
    write_text(path, "\n".join([*head, mark.join(names), *rows]) + "\n")


def parse_fact(line: str) -> tuple[str, object]:
    """Name and value of a line above the table; what is not JSON is taken as text."""
    name, value = line.removeprefix("#").split(":", 1)
    try:
        return name.strip(), json.loads(value)
    except (ValueError, RecursionError):
        return name.strip(), value.strip()


def read_table(lines: list[str], mark: str, needed: Iterable[str], path: str | Path) -> dict[str, np.ndarray]:
    """Columns of a text table, float64, by the names in its first line; empty fields are NaN.

    Raises ValueError if one that is needed is not there, or a row is not whole.
    """
    names = [name.strip() for name in lines[0].split(mark)] if lines else []
    missing = [name for name in needed if name not in names]
    if missing:
        raise ValueError(f"{path} lacks the columns {', '.join(missing)}")
    rows = [line.split(mark) for line in lines[1:] if line.strip()]
    if not rows:
        raise ValueError(f"{path} holds no samples")
    for number, row in enumerate(rows, start=1):
        if len(row) != len(names):
            raise ValueError(f"{path}: row {number} has {len(row)} fields where its header has {len(names)}")
    with restated(f"{path} has a field that is no number:", ValueError):
        table = np.array([[field.strip() or "nan" for field in row] for row in rows], dtype=np.float64)
    return {name: table[:, names.index(name)] for name in names}


def one_sensor(columns: dict[str, np.ndarray], names: Iterable[str]) -> np.ndarray:
    """Some of a table's columns as one sensor's readings, shape (T, 1, columns)."""
    return np.stack([columns[name] for name in names], axis=1)[:, None]


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
