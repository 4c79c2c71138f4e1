# SPDX-License-Identifier: GPL-3.0-or-later
"""Synthesis against a real IMU: BROAD's optical pose at 60 Hz in, the sensor on the same body as the truth.

    python -m w2w_studies.experiments.broad

Each method turns the same 60 Hz pose into signals; they and the sensor's are brought to the sensor's time
stamps and low-passed alike (Butterworth, zero phase). Scores are over the samples that BROAD marks as
movement and whose pose was seen: Pearson's r, the mean of the three axes, and the root mean square error.

Three stages, each method alike. First as it stands, nothing fitted. Then with one time shift: optics and IMU
are synchronised to a few milliseconds only, and some methods lag. It is the shift at which the method's
angular speed follows the real one best; speed has no axes, and the accelerometer has no say. Last, to see
what is left of the method itself, also with the lever arm from the optical point to the accelerometer, found
by least squares; this stage is no proof, for it fits three numbers to the signal it is scored on. Axes,
biases and scales are never estimated.
"""

import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import minimize_scalar
from scipy.spatial.transform import Rotation, Slerp

from w2w.core.filtering import butterworth
from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis, synthesize

from ..datasets.broad import BroadTrial, read_broad
from ..paper.differences import synthesize_by_differences
from .gait import correlation
from .lever_arms import fitted_arm, lever_effects

TRIALS = Path(__file__).resolve().parents[5] / "shared" / "data" / "imu" / "broad"
POSE_HZ, LOWPASS_HZ = 60.0, 10.0
LARGEST_SHIFT_S = 0.05
NEAR_GAP_S = 0.25

BAND_MARGIN = 1.5
"""Band limit of W2W's trajectories over the band that is scored: above it there is only noise to win."""

