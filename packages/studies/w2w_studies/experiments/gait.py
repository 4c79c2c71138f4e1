# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole road against worn sensors: full-body Xsens BVH in, nine real IMUs as the truth.

    python -m w2w_studies.experiments.gait

The BVH is read through Blender, retargeted to the bundled body, skinned; the patch nearest each worn sensor's
site gives its signal. No lever arm, time shift, bias or scale is fitted: only one constant rotation a sensor,
from the patch's axes to the sensor's, since nobody knows how a strap sat. Real and simulated signals are
low-passed in the same way (Butterworth, zero phase). Scores are Pearson's r, the mean of the three axes.

Beside it, in the same run: the road with the BVH's root path smoothed (`core/root_path.py`), that with a
narrower band than the default 10 Hz as well, and as baselines the Vicon joints, the path of the joint nearest
each sensor with the turn of its segment, without and with the lever arm fitted.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from w2w.core.body.body import Body
from w2w.core.filtering import butterworth
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.synthesis import Synthesis, synthesize
from w2w.core.motion.motion import Motion, smoothed_root
from w2w.core.motion.skinning import patch_matrices
from w2w.core.motion.source import SourceMotion
from w2w.core.readers.bvh import read_bvh
from w2w.core.retargeting.retarget import retarget

from ..comparisons.site_simulator import sensors_at
from ..datasets.gait import GaitTrial, read_gait
from ..datasets.gait_sites import SITES
from .lever_arms import fitted_arm, lever_effects

DATA = Path(__file__).resolve().parents[5] / "shared" / "data" / "imu" / "gait"
TRIAL = "S02-Trial-Walk-1"

BVH_FRAMES = 2503
"""Frames of the BVH file; the sensors' rows are counted in them."""

LOWPASS_HZ = (10.0, 3.0)
"""Low-passes of real and simulated signals, in turn."""

ROOT_HZ, NARROW_HZ = 3.0, 5.0
"""Bands of the smoothed root path, and the narrower one of trajectories."""

AS_DEFAULT = Synthesis().cutoff_hz

FIT_ROUNDS = 30
"""Rotation and lever arm are fitted in turns."""


def read_source() -> SourceMotion:
    """The suit's motion."""
    return read_bvh(DATA / f"xsens_{TRIAL}.bvh")


def sensed_frames(trial: GaitTrial, n_frames: int) -> slice:
    """Frames that the sensors' samples belong to; leading T-poses of the BVH are not among those read."""
    first = trial.first_row - (BVH_FRAMES - n_frames)
    return slice(first, first + trial.recording.n_samples)


def site_poses(trial: GaitTrial, body: Body, motion: Motion) -> tuple[np.ndarray, tuple[str, ...]]:
    """World matrices of the patches at the worn sites over the sensors' frames, and their regions."""
    frames = sensed_frames(trial, motion.n_frames)
    patches = sensors_at(body, {site: SITES[site].on_body for site in trial.recording.sites})
    part = Motion(motion.rotations[frames], motion.pelvis[frames], motion.rate)
    return patch_matrices(body, patches.triangles, part), patches.regions


def vicon_poses(trial: GaitTrial) -> np.ndarray:
    """World matrices of the nearest joint of each sensor, turned as its segment, (T, N, 4, 4)."""
    matrices = np.tile(np.eye(4), (trial.recording.n_samples, len(trial.recording.sites), 1, 1))
    for sensor, site in enumerate(trial.recording.sites):
        matrices[:, sensor, :3, 3] = trial.vicon[SITES[site].joint]
        turns = Rotation.from_quat(trial.vicon[SITES[site].segment][:, [1, 2, 3, 0]])
        matrices[:, sensor, :3, :3] = turns.as_matrix()
    return matrices


def compare(
    matrices: np.ndarray,
    rate: float,
    real: ImuRecording,
    lowpass: float,
    lever_arms: bool = False,
    band: float = AS_DEFAULT,
) -> ImuRecording:
    """Signals of moving frames in the real sensors' axes, low-passed; `real` is the raw recording."""
    ideal = synthesize(matrices, rate, Synthesis(rate_hz=real.rate, cutoff_hz=band))
    made, truth = below(ideal, lowpass), below(real, lowpass)
    aligned = [
        align(made, truth, sensor, arm_effects(ideal, sensor, lowpass) if lever_arms else None)
        for sensor in range(real.n_sensors)
    ]
    acc, gyr = (np.stack(parts, axis=1) for parts in zip(*aligned, strict=True))
    return ImuRecording(acc, gyr, real.rate, real.sites)


