# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of Berkeley MHAD's accelerometers: 12 people, 11 actions, 5 repetitions, six sites.

All in SI units and the conventions of `imu`: specific force in the sensor frame. There is no gyroscope.
"""

import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from w2w.core.files import array_names, load_arrays
from w2w.core.imu.clock import at_times, shared_times
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.vendor_formats import ACC_UNITS

MHAD_RATE = 30.0
"""Hz that the readings are brought to; the sensors send about 31 samples a second, not evenly."""

MHAD_SITES = ("left wrist", "right wrist", "left hip", "right hip", "left ankle", "right ankle")
"""h01 to h06."""

MHAD_ACTIONS = (
    "jump in place", "jumping jacks", "bend", "punch", "wave two hands", "wave right hand", "clap", "throw",
    "sit down then stand up", "sit down", "stand up",
)  # fmt: skip
"""a01 to a11 (Ofli, Chaudhry, Kurillo, Vidal and Bajcsy 2013, doi:10.1109/WACV.2013.6474999)."""

LONGEST_STEP_S = 0.2
"""Samples further apart than this have lost what was between them."""

RANGE_G = 2.0
"""The sensors read no more; single samples of up to 60 g are errors of transmission, and count as lost."""

SHORTEST_S = 0.5
"""Six sensors that share less time than this were not worn at once."""

KEY = re.compile(r"s(\d\d)_a(\d\d)_r(\d\d)_h(\d\d)")
WRONG = "is no archive of Berkeley MHAD's accelerometers"


def read_berkeley_mhad(path: str | Path) -> tuple[ImuRecording, ...]:
    """Read the accelerometers of Berkeley MHAD.

    `path`: an npz with an array ``s01_a01_r01_h01`` a subject, action, repetition and sensor, each (T, 4):
    seconds from the start, then x, y and z in g.
    One recording a subject, action and repetition: six sites at 30 Hz over the time that all of them share.
    Lost samples, and sites that the trial lacks, are NaN; angular velocity is 0 throughout.
    Raises ValueError if it is no such file; the message says what is wrong with it.
    """
    trials = _trials(Path(path))
    return tuple(_recording(path, name, trials[name]) for name in sorted(trials))


def _trials(path: Path) -> dict[str, dict[int, np.ndarray]]:
    """Readings (T, 4) by trial and number of the site, from 0."""
    try:
        names = [name for name in array_names(path) if KEY.fullmatch(name)]
    except ValueError as error:
        raise ValueError(f"{path} {WRONG}: {error}") from error
    if not names:
        raise ValueError(f"{path} {WRONG}: it holds no array named like s01_a01_r01_h01")
    for name in names:
        _, action, _, sensor = (int(number) for number in KEY.fullmatch(name).groups())
        if not (1 <= action <= len(MHAD_ACTIONS) and 1 <= sensor <= len(MHAD_SITES)):
            raise ValueError(
                f"{path} {WRONG}: {name} is of none of the actions a01 to a{len(MHAD_ACTIONS)} and sensors "
                f"h01 to h{len(MHAD_SITES):02d}"
            )
    trials: dict[str, dict[int, np.ndarray]] = defaultdict(dict)
    for name, table in load_arrays(path, names, WRONG).items():
        trial, _, sensor = name.rpartition("_h")
        trials[trial][int(sensor) - 1] = _checked(path, name, table)
    return trials


def _checked(path: Path, name: str, table: np.ndarray) -> np.ndarray:
    if table.ndim != 2 or table.shape[1] != 4 or len(table) < 2 or table.dtype.kind not in "iuf":
        raise ValueError(f"{path} {WRONG}: {name} must be (T, 4): t, x, y, z, not {table.shape}")
    table = table.astype(np.float64)
    if not np.isfinite(table).all():
        raise ValueError(f"{path} is damaged: {name} holds values that are not finite")
    table = table[(np.abs(table[:, 1:]) <= RANGE_G).all(axis=1)]
    if len(table) < 2:
        raise ValueError(f"{path} is damaged: {name} holds readings beyond {RANGE_G:g} g alone")
    if (np.diff(table[:, 0]) <= 0).any():
        raise ValueError(f"{path} is damaged: the times of {name} do not increase")
    return table


def _recording(path: str | Path, trial: str, tables: Mapping[int, np.ndarray]) -> ImuRecording:
    try:
        times = shared_times([table[:, 0] for table in tables.values()], MHAD_RATE, SHORTEST_S)
    except ValueError as error:
        raise ValueError(f"{path} is damaged: trial {trial} is of no use, {error}") from error
    acc = np.full((len(times), len(MHAD_SITES), 3), np.nan)
    for site, table in tables.items():
        acc[:, site] = at_times(table[:, 0], table[:, 1:], times, LONGEST_STEP_S) * ACC_UNITS["g"]
    subject, action, _ = trial.split("_")
    return ImuRecording(
        acc, np.zeros_like(acc), MHAD_RATE, MHAD_SITES, MHAD_ACTIONS[int(action[1:]) - 1], subject, trial
    )
