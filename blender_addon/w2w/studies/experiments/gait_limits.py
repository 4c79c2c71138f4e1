# SPDX-License-Identifier: GPL-3.0-or-later
"""How well the gait trial's BVH could be matched at best: bounds on `gait`, not results.

    python -m w2w.studies.experiments.gait_limits [--lowpass 10 5 3] [--band 10] [--json OUT.json]

Three things the sensors' own signals are used to fit, which no pipeline may:

- "its own segments, lever arms fitted": no body, no skin; the BVH's bones with a rotation and a lever arm
  fitted to every sensor. What is missing here the file itself does not hold.
- "best root path": W2W's sites, their root's acceleration chosen sample by sample as the one that brings all
  nine sensors nearest to the truth. No repair of the root path alone can do better.
- "both": bones, lever arms and root all fitted.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.files import write_json
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.source import SourceMotion, unscaled_rotations
from w2w.core.retargeting.retarget import retarget

from ..datasets.gait import GaitTrial, read_gait
from ..datasets.gait_sites import SITES
from .gait import (
    AS_DEFAULT,
    DATA,
    ROAD,
    TRIAL,
    align,
    arm_effects,
    below,
    compare,
    print_table,
    read_source,
    scores,
    sensed_frames,
    site_poses,
)

MILLIMETRES = 1e-3
"""The BVH's unit of length."""

ROUNDS = 8
"""The root's acceleration and the sensors' rotations are found in turns."""


def segment_poses(trial: GaitTrial, source: SourceMotion) -> np.ndarray:
    """World matrices of the bone each sensor sat on, over the sensors' frames, metres."""
    bones = [source.bones.index(SITES[site].bone) for site in trial.recording.sites]
    matrices = source.matrices[sensed_frames(trial, source.n_frames)][:, bones].copy()
    matrices[..., :3, :3] = unscaled_rotations(matrices)
    matrices[..., :3, 3] *= MILLIMETRES
    return matrices


def best_root(
    matrices: np.ndarray, rate: float, real: ImuRecording, lowpass: float, lever_arms: bool, band: float
) -> ImuRecording:
    """Aligned signals with the root acceleration that serves all sensors best, in the mean square."""
    ideal = synthesize(matrices, rate, Synthesis(rate_hz=real.rate, cutoff_hz=band))
    made, truth = below(ideal, lowpass), below(real, lowpass)
    turns = matrices[: real.n_samples, :, :3, :3]
    extra = np.zeros((real.n_samples, 3))  # acceleration of the root, world axes, m/s2
    for _ in range(ROUNDS):
        moved = ImuRecording(made.acc + np.einsum("tnba,tb->tna", turns, extra), made.gyr, made.rate)
        aligned, missing = [], []
        for sensor in range(real.n_sensors):
            effects = arm_effects(ideal, sensor, lowpass) if lever_arms else None
            acc, gyr = align(moved, truth, sensor, effects)
            aligned.append((acc, gyr))
            # the same misfit in the world's axes: where the fitted rotation came from does not matter
            back = _rotation_between(gyr, made.gyr[:, sensor])
            missing.append(np.einsum("tab,tb->ta", turns[:, sensor], (truth.acc[:, sensor] - acc) @ back.T))
        extra = extra + np.mean(missing, axis=0)
    acc, gyr = (np.stack(parts, axis=1) for parts in zip(*aligned, strict=True))
    return ImuRecording(acc, gyr, real.rate, real.sites)


def _rotation_between(turned: np.ndarray, original: np.ndarray) -> np.ndarray:
    """The matrix that takes `turned` vectors back to `original` ones, (T, 3) each, exactly."""
    return np.linalg.lstsq(turned, original, rcond=None)[0].T


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lowpass", type=float, nargs="+", default=[10.0, 5.0, 3.0], help="Hz")
    parser.add_argument("--band", type=float, default=AS_DEFAULT, help="Hz, of the trajectories")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    trial, source, body = read_gait(DATA, TRIAL), read_source(), Body.bundled()
    road, _ = site_poses(trial, body, retarget(source, body).motion)
    bones, real, rate = segment_poses(trial, source), trial.recording, source.rate
    everything = {}
    for lowpass in options.lowpass:
        given = {"rate": rate, "real": real, "lowpass": lowpass, "band": options.band}
        made = {
            ROAD: compare(road, **given),
            "its own segments, lever arms fitted": compare(bones, **given, lever_arms=True),
            "W2W, best root path": best_root(road, **given, lever_arms=False),
            "both": best_root(bones, **given, lever_arms=True),
        }
        found = {name: scores(recording, real, lowpass) for name, recording in made.items()}
        print(f"\nbelow {lowpass:g} Hz\n")
        print_table(found, real.sites)
        everything[f"{lowpass:g} Hz"] = found
    if options.json:
        write_json(options.json, everything)


if __name__ == "__main__":
    main()
