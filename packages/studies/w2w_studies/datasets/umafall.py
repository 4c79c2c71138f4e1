# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of UMAFall: 19 people, daily activities and falls, sensors on chest, waist, wrist and ankle.

All in SI units and the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from w2w.core.files import array_names, load_arrays
from w2w.core.imu.clock import at_times, shared_times
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.vendor_formats import ACC_UNITS, GYR_UNITS

UMAFALL_RATE = 20.0
UMAFALL_SITES = ("chest", "waist", "wrist", "ankle")
UMAFALL_ACTIVITIES = (
    "ClappingHands", "HandsUp", "MakingACall", "OpeningDoor", "Sitting_GettingUpOnAChair", "Walking",
    "Bending", "Hopping", "Jogging", "LyingDown_OnABed", "GoDownstairs", "GoUpstairs",
)  # fmt: skip
"""The daily ones (Casilari, Santoyo-Ramon and Cano-Garcia 2017, doi:10.1016/j.procs.2017.06.110)."""

COLUMNS = ("index", "subject", "kind", "activity", "trial")
LONGEST_STEP_S = 0.35
"""Samples further apart than this have lost what was between them; packets often come late."""

SHORTEST_S = 2.0
WRONG = "is no archive of UMAFall"


def read_umafall(path: str | Path) -> tuple[tuple[ImuRecording, ...], tuple[str, ...]]:
    """Read the daily activities of UMAFall.

    `path`: an npz of ``meta`` with its ``columns``, the scales ``acc_lsb_g`` and ``gyr_lsb_dps``, and for
    each trial and site ``000_CHEST_a`` and ``_g``, whole numbers (T, 3), with ``_a_t`` and ``_g_t``, seconds.
    Returns `recordings`: of the trials that have all four sites, at 20 Hz; lost samples are NaN; `left_out`:
    the others, each with the reason.
    Raises ValueError if it is no such file.
    """
    path = Path(path)
    try:
        held = array_names(path)
    except ValueError as error:
        raise ValueError(f"{path} {WRONG}: {error}") from error
    needed = {"meta", "columns", "acc_lsb_g", "gyr_lsb_dps"}
    if missing := sorted(needed - set(held)):
        raise ValueError(f"{path} {WRONG}: it lacks {', '.join(missing)}")
    data = load_arrays(path, held, WRONG)
    columns = np.atleast_1d(data["columns"]).astype(str).tolist()
    if data["meta"].ndim != 2 or data["meta"].shape[1] != len(columns) or not set(COLUMNS) <= set(columns):
        raise ValueError(f"{path} {WRONG}: meta must have the columns {', '.join(COLUMNS)}")
    recordings, left_out = [], []
    for row in data["meta"].astype(str).tolist():
        facts = dict(zip(columns, row, strict=True))
        if facts["activity"] not in UMAFALL_ACTIVITIES:
            continue
        try:
            recordings.append(_recording(data, facts))
        except ValueError as error:
            left_out.append(f"trial {facts['index']}: {error}")
    if not recordings:
        raise ValueError(f"{path} {WRONG}: no trial of a daily activity can be read")
    return tuple(recordings), tuple(left_out)


def _recording(data: Mapping[str, np.ndarray], facts: Mapping[str, str]) -> ImuRecording:
    number = facts["index"].zfill(3)
    streams = {}
    for site in UMAFALL_SITES:
        for kind in "ag":
            name = f"{number}_{site.upper()}_{kind}"
            streams[site, kind] = _stream(data, name)
    times = shared_times([known for known, _ in streams.values()], UMAFALL_RATE, SHORTEST_S)
    scale = {
        "a": float(data["acc_lsb_g"]) * ACC_UNITS["g"],
        "g": float(data["gyr_lsb_dps"]) * GYR_UNITS["deg/s"],
    }
    acc, gyr = (
        scale[kind]
        * np.stack([at_times(*streams[site, kind], times, LONGEST_STEP_S) for site in UMAFALL_SITES], axis=1)
        for kind in "ag"
    )
    clip = f"{facts['activity']} {facts['subject']} {number}"
    return ImuRecording(
        acc, gyr, UMAFALL_RATE, UMAFALL_SITES, facts["activity"], f"s{facts['subject']}", clip
    )


def _stream(data: Mapping[str, np.ndarray], name: str) -> tuple[np.ndarray, np.ndarray]:
    """Times (T,) and readings (T, 3) in order."""
    if name not in data or f"{name}_t" not in data:
        raise ValueError(f"it lacks {name}")
    values, times = data[name], data[f"{name}_t"].astype(np.float64)
    if values.ndim != 2 or values.shape[1] != 3 or times.shape != values.shape[:1] or len(times) < 2:
        raise ValueError(f"{name} must be (T, 3) with as many times, not {values.shape} and {times.shape}")
    if not (np.isfinite(times).all() and (np.diff(times) > 0).all()):
        raise ValueError(f"the times of {name} do not increase")
    return times, values.astype(np.float64)
