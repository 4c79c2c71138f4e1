# SPDX-License-Identifier: GPL-3.0-or-later
"""Speed and memory of synthesis: 512 sensors, 60 s at 100 Hz from poses at 60 frames/s, beside its peers.

    python -m benchmarks.synthesis_speed [--repeats 5] [--minutes 10] [--json OUT.json]

Sensor-seconds per second of wall clock, best of several repeats; the processor time beside it tells how busy
the machine was. "Every part" is the whole way from poses to readings with all parts of the sensor model on.
Peers run on fewer sensors, for they take one at a time: the textbook loop (scipy's CubicSpline and
RotationSpline, one sensor after another) and x-io's imusim 1.1.2, ideal and with its own error model.
Memory is the peak of a fresh process that records the bundled body's 512 patches over a long clip.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from w2w.core.files import write_json
from w2w.core.imu.presets import preset
from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis, synthesize

N_SENSORS = 512
SECONDS = 60
FRAME_RATE = 60
SETTINGS = Synthesis(rate_hz=100.0)

EVERY_PART = SensorModel(
    name="every part",
    accelerometer=Triad(
        full_scale=78.0,
        resolution=0.0024,
        noise_density=0.0016,
        bias_instability=0.0005,
        random_walk=0.0001,
        turn_on_bias=0.2,
        scale_error=0.01,
        misalignment_deg=0.5,
        nonorthogonality_deg=0.5,
        lowpass_hz=40.0,
    ),
    gyroscope=Triad(
        full_scale=35.0,
        resolution=0.001,
        noise_density=0.0001,
        bias_instability=0.00005,
        random_walk=0.00001,
        turn_on_bias=0.01,
        scale_error=0.01,
        misalignment_deg=0.5,
        nonorthogonality_deg=0.5,
        lowpass_hz=40.0,
    ),
    g_sensitivity=0.0002,
    jitter_s=0.0005,
    drop_fraction=0.005,
    drop_duration_s=0.03,
    mounting_turn_deg=5.0,
    mounting_shift_m=0.01,
    soft_tissue_hz=12.0,
)


def poses(n_sensors: int, seconds: float) -> np.ndarray:
    """Smooth motions of a hand's size and speed, (T, N, 4, 4)."""
    rng = np.random.default_rng(0)
    t = np.arange(int(seconds * FRAME_RATE) + 1)[:, None, None] / FRAME_RATE
    hz, phase = rng.uniform(0.3, 3, (2, 1, n_sensors, 3)), rng.uniform(0, 6, (2, 1, n_sensors, 3))
    matrices = np.zeros((len(t), n_sensors, 4, 4))
    matrices[..., :3, 3] = 0.3 * np.sin(2 * np.pi * hz[0] * t + phase[0])
    turns = Rotation.from_rotvec((1.5 * np.sin(2 * np.pi * hz[1] * t + phase[1])).reshape(-1, 3))
    matrices[..., :3, :3] = turns.as_matrix().reshape(len(t), n_sensors, 3, 3)
    matrices[..., 3, 3] = 1
    return matrices


def sensor_loop(matrices: np.ndarray) -> None:
    """The textbook way, one sensor after another."""
    at = np.arange(len(matrices)) / FRAME_RATE
    samples = np.arange(0, at[-1], 1 / SETTINGS.rate_hz)
    for sensor in range(matrices.shape[1]):
        turns = RotationSpline(at, Rotation.from_matrix(matrices[:, sensor, :3, :3]))
        acceleration = CubicSpline(at, matrices[:, sensor, :3, 3])(samples, nu=2)
        turns(samples).inv().apply(acceleration + [0, 0, STANDARD_GRAVITY])
        turns(samples, order=1)


def x_io(matrices: np.ndarray, folder: Path, with_errors: bool) -> Callable[[], None]:
    """x-io's simulator on every sensor, from the CSV files it reads."""
    from imusim import Simulator

    at = np.arange(len(matrices)) / FRAME_RATE
    paths = [folder / f"{sensor}.csv" for sensor in range(matrices.shape[1])]
    for sensor, path in enumerate(paths):
        quaternions = Rotation.from_matrix(matrices[:, sensor, :3, :3]).as_quat()[:, [3, 0, 1, 2]]
        table = np.column_stack([at, matrices[:, sensor, :3, 3], quaternions])
        np.savetxt(path, table, delimiter=",", header="time,x,y,z,qw,qx,qy,qz")
    errors = {
        "bandwidth": 40,
        "offset": np.full(3, 0.1),
        "sensitivity_error": np.ones(3),
        "noise_density": np.full(3, 0.01),
        "cross_axis": np.ones(3),
        "misalignment": 1,
        "bias_instability": np.full(3, 0.001),
        "number_of_poles": 10,
        "random_walk": np.full(3, 1e-5),
    }

    def work() -> None:
        for path in paths:
            simulator = Simulator(str(path), sample_rate=SETTINGS.rate_hz)
            if with_errors:
                simulator.set_gyroscope(range=2000, **errors)
                simulator.set_accelerometer(range=8, **errors)

    return work