def arm_effects(ideal: ImuRecording, sensor: int, lowpass: float) -> np.ndarray:
    """What a lever arm at a sensor would add, low-passed (`lever_arms.lever_effects`)."""
    spin = ideal.gyr[:, sensor].astype(np.float64)
    effects = lever_effects(spin, np.gradient(spin, 1 / ideal.rate, axis=0))
    return _lowpass(effects, ideal.rate, lowpass)


def align(
    made: ImuRecording, real: ImuRecording, sensor: int, effects: np.ndarray | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """One sensor's signals in the real sensor's axes: one rotation for the whole trial.

    With the `effects` of a lever arm that is fitted too.
    """
    acc, gyr = made.acc[:, sensor].astype(np.float64), made.gyr[:, sensor]
    theirs = [real.acc[:, sensor], real.gyr[:, sensor]]
    weights = [1 / rms(values) for values in theirs]
    moved = acc
    for _ in range(1 if effects is None else FIT_ROUNDS):
        rotation, _ = Rotation.align_vectors(
            np.concatenate([weight * values for weight, values in zip(weights, theirs, strict=True)]),
            np.concatenate([moved * weights[0], gyr * weights[1]]),
        )
        if effects is not None:
            moved = acc + effects @ fitted_arm(rotation.inv().apply(theirs[0]) - acc, effects)
    return rotation.apply(moved), rotation.apply(gyr)


def correlation(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Pearson's r, mean of the three axes."""
    return float(np.mean([np.corrcoef(ours[:, axis], theirs[:, axis])[0, 1] for axis in range(3)]))


def rms(values: np.ndarray) -> float:
    """Root mean square of all components."""
    return float(np.sqrt(np.mean(values**2)))


def scores(made: ImuRecording, real: ImuRecording, lowpass: float) -> dict[str, dict[str, float]]:
    """Agreement site by site; `real` is the raw recording."""
    truth = below(real, lowpass)
    return {
        site: {
            "acc_r": correlation(made.acc[:, sensor], truth.acc[:, sensor]),
            "gyr_r": correlation(made.gyr[:, sensor], truth.gyr[:, sensor]),
        }
        for sensor, site in enumerate(real.sites)
    }


def below(recording: ImuRecording, cutoff: float) -> ImuRecording:
    """The recording's content below a frequency, Hz."""
    acc, gyr = (_lowpass(values, recording.rate, cutoff) for values in (recording.acc, recording.gyr))
    return ImuRecording(acc, gyr, recording.rate, recording.sites)


def _lowpass(values: np.ndarray, rate: float, cutoff: float) -> np.ndarray:
    return np.moveaxis(butterworth(np.moveaxis(values, 0, -1), rate, cutoff, zero_phase=True), -1, 0)


def print_table(found: dict[str, dict[str, dict[str, float]]], sites: tuple[str, ...]) -> None:
    """A row a method, a column a site; accelerometer, then gyroscope."""
    for name, title in (("acc_r", "accelerometer r"), ("gyr_r", "gyroscope r")):
        print(f"| {title} | mean | " + " | ".join(sites) + " |\n|" + "---|" * (len(sites) + 2))
        for method, rows in found.items():
            values = [rows[site][name] for site in sites]
            print(f"| {method} | {np.mean(values):.3f} | " + " | ".join(f"{v:.2f}" for v in values) + " |")
        print()


def main() -> None:
    """Measure and print."""
    trial = read_gait(DATA, TRIAL)
    real, body = trial.recording, Body.bundled()
    motion = retarget(read_source(), body).motion
    road, names = site_poses(trial, body, motion)
    smoothed, _ = site_poses(trial, body, smoothed_root(motion, ROOT_HZ))
    vicon = vicon_poses(trial)
    title = f"W2W, root smoothed below {ROOT_HZ:g} Hz"
    poses = {
        "W2W": (road, motion.rate, False, AS_DEFAULT),
        title: (smoothed, motion.rate, False, AS_DEFAULT),
        f"{title}, band {NARROW_HZ:g} Hz": (smoothed, motion.rate, False, NARROW_HZ),
        "Vicon joints": (vicon, real.rate, False, AS_DEFAULT),
        "Vicon joints, lever arms fitted": (vicon, real.rate, True, AS_DEFAULT),
    }
    print("\npatches: " + ", ".join(f"{site} {name}" for site, name in zip(real.sites, names, strict=True)))
    for lowpass in LOWPASS_HZ:
        made = {
            name: compare(matrices, rate, real, lowpass, fit, band)
            for name, (matrices, rate, fit, band) in poses.items()
        }
        found = {name: scores(recording, real, lowpass) for name, recording in made.items()}
        print(f"\nbelow {lowpass:g} Hz\n")
        print_table(found, real.sites)


if __name__ == "__main__":
    main()
