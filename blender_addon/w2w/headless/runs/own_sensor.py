# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of a user's own sensor, each with what is simulated of its wearer's motion."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from ...core.body.body import Body
from ...core.imu.calibration import Pair
from ...core.imu.formats import read_recording
from ...core.imu.recording import ImuRecording
from ...core.imu.virtual import sensor_at
from ...core.keypoints.facts import PoseFacts
from ...core.library.library import Clip
from ...core.motion.source import UnusableMotion
from ...core.parameters import with_values
from ...core.patches.patches import sample_patches
from ...core.study.config import StudyConfig
from ...core.study.signals import simulate
from ...core.wording import clean
from .clip_task import Engine
from .workers import load_alone

RECORDED = (".csv", ".txt", ".npz")
MOST_LOST = 0.05
"""Share of lost samples up to which a recording is used."""


class Simulator:
    """Makes what a sensor at one place or patch would record; a ValueError if there is none."""

    def __init__(self, placement: str, config: StudyConfig, pose: PoseFacts) -> None:
        self._body, self._config, self._pose = Body.bundled(), config, pose
        self._patches = sensor_at(self._body, placement, sample_patches)
        self.patch = self._patches.names[0]

    def __call__(self, path: Path, rate: float) -> ImuRecording:
        """The recording of a motion file; an UnusableMotion or ValueError if it cannot be used."""
        clip = Clip(path, clean(path.name), clean(path.stem), "")
        _, motion, _ = load_alone(clip, self._body, Engine(pose=self._pose))
        return simulate(self._body, self._patches, motion, with_values(self._config, {"rate": rate}))


def read_pairs(
    files: Sequence[tuple[Path, Path]], simulate: Simulator
) -> tuple[list[Pair], list[tuple[str, str]]]:
    """A worn and a simulated recording of each motion, all at the first one's rate.

    Also returns the files that could not be used, each with the reason; a ValueError if none could.
    """
    pairs: list[Pair] = []
    left_out = []
    for recorded, moved in files:
        try:
            worn = _one_sensor(read_recording(recorded))
            if pairs and abs(worn.rate - pairs[0][0].rate) > 0.01 * pairs[0][0].rate:
                raise ValueError(f"it has {worn.rate:g} Hz, the first one {pairs[0][0].rate:g} Hz")
            made = simulate(moved, worn.rate)
        except (ValueError, OSError, UnusableMotion) as error:
            left_out.append((clean(recorded.name), str(error)))
            continue
        pairs.append((replace(worn, clip=worn.clip or clean(recorded.stem)), made))
    if not pairs:
        raise ValueError("; ".join(f"{file}: {why}" for file, why in left_out))
    return pairs, left_out


def files_together(real: Path, motion: Path) -> list[tuple[Path, Path]]:
    """Recordings and motions that belong together: two files, or files of the same name in two folders.

    A ValueError says why there are none.
    """
    for path in (real, motion):
        if not path.exists():
            raise ValueError(f"{clean(path)} is not there")
    if not motion.is_dir():
        return [(real, motion)]
    if not real.is_dir():
        raise ValueError(
            f"{clean(motion)} is a folder and {clean(real)} is not: give two files, or two folders"
        )
    motions = {path.stem: path for path in sorted(motion.iterdir())}
    recorded = sorted(path for path in real.iterdir() if path.is_dir() or path.suffix.lower() in RECORDED)
    found = [(path, motions[path.stem]) for path in recorded if path.stem in motions]
    if not found:
        raise ValueError(
            f"no file in {clean(motion)} has the name of one in {clean(real)}, but for its ending"
        )
    return found


def _one_sensor(recording: ImuRecording) -> ImuRecording:
    """The recording, its few lost samples bridged; a ValueError for several sensors, or too many lost."""
    if recording.n_sensors > 1:
        raise ValueError(f"it holds {recording.n_sensors} sensors: give each its own file")
    parts = []
    for values in (recording.acc[:, 0], recording.gyr[:, 0]):
        lost = np.isnan(values).any(axis=1)
        if lost.mean() > MOST_LOST:
            raise ValueError(f"{lost.mean():.0%} of its samples are lost".replace("%", " %"))
        known, times = np.flatnonzero(~lost), np.arange(len(values))
        parts.append(np.stack([np.interp(times, known, axis[known]) for axis in values.T], axis=1)[:, None])
    return replace(recording, acc=parts[0], gyr=parts[1], orientation=None, magnetometer=None, barometer=None)
