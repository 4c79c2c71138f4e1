# SPDX-License-Identifier: GPL-3.0-or-later
"""A folder as the documents have it: MY_CLIPS of three activities by two people, its labels, RESULTS."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import N_JOINTS
from w2w.core.motion.motion import Motion

from .command_line import cli
from .here import clips_here, ranked_roughly

ARM = (16, 18)
LEG = (1, 4)


def moving(joints: tuple[int, ...], pace: float, number: int) -> Motion:
    """Some joints swing, the rest of the body stands."""
    time = np.arange(120) / 30
    turns = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
    angle = 0.7 * np.sin(2 * np.pi * pace * (1 + number / 30) * time + number)
    for joint in joints:
        turns[:, joint] = Rotation.from_rotvec(
            angle[:, None] * [1.0, 0.3 * (number % 4) - 0.3, 0.1]
        ).as_matrix()
    return Motion(turns, np.tile([0.0, 0.0, 0.95], (len(time), 1)), 30.0)


def make_door(folder: Path) -> None:
    """Write the clips, and let the command line rank them."""
    rows = ["file,activity,subject"]
    for activity, joints, pace in (("waving", ARM, 1.5), ("stirring", ARM, 0.6), ("kicking", LEG, 1.0)):
        (folder / "MY_CLIPS" / activity).mkdir(parents=True)
        for number in range(4):
            file = folder / "MY_CLIPS" / activity / f"{activity} {number}.npz"
            moving(joints, pace, number).save(file)
            rows.append(f"{activity}/{file.name},{activity},person {number % 2}")
    (folder / "labels.csv").write_text("\n".join(rows) + "\n")
    options = ["--patches", 24, "--no-pictures", "--no-report", "--workers", 1]
    with clips_here(), ranked_roughly():
        code, said = cli("run", folder / "MY_CLIPS", "--out", folder / "RESULTS", *options)
    assert code == 0, said