Signals = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Times (T,), specific force (T, 3) in m/s2 and angular velocity (T, 3) in rad/s."""


def pose_at(trial: BroadTrial, rate: float = POSE_HZ) -> tuple[np.ndarray, np.ndarray]:
    """Times, and the optical pose at those times, (T, 4, 4): lines and great arcs between what was seen."""
    seen = _seen(trial)
    stamps = trial.recording.time[seen]
    matrices = trial.matrices[seen, 0]
    times = stamps[0] + np.arange(int((stamps[-1] - stamps[0]) * rate) + 1) / rate
    pose = np.zeros((len(times), 4, 4))
    pose[:, :3, :3] = Slerp(stamps, Rotation.from_matrix(matrices[:, :3, :3]))(times).as_matrix()
    for axis in range(3):
        pose[:, axis, 3] = np.interp(times, stamps, matrices[:, axis, 3])
    pose[:, 3, 3] = 1
    return times, pose


def _seen(trial: BroadTrial) -> np.ndarray:
    return np.isfinite(trial.matrices).all(axis=(1, 2, 3))


def w2w(settings: Synthesis, make: Callable = synthesize) -> Callable[[np.ndarray, np.ndarray], Signals]:
    """This package."""

    def method(times: np.ndarray, pose: np.ndarray) -> Signals:
        recording = make(pose[:, None], 1 / (times[1] - times[0]), settings)
        return times[0] + recording.time, recording.acc[:, 0], recording.gyr[:, 0]

    return method


def central_differences(times: np.ndarray, pose: np.ndarray) -> Signals:
    """Second central difference of the position, first of the rotation."""
    step = times[1] - times[0]
    turn, place = Rotation.from_matrix(pose[:, :3, :3]), pose[:, :3, 3]
    acceleration = (place[2:] - 2 * place[1:-1] + place[:-2]) / step**2
    force = turn[1:-1].inv().apply(acceleration + [0, 0, STANDARD_GRAVITY])
    return times[1:-1], force, (turn[:-2].inv() * turn[2:]).as_rotvec() / (2 * step)


def x_io(sample_rate: float | None) -> Callable[[np.ndarray, np.ndarray], Signals]:
    """x-io's imusim 1.1.2 with its default bandwidth, at the pose's rate or another."""

    def method(times: np.ndarray, pose: np.ndarray) -> Signals:
        from imusim import Simulator

        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "pose.csv"
            quaternions = Rotation.from_matrix(pose[:, :3, :3]).as_quat()[:, [3, 0, 1, 2]]
            table = np.column_stack([times, pose[:, :3, 3], quaternions])
            np.savetxt(path, table, delimiter=",", header="time,x,y,z,qw,qx,qy,qz")
            simulator = Simulator(str(path), sample_rate=sample_rate)
        force = simulator.accelerometer * Simulator.GRAVITY
        return times[0] + simulator.time, np.asarray(force), np.radians(simulator.gyroscope)

    return method


def methods(sensor_rate: float) -> dict[str, Callable[[np.ndarray, np.ndarray], Signals]]:
    """What is compared, by name."""
    paper = {"rate_hz": POSE_HZ, "convention": "paper", "cutoff_hz": None}
    differences = synthesize_by_differences
    return {
        "W2W splines": w2w(Synthesis(rate_hz=sensor_rate, cutoff_hz=BAND_MARGIN * LOWPASS_HZ)),
        "W2W splines, default 10 Hz band": w2w(Synthesis(rate_hz=sensor_rate)),
        "plain central differences": central_differences,
        "x-io imusim 1.1.2": x_io(None),
        "x-io imusim at the sensor's rate": x_io(sensor_rate),
        "paper as printed": w2w(Synthesis(gravity=(0, -9.81, 0), **paper), differences),
        "paper, gravity along z": w2w(Synthesis(gravity=(0, 0, -9.81), **paper), differences),
    }


def score(trial: BroadTrial, signals: Signals) -> dict[str, float]:
    """Agreement as it stands and at the best time shift, over moving samples with a pose."""
    stamps, rate = trial.recording.time, trial.recording.rate
    times, *channels = signals
    inside = (stamps >= times[0]) & (stamps <= times[-1])
    counted = (trial.movement & _far_from_gaps(trial))[inside]
    filtered = lambda values: butterworth(values.T.astype(np.float64), rate, LOWPASS_HZ, 2, zero_phase=True).T  # noqa: E731
    real = [filtered(values[inside, 0])[counted] for values in (trial.recording.acc, trial.recording.gyr)]
    made = [CubicSpline(stamps[inside], filtered(CubicSpline(times, c)(stamps[inside]))) for c in channels]
    at = stamps[inside][counted]

    def agreement(shift: float, lever_arm: bool = False) -> dict[str, float]:
        acc, gyr = (spline(np.clip(at + shift, times[0], times[-1])) for spline in made)
        if lever_arm:
            effects = lever_effects(gyr, made[1](np.clip(at + shift, times[0], times[-1]), nu=1))
            acc = acc + effects @ fitted_arm(real[0] - acc, effects)
        return {
            "acc_r": correlation(real[0], acc),
            "acc_rmse": float(np.sqrt(((real[0] - acc) ** 2).mean())),
            "gyr_r": correlation(real[1], gyr),
        }

    speed = np.linalg.norm(real[1], axis=1)

    def disagreement(shift: float) -> float:
        made_speed = np.linalg.norm(made[1](np.clip(at + shift, times[0], times[-1])), axis=1)
        return -float(np.corrcoef(speed, made_speed)[0, 1])

    best = minimize_scalar(disagreement, bounds=(-LARGEST_SHIFT_S, LARGEST_SHIFT_S), method="bounded").x
    return {
        "as it stands": agreement(0.0),
        "shifted": {"shift_ms": 1e3 * float(best), **agreement(best)},
        "shifted, lever arm": agreement(best, lever_arm=True),
    }


def _far_from_gaps(trial: BroadTrial) -> np.ndarray:
    reach = int(NEAR_GAP_S * trial.recording.rate)
    return np.convolve(~_seen(trial), np.ones(2 * reach + 1), mode="same") < 0.5


def run(path: Path) -> dict[str, dict]:
    """Scores of all methods on one trial."""
    trial = read_broad(path)
    times, pose = pose_at(trial)
    scores = {}
    for name, method in methods(trial.recording.rate).items():
        try:
            scores[name] = score(trial, method(times, pose))
        except ModuleNotFoundError as error:
            print(f"{name}: left out, {error.name} is not installed")
    return scores


def main() -> None:
    """Print a table for every trial."""
    for path in sorted(TRIALS.glob("*.hdf5")):
        print(f"{path.stem}: pose at {POSE_HZ:g} Hz, all below {LOWPASS_HZ:g} Hz; acc RMSE in m/s2\n")
        print(
            "| method | acc r | acc RMSE | gyr r | shift ms | acc r | acc RMSE | gyr r | acc r | acc RMSE |"
        )
        print("|" + "---|" * 10)
        for name, found in run(path).items():
            here, shifted, moved = found.values()
            print(
                f"| {name} | {here['acc_r']:.4f} | {here['acc_rmse']:.3f} | {here['gyr_r']:.5f} "
                f"| {shifted['shift_ms']:.1f} | {shifted['acc_r']:.4f} | {shifted['acc_rmse']:.3f} "
                f"| {shifted['gyr_r']:.5f} | {moved['acc_r']:.4f} | {moved['acc_rmse']:.3f} |"
            )


if __name__ == "__main__":
    main()
