# SPDX-License-Identifier: GPL-3.0-or-later
"""AMASS-style npz files (SMPL, SMPL-H, SMPL-X poses) in, as motions of the 24 joints."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .body import Body
from .motion import SMPL_PELVIS, Motion
from .retarget import on_the_ground
from .skeleton import BODY_HANDS, N_JOINTS, Y_UP_TO_Z_UP
from .source_motion import UnusableMotion

RATE_KEYS = ("mocap_framerate", "mocap_frame_rate", "framerate", "fps")

BODY_JOINTS = min(BODY_HANDS)
"""Joints before the hands: the same in SMPL, SMPL-H and SMPL-X (Pavlakos et al. 2019)."""

POSE_WIDTHS = {72: "SMPL", 156: "SMPL-H", 165: "SMPL-X", 66: "SMPL body"}

MAX_BYTES = 2 * 2**30
"""No clip unpacks to more; a small npz may claim to."""

MIN_FRAMES = 4


def read_amass(path: str | Path) -> Motion:
    """Read an AMASS-style npz.

    AMASS files (Mahmood et al. 2019) hold ``poses`` (T, 72, 156 or 165) as axis-angle,
    ``trans`` (T, 3) in metres and ``mocap_framerate``. Their world is z up; files whose
    bodies stand along y instead are turned.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    Motion
        Without labels.

    Raises
    ------
    UnusableMotion
        If it is no such file, or holds a pose instead of a motion.
    """
    arrays = _read_arrays(Path(path))
    poses, trans, rate = _poses(arrays), _trans(arrays), _rate(arrays)
    if len(poses) != len(trans):
        raise UnusableMotion(f"its 'poses' have {len(poses)} frames but its 'trans' has {len(trans)}")
    if len(poses) < MIN_FRAMES:
        raise UnusableMotion(f"it holds a pose, not a motion: {len(poses)} frames")
    if not (np.isfinite(poses).all() and np.isfinite(trans).all()):
        raise UnusableMotion("it holds values that are not finite")
    rotations = np.tile(np.eye(3), (len(poses), N_JOINTS, 1, 1))
    turns = Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(len(poses), -1, 3, 3)
    rotations[:, 1:BODY_JOINTS] = Y_UP_TO_Z_UP @ turns[:, 1:BODY_JOINTS] @ Y_UP_TO_Z_UP.T
    root, pelvis = turns[:, 0], trans + SMPL_PELVIS
    if _stands_along_y(root):
        root, pelvis = Y_UP_TO_Z_UP @ root, pelvis @ Y_UP_TO_Z_UP.T
    rotations[:, 0] = root @ Y_UP_TO_Z_UP.T
    return Motion(rotations, pelvis, rate)


def to_body(motion: Motion, body: Body) -> Motion:
    """An SMPL motion on another body: the same rotations, its lowest point on z = 0."""
    return on_the_ground(body, motion)


def _read_arrays(path: Path) -> dict[str, np.ndarray]:
    """The small arrays of an npz; object arrays and unreasonable sizes are refused."""
    try:
        with zipfile.ZipFile(path) as archive:
            size = sum(info.file_size for info in archive.infolist())
        if size > MAX_BYTES:
            raise UnusableMotion(f"it would unpack to {size / 2**30:.1f} GiB, more than any motion needs")
        with np.load(path, allow_pickle=False) as data:
            wanted = {"poses", "trans", *RATE_KEYS} & set(data.files)
            if "poses" not in wanted:
                held = ", ".join(sorted(data.files)[:8])
                raise UnusableMotion(f"it is not an AMASS-style motion: it holds {held} and no 'poses'")
            return {name: data[name] for name in wanted}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, NotImplementedError) as error:
        raise UnusableMotion(f"it cannot be read as an npz file: {error}") from error


def _poses(arrays: dict[str, np.ndarray]) -> np.ndarray:
    poses = arrays["poses"]
    if poses.ndim == 3 and poses.shape[1:] == (N_JOINTS, 3):
        poses = poses.reshape(len(poses), -1)
    if poses.ndim != 2 or poses.shape[1] not in POSE_WIDTHS or poses.dtype.kind != "f":
        widths = ", ".join(f"{width} ({kind})" for width, kind in POSE_WIDTHS.items())
        raise UnusableMotion(f"its 'poses' have shape {poses.shape}; expected (frames, n), n one of {widths}")
    return poses[:, : 3 * BODY_JOINTS].astype(np.float64)


def _trans(arrays: dict[str, np.ndarray]) -> np.ndarray:
    trans = arrays.get("trans")
    if trans is None or trans.ndim != 2 or trans.shape[1] != 3 or trans.dtype.kind != "f":
        found = "is missing" if trans is None else f"has shape {trans.shape}"
        raise UnusableMotion(f"its 'trans' {found}; expected (frames, 3) in metres")
    return trans.astype(np.float64)


def _rate(arrays: dict[str, np.ndarray]) -> float:
    for name in RATE_KEYS:
        if name in arrays and arrays[name].size == 1 and arrays[name].dtype.kind in "fiu":
            rate = float(arrays[name].item())
            if np.isfinite(rate) and rate > 0:
                return rate
    raise UnusableMotion(f"it does not say its frame rate: none of {', '.join(RATE_KEYS)} holds one")


def _stands_along_y(root: np.ndarray) -> bool:
    """Whether bodies stand along the world's y, by where the body's own up points on average."""
    up = root[:, :, 1].mean(axis=0)
    return bool(up[1] > np.abs(up[2]))