def best_of(work: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Shortest wall clock and processor time, s."""
    timings = []
    for _ in range(repeats):
        wall, processor = time.perf_counter(), time.process_time()
        work()
        timings.append((time.perf_counter() - wall, time.process_time() - processor))
    return min(t[0] for t in timings), min(t[1] for t in timings)


def record_long_clip(minutes: float) -> None:
    """Record the bundled body over a long clip and print the peak memory of this process, MB."""
    from w2w.core.body.body import N_JOINTS, Body
    from w2w.core.imu.virtual import record_motion
    from w2w.core.motion.motion import Motion
    from w2w.core.patches.patches import sample_patches

    body = Body.bundled()
    patches = sample_patches(body, N_SENSORS)
    t = np.arange(int(minutes * 60 * FRAME_RATE))[:, None] / FRAME_RATE
    hz = np.random.default_rng(0).uniform(0.2, 2, N_JOINTS)
    turns = np.zeros((len(t), N_JOINTS, 3))
    turns[..., 0] = 0.5 * np.sin(2 * np.pi * hz * t)
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_matrix().reshape(*turns.shape, 3)
    motion = Motion(rotations, np.tile([0, 0, 1.0], (len(t), 1)), FRAME_RATE)
    started = time.perf_counter()
    recording = record_motion(body, patches, motion, SETTINGS, preset("bmi270"))
    elapsed = time.perf_counter() - started
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{peak:.0f} {recording.acc.nbytes * 2 / 2**20:.0f} {elapsed:.1f}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument(
        "--minutes", type=float, default=10.0, help="length of the clip memory is measured on"
    )
    parser.add_argument("--json", type=Path, help="also write the figures here")
    parser.add_argument("--long-clip", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.long_clip:
        record_long_clip(options.minutes)
        return
    matrices = poses(N_SENSORS, SECONDS)
    few = matrices[:, :4]
    ideal = synthesize(matrices, FRAME_RATE, SETTINGS)
    with tempfile.TemporaryDirectory() as folder:
        rows: dict[str, tuple[Callable[[], object], int]] = {
            "W2W ideal": (lambda: synthesize(matrices, FRAME_RATE, SETTINGS), N_SENSORS),
            "W2W with every part": (
                lambda: EVERY_PART.apply(synthesize(matrices, FRAME_RATE, SETTINGS), seed=0),
                N_SENSORS,
            ),
            "W2W sensor model alone, every part": (lambda: EVERY_PART.apply(ideal, seed=0), N_SENSORS),
            "W2W sensor model alone, bmi270": (lambda: preset("bmi270").apply(ideal, seed=0), N_SENSORS),
            "loop over sensors, scipy": (lambda: sensor_loop(few), 4),
        }
        try:
            rows["x-io imusim 1.1.2, ideal"] = (x_io(few[:, :1], Path(folder), with_errors=False), 1)
            rows["x-io imusim 1.1.2, its errors"] = (x_io(few[:, :1], Path(folder), with_errors=True), 1)
        except ModuleNotFoundError as error:
            print(f"x-io imusim left out: {error.name} is not installed")
        print(f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}; {N_SENSORS} sensors x {SECONDS} s\n")
        print("| what | sensor-seconds/s | wall s | processor s | sensors |\n|---|---|---|---|---|")
        figures = {}
        for name, (work, n_sensors) in rows.items():
            wall, processor = best_of(work, options.repeats if n_sensors == N_SENSORS else 2)
            figures[name] = {
                "sensor_seconds_per_second": n_sensors * SECONDS / wall,
                "processor_s": processor,
            }
            speed = figures[name]["sensor_seconds_per_second"]
            print(f"| {name} | {speed:,.0f} | {wall:.3f} | {processor:.3f} | {n_sensors} |")
    command = [
        sys.executable,
        "-m",
        "benchmarks.synthesis_speed",
        "--long-clip",
        "--minutes",
        str(options.minutes),
    ]
    peak, size, elapsed = subprocess.run(command, check=True, capture_output=True, text=True).stdout.split()
    print(
        f"\n{options.minutes:g} min on the body: peak {peak} MB, the recording {size} MB of it; {elapsed} s"
    )
    figures["long clip"] = {"minutes": options.minutes, "peak_mb": float(peak), "seconds": float(elapsed)}
    if options.json:
        write_json(options.json, figures)


if __name__ == "__main__":
    main()
