# SPDX-License-Identifier: GPL-3.0-or-later
"""What a table of samples holds of recordings: readings, times, and its clips on one clock."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..given import given_numbers
from ..wording import restated
from .clock import at_times, in_order, shared_times
from .recording import READINGS, ImuRecording

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
