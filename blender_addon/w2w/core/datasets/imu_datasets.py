# SPDX-License-Identifier: GPL-3.0-or-later
"""Readers of public recordings of real sensors: BROAD, an Xsens and Vicon gait trial, DSADS and UTD-MHAD.

All return SI units in the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.io import loadmat

from ..imu.recording import ImuRecording
from ..imu.text_tables import ACC_UNITS, GYR_UNITS

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

UTD_IMU_RATE = 50.0
UTD_FIRST_THIGH_ACTION = 22
UTD_ACTIONS = (
    "swipe left", "swipe right", "wave", "clap", "throw", "arm cross", "basketball shoot", "draw x",
    "draw circle clockwise", "draw circle counter-clockwise", "draw triangle", "bowling", "boxing",
    "baseball swing", "tennis swing", "arm curl", "tennis serve", "push", "knock", "catch",
    "pick up and throw", "jog", "walk", "sit to stand", "stand to sit", "lunge", "squat",
)  # fmt: skip
"""a1 to a27 (Chen, Jafari and Kehtarnavaz 2015, doi:10.1109/ICIP.2015.7350781)."""


class BroadTrial(NamedTuple):
    """A trial of BROAD (Laidig et al. 2021, doi:10.3390/data6070072).

    Attributes
    ----------
    recording : ImuRecording
        The real sensor, (T, 1, 3).
    matrices : ndarray, shape (T, 1, 4, 4)
        Optical pose, sensor to east-north-up world; NaN where the optics lost it.
    movement : ndarray, shape (T,), bool
        Samples that count for errors.
    """

    recording: ImuRecording
    matrices: np.ndarray
    movement: np.ndarray


class GaitTrial(NamedTuple):
    """Worn Xsens sensors with the wearer's Vicon joints.

    Attributes
    ----------
    recording : ImuRecording
        The real sensors, (T, N, 3).
    orientations : ndarray, shape (T, N, 4)
        Xsens's estimate, w, x, y, z, sensor to world.
    vicon : dict of str to ndarray
        Joint positions (T, 3) in metres and segment orientations (T, 4), w, x, y, z, by name.
    first_row : int
        Frame of the trial's full-body motion, counted from 0, that the first sample belongs to.
    """

    recording: ImuRecording
    orientations: np.ndarray
    vicon: dict[str, np.ndarray]
    first_row: int


class UtdTrial(NamedTuple):
    """An action of UTD-MHAD: one worn sensor and a Kinect skeleton over the same span of time.

    Attributes
    ----------
    recording : ImuRecording
        (T, 1, 3), 50 Hz.
    skeleton : ndarray, shape (F, 20, 3)
        Joints in the camera's axes, metres, y up.
    """

    recording: ImuRecording
    skeleton: np.ndarray

    @property
    def skeleton_rate(self) -> float:
        """Frames per second of the skeleton, such that it lasts as long as the recording.

        The Kinect is said to run at 30, but in these files it has a third as many frames as the sensor has
        samples, not three fifths. Stretched to the sensor's span, the swing of the wrist's specific force is
        as large as the sensor's (median ratio 1.02 over the 335 wrist clips); at 30 it would be 2.0.
        """
        return self.recording.rate * (len(self.skeleton) - 1) / (self.recording.n_samples - 1)


def read_broad(path: str | Path) -> BroadTrial:
    """Read a trial of BROAD from its HDF5 file.

    Raises
    ------
    ImportError
        If h5py is not installed.
    ValueError
        If the file is not a trial of BROAD.
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


def read_gait(folder: str | Path, trial: str) -> GaitTrial:
    """Read a trial of worn Xsens sensors and Vicon joints (gaittoolbox's CSV files).

    Parameters
    ----------
    folder : str or Path
        Holds ``<trial>-<site>.csv`` for each sensor and ``vicon_<trial>.csv``.
    trial : str
        E.g. "S02-Trial-Walk-1".

    Raises
    ------
    ValueError
        If no sensor's file is there, one is damaged, or their lengths differ.
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


def read_dsads(path: str | Path) -> tuple[ImuRecording, ...]:
    """Read windows of DSADS, Daily and Sports Activities: its own folder, or an npz of all of it.

    Parameters
    ----------
    path : str or Path
        The folder that holds ``a01/p1/s01.txt`` and so on (125 lines of 45 numbers: 9 a sensor), or
        an npz of x (W, 125, 5, 6), activity, subject and segment.

    Returns
    -------
    tuple of ImuRecording
        One a 5 s segment: 125 samples of 5 sensors at 25 Hz.

    Raises
    ------
    ValueError
        If it is neither, or a segment is damaged.
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
    with _npz(path) as data:
        missing = {"x", "activity", "subject", "segment"} - set(data.files)
        if missing:
            raise ValueError(f"{path} is no DSADS archive: it lacks {', '.join(sorted(missing))}")
        arrays = tuple(data[name] for name in ("x", "activity", "subject", "segment"))
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


