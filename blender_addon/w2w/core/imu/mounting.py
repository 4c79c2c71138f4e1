# SPDX-License-Identifier: GPL-3.0-or-later
"""The constant rotation from a simulated sensor's axes to those of the one that was worn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from ..filtering import butterworth
from .recording import ImuRecording

ALIGNED_BELOW_HZ = 5.0

Pair = tuple[ImuRecording, ImuRecording]
"""A clip's real and simulated recording of one sensor, of the same rate."""


def mounting(pairs: Sequence[Pair]) -> Rotation:
    """The rotation that turns simulated signals to the real sensor's axes, over all pairs at once."""
    ours, theirs = [], []
    for real, made in pairs:
        n = min(real.n_samples, made.n_samples)
        for name in ("acc", "gyr"):
            values = [
                butterworth(getattr(r, name)[:n, 0].T.astype(np.float64), r.rate, ALIGNED_BELOW_HZ, 2, True).T
                for r in (real, made)
            ]
            size = np.sqrt((values[0] ** 2).mean()) + 1e-6
            theirs.append(values[0] / size)
            ours.append(values[1] / size)
    rotation, _ = Rotation.align_vectors(np.concatenate(theirs), np.concatenate(ours))
    return rotation


def turned(recording: ImuRecording, rotation: Rotation) -> ImuRecording:
    """A one-sensor recording in other axes."""
    acc, gyr = (rotation.apply(values[:, 0])[:, None] for values in (recording.acc, recording.gyr))
    return ImuRecording(
        acc, gyr, recording.rate, recording.sites, recording.activity, recording.subject, recording.clip
    )
