# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of BROAD: one real sensor and its optical pose.

All in SI units and the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording


class BroadTrial(NamedTuple):
    """A trial of BROAD (Laidig et al. 2021, doi:10.3390/data6070072)."""

    recording: ImuRecording  # the real sensor, (T, 1, 3)
    matrices: np.ndarray
    """(T, 1, 4, 4): optical pose, sensor to east-north-up world; NaN where the optics lost it."""
    movement: np.ndarray  # (T,): samples that count for errors


def read_broad(path: str | Path) -> BroadTrial:
    """Read a trial of BROAD from its HDF5 file.

    Raises ImportError if h5py is not installed.
    Raises ValueError if the file is not a trial of BROAD.
    """
    try:
        import h5py
    except ImportError as error:
        raise ImportError("reading BROAD needs h5py: pip install h5py") from error
    try:
        source = h5py.File(path, "r")
    except OSError as error:
        raise ValueError(f"{path} is no HDF5 file that can be opened: {error}") from error
    with source as data:
        names = ("imu_acc", "imu_gyr", "opt_pos", "opt_quat", "movement")
        missing = [name for name in names if name not in data]
        if missing or "sampling_rate" not in data.attrs:
            raise ValueError(f"{path} is no trial of BROAD: it lacks {', '.join(missing) or 'sampling_rate'}")
        acc, gyr, positions, quaternions, movement = (data[name][:] for name in names)
        rate = float(data.attrs["sampling_rate"])
    matrices = np.zeros((len(acc), 1, 4, 4))
    matrices[:, 0, :3, :3] = _matrices_of(quaternions)
    matrices[:, 0, :3, 3] = positions
    matrices[:, 0, 3, 3] = 1
    recording = ImuRecording(acc=acc[:, None], gyr=gyr[:, None], rate=rate, clip=Path(path).stem)
    return BroadTrial(recording, matrices, movement.astype(bool))


def _matrices_of(quaternions: np.ndarray) -> np.ndarray:
    """Rotation matrices of quaternions w, x, y, z; NaN stays NaN."""
    q = quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True)
    w, x, y, z = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)
