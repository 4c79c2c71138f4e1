# SPDX-License-Identifier: GPL-3.0-or-later
"""Sensors that sit on a garment, beside those on the skin."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..imu.recording import ImuRecording
from ..imu.synthesis import Synthesis, synthesize


@dataclass(frozen=True, eq=False)
class Worn:
    """Where the sensors were that a garment carried through a clip.

    Parameters
    ----------
    patches : ndarray of int, shape (K,)
        Patches whose sensors are on the garment.
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

    def carried(self, there: np.ndarray, here: np.ndarray) -> Worn:
        """The same over a body in another pose: each sensor stays where it is relative to its patch.

        Parameters
        ----------
        there, here : ndarray, shape (T, K, 4, 4)
            World matrices of the patches on the skin in the pose followed and in the one wanted.
        """
        return replace(self, matrices=here @ np.linalg.inv(there) @ self.matrices)

    def over(self, skin: ImuRecording, settings: Synthesis) -> ImuRecording:
        """The ideal recording of the skin, with what the garment's sensors feel in place of the skin's.

        Parameters
        ----------
        skin : ImuRecording
            Ideal signals of all patches, by the same settings.
        settings : Synthesis

        Raises
        ------
        ValueError
            If the garment's frames end before the recording does.
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
