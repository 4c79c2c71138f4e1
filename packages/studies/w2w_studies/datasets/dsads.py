# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of DSADS, Daily and Sports Activities: five worn sensors.

All in SI units and the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from pathlib import Path

import numpy as np

from w2w.core.files import load_arrays
from w2w.core.imu.recording import ImuRecording

DSADS_RATE = 25.0
DSADS_SEGMENT = (125, 45)
DSADS_SITES = ("torso", "right arm", "left arm", "right leg", "left leg")
DSADS_ACTIVITIES = (
    "sitting", "standing", "lying on back", "lying on right side", "ascending stairs", "descending stairs",
    "standing in elevator", "moving around in elevator", "walking in parking lot",
    "walking on flat treadmill", "walking on inclined treadmill", "running on treadmill",
    "exercising on stepper",
    "exercising on cross trainer", "cycling horizontal", "cycling vertical", "rowing", "jumping",
    "playing basketball",
)  # fmt: skip
"""A1 to A19 (Altun, Barshan and Tuncel 2010, doi:10.1016/j.patcog.2010.04.019)."""


def read_dsads(path: str | Path) -> tuple[ImuRecording, ...]:
    """Read windows of DSADS, Daily and Sports Activities: its own folder, or an npz of all of it.

    `path`: the folder that holds ``a01/p1/s01.txt`` and so on (125 lines of 45 numbers: 9 a sensor), or an
    npz of x (W, 125, 5, 6), activity, subject and segment.
    One recording a 5 s segment: 125 samples of 5 sensors at 25 Hz.
    Raises ValueError if it is neither, or a segment is damaged.
    """
    path = Path(path)
    x, activity, subject, segment = _dsads_folder(path) if path.is_dir() else _dsads_npz(path)
    return tuple(
        ImuRecording(
            acc=window[..., :3],
            gyr=window[..., 3:],
            rate=DSADS_RATE,
            sites=DSADS_SITES,
            activity=DSADS_ACTIVITIES[a - 1],
            subject=f"p{p}",
            clip=f"a{a:02d}_p{p}_s{s:02d}",
        )
        for window, a, p, s in zip(x, activity.tolist(), subject.tolist(), segment.tolist(), strict=True)
    )


def _dsads_npz(path: Path) -> tuple[np.ndarray, ...]:
    names = ("x", "activity", "subject", "segment")
    data = load_arrays(path, names, "is no DSADS archive")
    arrays = tuple(data[name] for name in names)
    x = arrays[0]
    if x.ndim != 4 or x.shape[2:] != (len(DSADS_SITES), 6) or len(x) != len(arrays[1]):
        raise ValueError(f"{path}: x must have shape (W, samples, 5, 6), not {x.shape}")
    return arrays


def _dsads_folder(folder: Path) -> tuple[np.ndarray, ...]:
    """The archive's text files; the three columns of each sensor's magnetometer are left out."""
    paths = sorted(folder.glob("a[0-9][0-9]/p[1-8]/s[0-9][0-9].txt"))
    if not paths:
        raise ValueError(f"{folder} holds no segments a01/p1/s01.txt of DSADS")
    segments = []
    for path in paths:
        try:
            values = np.loadtxt(path, delimiter=",", dtype=np.float32, ndmin=2)
        except ValueError as error:
            raise ValueError(f"{path} has a damaged line: {error}") from error
        if values.shape != DSADS_SEGMENT:
            raise ValueError(f"{path} must have 125 lines of 45 numbers, not {values.shape}")
        segments.append(values)
    x = np.stack(segments).reshape(len(paths), -1, len(DSADS_SITES), 9)[..., :6]
    labels = [(int(p.parts[-3][1:]), int(p.parts[-2][1:]), int(p.stem[1:])) for p in paths]
    return (x, *np.array(labels).T)
