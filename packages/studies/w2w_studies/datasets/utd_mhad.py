# SPDX-License-Identifier: GPL-3.0-or-later
"""Reader of UTD-MHAD: one worn sensor and a Kinect skeleton.

All in SI units and the conventions of `imu`: specific force and angular velocity in the sensor frame.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import scipy

from w2w.core.files import array_names, load_arrays
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.vendor_formats import ACC_UNITS, GYR_UNITS

UTD_IMU_RATE = 50.0
UTD_FIRST_THIGH_ACTION = 22
UTD_ACTIONS = (
    "swipe left", "swipe right", "wave", "clap", "throw", "arm cross", "basketball shoot", "draw x",
    "draw circle clockwise", "draw circle counter-clockwise", "draw triangle", "bowling", "boxing",
    "baseball swing", "tennis swing", "arm curl", "tennis serve", "push", "knock", "catch",
    "pick up and throw", "jog", "walk", "sit to stand", "stand to sit", "lunge", "squat",
)  # fmt: skip
"""a1 to a27 (Chen, Jafari and Kehtarnavaz 2015, doi:10.1109/ICIP.2015.7350781)."""


class UtdTrial(NamedTuple):
    """An action of UTD-MHAD: one worn sensor and a Kinect skeleton over the same span of time."""

    recording: ImuRecording  # (T, 1, 3), 50 Hz
    skeleton: np.ndarray  # (F, 20, 3): joints in the camera's axes, metres, y up

    @property
    def skeleton_rate(self) -> float:
        """Frames per second of the skeleton, such that it lasts as long as the recording.

        The Kinect is said to run at 30, but in these files it has a third as many frames as the sensor has
        samples, not three fifths. Stretched to the sensor's span, the swing of the wrist's specific force is
        as large as the sensor's (median ratio 1.02 over the 335 wrist clips); at 30 it would be 2.0.
        """
        return self.recording.rate * (len(self.skeleton) - 1) / (self.recording.n_samples - 1)


def read_utd_mhad(path: str | Path) -> tuple[UtdTrial, ...]:
    """Read the actions of UTD-MHAD: its own folder, or an npz of all of it.

    `path`: the folder that holds ``Inertial/a1_s1_t1_inertial.mat`` (d_iner) and
    ``Skeleton/a1_s1_t1_skeleton.mat`` (d_skel), or an npz of ``a1_s1_t1_imu`` and ``a1_s1_t1_skel``.
    Raises ValueError if it holds no such pair.
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
    wrong = "is no UTD-MHAD archive"
    try:
        held = array_names(path)
    except ValueError as error:
        raise ValueError(f"{path} {wrong}: {error}") from error
    names = [name.removesuffix("_imu") for name in held if name.endswith("_imu")]
    if not names:
        raise ValueError(f"{path} {wrong}: it lacks pairs a<n>_s<n>_t<n>_imu and _skel")
    data = load_arrays(path, [f"{name}_{part}" for name in names for part in ("imu", "skel")], wrong)
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
        content = scipy.io.loadmat(path, variable_names=[name])
    except (ValueError, NotImplementedError, OSError, TypeError) as error:
        raise ValueError(f"{path} is no MATLAB file that can be read: {error}") from error
    if name not in content:
        raise ValueError(f"{path} holds no array {name}")
    return content[name]
