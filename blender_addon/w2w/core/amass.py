# SPDX-License-Identifier: GPL-3.0-or-later
"""AMASS-style npz and `.smpl` files (SMPL, SMPL-H, SMPL-X poses) in, as motions of the 24 joints."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .motion import SMPL_PELVIS, Motion
from .motion_file import size_and_head, unreadable
from .npz_reading import array_names, read_arrays
from .skeleton import BODY_HANDS, N_JOINTS, Y_UP_TO_Z_UP
from .source_motion import UnusableMotion, reason_of, refuse_rate, refuse_too_long

SMPL_SUFFIXES = (".npz", ".smpl")
"""Kinds of files read here, in lower case with the dot."""

RATE_KEYS = ("mocap_framerate", "mocap_frame_rate", "framerate", "fps", "frameRate")
TRANS_KEYS = ("trans", "transl", "bodyTranslation")
POSE_PARTS = (("root_orient", "pose_body"), ("global_orient", "body_pose"))
"""Names of the pelvis's turn and of the other joints', in files that keep them apart."""

SMPL_CONTAINER = "bodyPose"
"""Where a `.smpl` file (Meshcapade's smplcodec, an npz by other names) keeps its poses."""

BODY_JOINTS = min(BODY_HANDS)
"""Joints before the hands: the same in SMPL, SMPL-H and SMPL-X (Pavlakos et al. 2019)."""

POSE_WIDTHS = {72: "SMPL", 156: "SMPL-H", 165: "SMPL-X", 66: "SMPL-H or SMPL-X without hands"}

MAX_BYTES = 2 * 2**30
"""No clip unpacks to more; a small npz may claim to."""

MIN_FRAMES = 4

MAX_DISTANCE = 1e7
"""Metres from the origin: more than any map's coordinates, and little enough for second differences."""

MAX_TURN = 1e4
"""Radians of one rotation vector: over a thousand whole turns."""


def read_amass(path: str | Path, z_up: bool = False) -> Motion:
    """Read an AMASS-style npz or a `.smpl` file.

    AMASS files (Mahmood et al. 2019) hold ``poses`` (T, 72, 156 or 165) as axis-angle, or
    ``root_orient`` and ``pose_body``, ``trans`` (T, 3) in metres and ``mocap_framerate``. Their
    world is z up; files whose bodies stand along y instead, as `.smpl` files have it, are turned.

    Parameters
    ----------
    path : str or Path
    z_up : bool
        The world is known to be z up, as in files that `Motion.save` wrote: a body that lies or
        crawls is then not taken for one that stands along y.

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
    poses = _poses(arrays)
    refuse_too_long(len(poses), poses.shape[1] // 3)
    if len(poses) < MIN_FRAMES:
        raise UnusableMotion(f"it holds a pose, not a motion: {len(poses)} frame{'s' * (len(poses) != 1)}")
    trans, rate = _trans(arrays), _rate(arrays)
    if len(poses) != len(trans):
        raise UnusableMotion(f"its 'poses' have {len(poses)} frames but its 'trans' has {len(trans)}")
    _refuse_beyond(poses, "poses", MAX_TURN, "rad", "in radians")
    _refuse_beyond(trans, "trans", MAX_DISTANCE, "m", "in metres")
    rotations = np.tile(np.eye(3), (len(poses), N_JOINTS, 1, 1))
    turns = Rotation.from_rotvec(poses.reshape(-1, 3)).as_matrix().reshape(len(poses), -1, 3, 3)
    rotations[:, 1:BODY_JOINTS] = Y_UP_TO_Z_UP @ turns[:, 1:BODY_JOINTS] @ Y_UP_TO_Z_UP.T
    root, pelvis = turns[:, 0], trans + SMPL_PELVIS
    if not z_up and _stands_along_y(root):
        root, pelvis = Y_UP_TO_Z_UP @ root, pelvis @ Y_UP_TO_Z_UP.T
    rotations[:, 0] = root @ Y_UP_TO_Z_UP.T
    return Motion(rotations, pelvis, rate)


def _read_arrays(path: Path) -> dict[str, np.ndarray]:
    """The small arrays of an npz; object arrays and unreasonable sizes are refused."""
    size_and_head(path)
    try:
        names = set(array_names(path))
        if not ({"poses", SMPL_CONTAINER} & names or any(set(parts) <= names for parts in POSE_PARTS)):
            held = ", ".join(sorted(names)[:8])
            raise UnusableMotion(f"it is not an AMASS-style motion: it holds {held} and no 'poses'")
        parts = [name for pair in POSE_PARTS for name in pair]
        wanted = ("poses", SMPL_CONTAINER, *parts, *TRANS_KEYS, *RATE_KEYS)
        return read_arrays(path, wanted, MAX_BYTES)
    except OSError as error:
        raise UnusableMotion(unreadable(error)) from error
    except ValueError as error:
        raise UnusableMotion(reason_of(error)) from error


def _poses(arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Rotation vectors of the joints before the hands, shape (T, 66)."""
    name = next((name for name in ("poses", SMPL_CONTAINER) if name in arrays), None)
    if name is None:
        name, parts = next(("' and '".join(pair), pair) for pair in POSE_PARTS if set(pair) <= arrays.keys())
        turns = [arrays[part].reshape(len(arrays[part]), -1) for part in parts if arrays[part].ndim]
        if len(turns) < len(parts) or len(turns[0]) != len(turns[1]):
            raise UnusableMotion(f"its '{name}' differ in their number of frames")
        poses = np.concatenate(turns, axis=1)
    else:
        poses = arrays[name]
    if poses.ndim == 3 and poses.shape[2] == 3:
        poses = poses.reshape(len(poses), -1)
    if poses.ndim != 2 or poses.shape[1] not in POSE_WIDTHS or poses.dtype.kind != "f":
        widths = ", ".join(f"{width} ({kind})" for width, kind in POSE_WIDTHS.items())
        hint = ", which look like quaternions" if poses.ndim == 3 and poses.shape[2] == 4 else ""
        raise UnusableMotion(
            f"its '{name}' have shape {poses.shape}{hint}; expected axis-angle (frames, n), n one of {widths}"
        )
    return poses[:, : 3 * BODY_JOINTS].astype(np.float64)


def _trans(arrays: dict[str, np.ndarray]) -> np.ndarray:
    trans = next((arrays[name] for name in TRANS_KEYS if name in arrays), None)
    if trans is None or trans.ndim != 2 or trans.shape[1] != 3 or trans.dtype.kind != "f":
        found = "is missing" if trans is None else f"has shape {trans.shape}"
        raise UnusableMotion(f"its 'trans' {found}; expected (frames, 3) in metres")
    return trans.astype(np.float64)


def _rate(arrays: dict[str, np.ndarray]) -> float:
    for name in RATE_KEYS:
        if name in arrays and arrays[name].size == 1 and arrays[name].dtype.kind in "fiu":
            rate = float(arrays[name].item())
            if np.isfinite(rate) and rate > 0:
                refuse_rate(rate)
                return rate
    raise UnusableMotion(
        f"it does not say its frame rate: none of {', '.join(RATE_KEYS)} holds one; "
        f"save it again with '{RATE_KEYS[0]}'"
    )


def _refuse_beyond(values: np.ndarray, name: str, most: float, unit: str, expected: str) -> None:
    if not np.isfinite(values).all():
        raise UnusableMotion(f"its '{name}' hold values that are not finite (NaN or infinite)")
    largest = np.abs(values).max(initial=0.0)
    if largest > most:
        raise UnusableMotion(
            f"its '{name}' reach {largest:.3g} {unit}, which no body does: it is damaged, or not {expected}"
        )


def _stands_along_y(root: np.ndarray) -> bool:
    """Whether bodies stand along the world's y, by where the body's own up points on average."""
    up = root[:, :, 1].mean(axis=0)
    return bool(up[1] > np.abs(up[2]))
