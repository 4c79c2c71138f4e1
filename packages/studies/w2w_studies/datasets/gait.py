# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of a gait trial: worn Xsens sensors and the wearer's Vicon joints (gaittoolbox's files).

All in SI units and the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording


class GaitTrial(NamedTuple):
    """Worn Xsens sensors with the wearer's Vicon joints."""

    recording: ImuRecording  # the real sensors, (T, N, 3)
    orientations: np.ndarray  # (T, N, 4): xsens's estimate, w, x, y, z, sensor to world
    vicon: dict[str, np.ndarray]
    """Joint positions (T, 3) in metres and segment orientations (T, 4), w, x, y, z, by name."""
    first_row: int  # frame of the trial's full-body motion, counted from 0, that the first sample belongs to


def read_gait(folder: str | Path, trial: str) -> GaitTrial:
    """Read a trial of worn Xsens sensors and Vicon joints (gaittoolbox's CSV files).

    `folder`: holds ``<trial>-<site>.csv`` for each sensor and ``vicon_<trial>.csv``.
    `trial`: E.g. "S02-Trial-Walk-1".
    Raises ValueError if no sensor's file is there, one is damaged, or their lengths differ.
    """
    folder = Path(folder)
    paths = sorted(folder.glob(f"{trial}-*.csv"))
    if not paths:
        raise ValueError(f"{folder} holds no files {trial}-<site>.csv")
    tables = [_gait_table(path) for path in (*paths, folder / f"vicon_{trial}.csv")]
    sites = tuple(path.stem.removeprefix(f"{trial}-") for path in paths)
    sensors = [
        {
            name: np.stack([columns[f"{name}_{k + 1}"] for k in range(size)], axis=1)
            for name, size in (("ori", 4), ("acc", 3), ("gyr", 3))
        }
        for _, columns in tables[:-1]
    ]
    if len({len(sensor["acc"]) for sensor in sensors}) != 1:
        raise ValueError(f"the files {trial}-<site>.csv in {folder} differ in length")
    facts, columns = tables[-1]
    names = dict.fromkeys(name.rsplit("_", 1)[0] for name in columns)
    recording = ImuRecording(
        acc=np.stack([sensor["acc"] for sensor in sensors], axis=1),
        gyr=np.stack([sensor["gyr"] for sensor in sensors], axis=1),
        rate=float(facts["fs"]),
        sites=sites,
        activity="walk",
        subject=trial.split("-")[0],
        clip=trial,
    )
    return GaitTrial(
        recording=recording,
        orientations=np.stack([sensor["ori"] for sensor in sensors], axis=1),
        vicon={
            name: np.stack([columns[c] for c in columns if c.rsplit("_", 1)[0] == name], axis=1)
            for name in names
        },
        first_row=int(facts["idx"].split(",")[0]) - 1,
    )


def _gait_table(path: Path) -> tuple[dict[str, str], dict[str, np.ndarray]]:
    """Facts from the ``//`` lines and the columns of one of gaittoolbox's files."""
    if not path.is_file():
        raise ValueError(f"{path} is missing")
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    head = [line.removeprefix("//") for line in lines if line.startswith("//")]
    facts = dict(part.split("=", 1) for line in head for part in line.split() if "=" in part)
    if not {"fs", "idx"} <= set(facts) or len(lines) < len(head) + 2:
        raise ValueError(f"{path} is no gaittoolbox file: it lacks '// fs=', '// idx=' or its table")
    names = lines[len(head)].split(",")
    try:
        table = np.array([line.split(",") for line in lines[len(head) + 1 :] if line], dtype=np.float64)
    except ValueError as error:
        raise ValueError(f"{path} has a damaged row: {error}") from error
    return facts, dict(zip(names, table.T, strict=True))
