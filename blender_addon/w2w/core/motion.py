# SPDX-License-Identifier: GPL-3.0-or-later
"""A motion of the 24-joint skeleton, and its AMASS-style npz files."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from .files import write_npz
from .skeleton import N_JOINTS, Y_UP_TO_Z_UP

SMPL_PELVIS = np.array([-0.00179506, -0.22333382, 0.02821918])
"""Pelvis of SMPL's neutral template in its own y-up axes, metres: AMASS's ``trans`` is
measured from it (J_regressor @ v_template of the neutral model, Loper et al. 2015)."""


@dataclass(frozen=True, eq=False)
class Motion:
    """Joint rotations and the pelvis's path, frame by frame.

    Parameters
    ----------
    rotations : ndarray, shape (T, 24, 3, 3), float64
        Rotation of each joint relative to its parent (of the pelvis: to the world), in
        the axes of the T-pose (z up, facing -y). Identity everywhere is the T-pose.
    pelvis : ndarray, shape (T, 3), float64
        World position of the pelvis joint, metres, z up.
    rate : float
        Frames per second.
    activity, subject, clip : str
        Label, person and name of the clip; empty where unknown.

    Raises
    ------
    ValueError
        If shapes disagree, a value is not finite, or the rate is not positive.
    """

    rotations: np.ndarray
    pelvis: np.ndarray
    rate: float
    activity: str = ""
    subject: str = ""
    clip: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "rotations", np.ascontiguousarray(self.rotations, dtype=np.float64))
        object.__setattr__(self, "pelvis", np.ascontiguousarray(self.pelvis, dtype=np.float64))
        object.__setattr__(self, "rate", float(self.rate))
        n_frames = len(self.rotations)
        if self.rotations.shape != (n_frames, N_JOINTS, 3, 3) or n_frames == 0:
            raise ValueError(f"rotations must have shape (T, {N_JOINTS}, 3, 3), not {self.rotations.shape}")
        if self.pelvis.shape != (n_frames, 3):
            raise ValueError(f"pelvis must have shape ({n_frames}, 3), not {self.pelvis.shape}")
        if not (np.isfinite(self.rotations).all() and np.isfinite(self.pelvis).all()):
            raise ValueError("the motion holds values that are not finite")
        if not (np.isfinite(self.rate) and self.rate > 0):
            raise ValueError(f"the frame rate must be positive, not {self.rate}")

    @property
    def n_frames(self) -> int:
        """Number of frames."""
        return len(self.rotations)

    @property
    def duration(self) -> float:
        """Seconds from the first frame to the last."""
        return (self.n_frames - 1) / self.rate

    def labelled(self, activity: str, subject: str, clip: str) -> Motion:
        """The same motion under another label."""
        return replace(self, activity=activity, subject=subject, clip=clip)

    def save(self, path: str | Path) -> None:
        """Write an AMASS-style npz: ``poses`` (T, 72) axis-angle in SMPL's axes, ``trans``
        (T, 3) metres with z up, ``mocap_framerate``, and W2W's labels."""
        in_smpl_axes = Y_UP_TO_Z_UP.T @ self.rotations @ Y_UP_TO_Z_UP
        in_smpl_axes[:, 0] = self.rotations[:, 0] @ Y_UP_TO_Z_UP
        poses = Rotation.from_matrix(in_smpl_axes.reshape(-1, 3, 3)).as_rotvec()
        write_npz(
            path,
            {
                "poses": poses.reshape(self.n_frames, -1),
                "trans": self.pelvis - SMPL_PELVIS,
                "mocap_framerate": np.array(self.rate),
                "gender": np.array("neutral"),
                "betas": np.zeros(10),
                "activity": np.array(self.activity),
                "subject": np.array(self.subject),
                "clip": np.array(self.clip),
            },
        )
