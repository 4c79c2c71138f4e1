# SPDX-License-Identifier: GPL-3.0-or-later
"""Recordings of a sensor whose mounting, soft tissue and noise are known, for tests."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.imu.synthesis import Synthesis, synthesize

RATE = 100.0
TURN = Rotation.from_euler("xyz", [25, -110, 60], degrees=True)
"""From the simulated sensor's axes to the worn one's."""

ACC_NOISE, GYR_NOISE = 0.004, 0.0004
WORN = SensorModel(
    name="worn",
    accelerometer=Triad(noise_density=ACC_NOISE),
    gyroscope=Triad(noise_density=GYR_NOISE),
    worn_turn_deg=tuple(TURN.inv().as_rotvec(degrees=True)),
    soft_tissue_hz=7.0,
    soft_tissue_damping=0.2,
    soft_tissue_gain=0.8,
)


def swings(seconds, seed, rate=RATE):
    """World matrices (T, 1, 4, 4) of a limb that swings and stamps its own way, and rests in between."""
    rng = np.random.default_rng(seed)
    time = np.arange(0, seconds, 1 / rate)
    moving = np.clip(3 * np.sin(2 * np.pi * time / 5), 0, 1)[:, None]
    angles, path = np.zeros((len(time), 3)), np.zeros((len(time), 3))
    for frequency in (0.6, 1.3, 2.2, 4.0, 6.5, 9.0):
        phase = 2 * np.pi * (frequency * (1 + 0.05 * rng.normal()) * time[:, None] + rng.uniform(size=3))
        angles += rng.normal(0, 0.5 / frequency, 3) * np.sin(phase)
        path += rng.normal(0, 0.2 / frequency**1.5, 3) * np.cos(phase)
    matrices = np.tile(np.eye(4), (len(time), 1, 1, 1))
    matrices[:, 0, :3, :3] = Rotation.from_rotvec(angles * moving).as_matrix()
    matrices[:, 0, :3, 3] = path * moving
    return matrices


def pair(seconds=20, seed=0, worn=WORN, late_s=0.0, subject=""):
    """What was worn, begun `late_s` later, and what is simulated without errors."""
    made = synthesize(swings(seconds, seed), RATE, Synthesis(rate_hz=RATE, cutoff_hz=None))
    made = replace(made, subject=subject, clip=f"{subject} {seed}")
    real = worn.apply(made, seed)
    gone = round(-late_s * RATE)
    return replace(real, acc=real.acc[max(0, gone) :], gyr=real.gyr[max(0, gone) :]), made


def without_tissue(worn=WORN):
    return replace(worn, soft_tissue_hz=None)
