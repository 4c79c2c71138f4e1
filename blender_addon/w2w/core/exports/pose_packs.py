# SPDX-License-Identifier: GPL-3.0-or-later
"""Training data of inertial pose estimators: TransPose, PIP and PNP; IMUPoser; MobilePoser.

The preprocessing of all but MobilePoser (`process_amass` in each project's public code) saves one
list a file, one entry a clip: ``pose`` (T, 24, 3) axis-angle, ``tran`` (T, 3), ``shape`` (10), ``joint``
(T, 24, 3), ``vacc`` (T, N, 3) acceleration without gravity and ``vrot`` (T, N, 3, 3) orientation, both in a
world whose y axis points up, at 60 Hz. TransPose and PIP test by one file, a dict of ``acc``, ``ori``,
``pose`` and ``tran``; MobilePoser trains by one, with matrices (T, 24, 3, 3) as ``pose``, and ``joint`` and
``contact``, at 30 Hz. An orientation is that of the sensor against its own in the T-pose, as after their
calibration.
"""

from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import JOINT_INDEX, Y_UP_TO_Z_UP, Body
from ..body.landmarks import SENSOR_SITES
from ..files import atomic_write, write_json
from ..motion.motion import SMPL_PELVIS
from ..motion.skinning import joint_transforms
from ..rotations import rotation_vectors
from ..wording import restated
from .study_signals import WornClip, WornSignals

METHODS = {"transpose": "TransPose", "imuposer": "IMUPoser", "mobileposer": "MobilePoser"}
"""Methods whose published sites are the default."""

RATES_HZ = {"transpose": 60.0, "imuposer": 60.0, "mobileposer": 30.0}
"""Frames per second that a method's programs expect."""

ONE_FILE = {
    "transpose": ("test.pt", {"acc": "vacc", "ori": "vrot", "pose": "pose", "tran": "tran"}),
    "mobileposer": (
        "w2w.pt",
        {"acc": "vacc", "ori": "vrot"}
        | {name: name for name in ("pose", "tran", "joint", "shape", "contact")},
    ),
}
"""File that a method's own program opens, and its lists by their names there, each with ours."""

ORDER = (
    *(f"{side} {part}" for part in ("forearm", "lower leg", "thigh") for side in ("left", "right")),
    "head",
    "pelvis",
)
"""Order in which the methods number their sensors."""

FEWEST_FRAMES = 13
"""Their own preprocessing discards shorter clips."""

CONTACT_M = 0.008
"""Motion from frame to frame below which a foot is in contact, as in MobilePoser's preprocessing."""

TO_Y_UP = Y_UP_TO_Z_UP.T


def sites_of(method: str) -> list[str]:
    """Names of a method's sensors, in its own order."""
    names = {site.name for site in SENSOR_SITES}
    return [name for part in ORDER if (name := f"{METHODS[method]} {part}") in names]


def write_pose_pack(folder: Path, signals: WornSignals, method: str) -> int:
    """Write the files of a method; returns the number of clips.

    Raises ValueError if PyTorch is missing or every clip is too short.
    """
    lacking = "files for pose estimators are PyTorch's: pip install '.[torch]' in W2W's folder"
    with restated(lacking, ModuleNotFoundError):
        import torch
    parts: dict[str, list[Any]] = {}
    names = []
    gravity = np.array(signals.study.config().synthesis.gravity)
    for clip in signals.clips():
        if clip.motion.n_frames < FEWEST_FRAMES:
            continue
        names.append([clip.recording.clip, clip.recording.activity, clip.recording.subject])
        for part, values in _parts(clip, signals.body, gravity, method).items():
            parts.setdefault(part, []).append(torch.from_numpy(np.ascontiguousarray(values)))
    if not names:
        raise ValueError(f"every clip is shorter than {FEWEST_FRAMES} frames at {signals.rate:g} Hz")
    files: dict[str, Any] = {f"{part}.pt": tensors for part, tensors in parts.items()}
    if method in ONE_FILE:
        file, lists = ONE_FILE[method]
        whole = {file: {name: parts[part] for name, part in lists.items()}}
        files = whole if method == "mobileposer" else files | whole
    for file, content in files.items():
        with atomic_write(folder / file) as stream:
            torch.save(content, stream)
    facts = {"rate_hz": signals.rate, "up": "y", "sensors": list(signals.names), "clips": names}
    write_json(folder / "clips.json", facts)
    return len(names)


def _parts(clip: WornClip, body: Body, gravity: np.ndarray, method: str) -> dict[str, np.ndarray]:
    motion = clip.motion
    turned = TO_Y_UP @ clip.orientations @ clip.rest.swapaxes(-1, -2) @ TO_Y_UP.T
    joints = (joint_transforms(body, motion)[1] - SMPL_PELVIS) @ TO_Y_UP.T
    force = np.einsum("tnij,tnj->tni", clip.orientations, clip.recording.acc.astype(np.float64))
    pose = in_smpl_axes = TO_Y_UP @ motion.rotations @ TO_Y_UP.T
    if method != "mobileposer":
        pose = rotation_vectors(in_smpl_axes)
    parts = {
        "pose": pose,
        "tran": (motion.pelvis - SMPL_PELVIS) @ TO_Y_UP.T,
        "shape": np.zeros(10),
        "joint": joints,
        "vrot": turned,
        "vacc": (force + gravity) @ TO_Y_UP.T,
    }
    arrays = {name: values.astype(np.float32) for name, values in parts.items()}
    if method == "mobileposer":
        feet = joints[:, [JOINT_INDEX["left_foot"], JOINT_INDEX["right_foot"]]]
        still = np.linalg.norm(np.diff(feet, axis=0), axis=2) < CONTACT_M
        arrays["contact"] = np.pad(still.astype(np.int32), ((1, 0), (0, 0)))  # never in the first frame
    return arrays
