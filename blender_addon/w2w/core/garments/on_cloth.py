# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that sit on cloth, beside those on the skin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..imu.recording import ImuRecording
from ..imu.synthesis import Synthesis, synthesize


@dataclass(frozen=True, eq=False)
class ClothSensors:
    """Where the sensors on garments were during a clip.

    Parameters
    ----------
    patches : ndarray of int, shape (K,)
        Patches whose sensors sit on cloth.
    matrices : ndarray, shape (T, K, 4, 4), float64
        World matrices of those sensors, metres, without scale.
    rate : float
        Frames per second; need not be the clip's.
    caught : tuple of int
        Frames in which each garment had caught on the body, the outer first; empty where nobody looked.
    """

    patches: np.ndarray
    matrices: np.ndarray
    rate: float
    caught: tuple[int, ...] = ()

    def carried(self, there: np.ndarray, here: np.ndarray) -> ClothSensors:
        """The same over a body in another pose: each sensor keeps its place relative to its patch.

        `there` and `here` (T, K, 4, 4) are world matrices of the patches on the skin, in the simulated
        pose and in the wanted one.
        """
        return replace(self, matrices=here @ np.linalg.inv(there) @ self.matrices)

    def over(self, skin: ImuRecording, settings: Synthesis) -> ImuRecording:
        """The ideal recording of the skin with the signals of the sensors on cloth in place of the skin's.

        Raises `ValueError` if the garment's frames end before the recording does.
        """
        if not len(self.patches):
            return skin
        cloth = synthesize(self.matrices, self.rate, settings)
        if cloth.n_samples < skin.n_samples:
            raise ValueError(
                f"the garment was followed for {cloth.n_samples} samples of {skin.n_samples}: "
                "its frames end before the clip does"
            )
        acc, gyr = skin.acc.copy(), skin.gyr.copy()
        acc[:, self.patches] = cloth.acc[: skin.n_samples]
        gyr[:, self.patches] = cloth.gyr[: skin.n_samples]
        return replace(skin, acc=acc, gyr=gyr)