def read_utd_mhad(path: str | Path) -> tuple[UtdTrial, ...]:
    """Read the actions of UTD-MHAD: its own folder, or an npz of all of it.

    Parameters
    ----------
    path : str or Path
        The folder that holds ``Inertial/a1_s1_t1_inertial.mat`` (d_iner) and
        ``Skeleton/a1_s1_t1_skeleton.mat`` (d_skel), or an npz of ``a1_s1_t1_imu`` and ``a1_s1_t1_skel``.

    Raises
    ------
    ValueError
        If it holds no such pair.
    """
    path = Path(path)
    return tuple(
        _utd_trial(name, imu, skeleton)
        for name, imu, skeleton in (_utd_folder if path.is_dir() else _utd_npz)(path)
    )


def _utd_trial(name: str, imu: np.ndarray, skeleton: np.ndarray) -> UtdTrial:
    if (
        imu.ndim != 2
        or imu.shape[1] != 6
        or skeleton.shape[1:] != (20, 3)
        or min(len(imu), len(skeleton)) < 3
    ):
        raise ValueError(
            f"{name} must hold (T, 6) readings and (F, 20, 3) joints, not {imu.shape} and {skeleton.shape}"
        )
    values = imu.astype(np.float64)
    action, subject = (int(part[1:]) for part in name.split("_")[:2])
    recording = ImuRecording(
        acc=values[:, None, :3] * ACC_UNITS["g"],
        gyr=values[:, None, 3:] * GYR_UNITS["deg/s"],
        rate=UTD_IMU_RATE,
        sites=("right wrist" if action < UTD_FIRST_THIGH_ACTION else "right thigh",),
        activity=UTD_ACTIONS[action - 1],
        subject=f"s{subject}",
        clip=name,
    )
    return UtdTrial(recording, skeleton)


def _utd_npz(path: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    with _npz(path) as data:
        names = [name.removesuffix("_imu") for name in data.files if name.endswith("_imu")]
        if not names or not {f"{name}_skel" for name in names} <= set(data.files):
            raise ValueError(f"{path} is no UTD-MHAD archive: it lacks pairs a<n>_s<n>_t<n>_imu and _skel")
        for name in names:
            yield name, data[f"{name}_imu"], data[f"{name}_skel"]


def _utd_folder(folder: Path) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """The download's MATLAB files."""
    paths = sorted(folder.rglob("a*_s*_t*_inertial.mat"))
    skeletons = {path.name: path for path in folder.rglob("a*_s*_t*_skeleton.mat")}
    pairs = [(p, skeletons.get(p.name.replace("_inertial", "_skeleton"))) for p in paths]
    if not any(skeleton for _, skeleton in pairs):
        raise ValueError(
            f"{folder} holds no pairs a1_s1_t1_inertial.mat and a1_s1_t1_skeleton.mat of UTD-MHAD"
        )
    for inertial, skeleton in pairs:
        if skeleton:
            joints = _mat(skeleton, "d_skel").transpose(2, 0, 1)
            yield inertial.stem.removesuffix("_inertial"), _mat(inertial, "d_iner"), joints


def _mat(path: Path, name: str) -> np.ndarray:
    try:
        content = loadmat(path, variable_names=[name])
    except (ValueError, NotImplementedError, OSError, TypeError) as error:
        raise ValueError(f"{path} is no MATLAB file that can be read: {error}") from error
    if name not in content:
        raise ValueError(f"{path} holds no array {name}")
    return content[name]


def _npz(path: str | Path) -> np.lib.npyio.NpzFile:
    archive = np.load(path, allow_pickle=False)
    if not isinstance(archive, np.lib.npyio.NpzFile):
        raise ValueError(f"{path} is no npz archive")
    return archive


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
