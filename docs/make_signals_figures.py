# SPDX-License-Identifier: GPL-3.0-or-later
"""Figures of docs/signals.md.

python docs/make_signals_figures.py
"""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from scipy.spatial.transform import Rotation

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.imu.synthesis import STANDARD_GRAVITY, Synthesis, synthesize
from w2w_studies.paper.differences import synthesize_by_differences

PICTURES = Path(__file__).resolve().parent / "pictures"
AXES = ("x", "y", "z")
COLOURS = ("#c1272d", "#2e7d32", "#1f4e9e")


def arm_swing(t: np.ndarray) -> np.ndarray:
    """World matrices (T, 1, 4, 4) of a wrist: still, then swinging from the shoulder while the body turns."""
    moving = np.clip(t - 1, 0, None)
    ease = 1 - np.exp(-((moving / 0.4) ** 2))
    swing = 0.8 * ease * np.sin(2 * np.pi * 0.9 * moving)
    turn = Rotation.from_euler("z", 0.9 * moving * ease) * Rotation.from_euler("y", swing)
    matrices = np.zeros((len(t), 1, 4, 4))
    matrices[:, 0, :3, :3] = turn.as_matrix()
    matrices[:, 0, :3, 3] = turn.apply([0.0, 0.2, -0.6])
    matrices[:, 0, 3, 3] = 1
    return matrices


def truth(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same wrist's signals from steps of a ten-thousandth of a second."""
    step = 1e-4
    before, now, after = (arm_swing(t + shift)[:, 0] for shift in (-step, 0, step))
    acceleration = (after - 2 * now + before)[:, :3, 3] / step**2
    turns = [Rotation.from_matrix(m[:, :3, :3]) for m in (before, now, after)]
    force = turns[1].inv().apply(acceleration + [0, 0, STANDARD_GRAVITY])
    return force, (turns[0].inv() * turns[2]).as_rotvec() / (2 * step)


def draw_conventions() -> None:
    """The physical equations and the printed ones on the same swing of an arm."""
    rate = 60
    matrices = arm_swing(np.arange(5 * rate + 1) / rate)
    physical = synthesize(matrices, rate, Synthesis(rate_hz=100, cutoff_hz=None))
    as_printed = Synthesis(rate_hz=100, convention="paper", cutoff_hz=None)
    printed = synthesize_by_differences(matrices, rate, as_printed)
    force, spin = truth(physical.time)
    figure, grid = plt.subplots(2, 2, figsize=(10, 5.4), sharex=True, sharey="row", layout="constrained")
    for column, (recording, title) in enumerate(((physical, "physical"), (printed, "as printed"))):
        for row, (values, exact, label) in enumerate(
            ((recording.acc, force, "accelerometer, m/s²"), (recording.gyr, spin, "gyroscope, rad/s"))
        ):
            axes = grid[row, column]
            for axis in range(3):
                axes.plot(physical.time, exact[:, axis], color=COLOURS[axis], alpha=0.25, linewidth=4)
                axes.plot(
                    recording.time, values[:, 0, axis], color=COLOURS[axis], linewidth=1, label=AXES[axis]
                )
            axes.set_title(f"{title}: {label}", fontsize=10)
    grid[0, 0].legend(ncols=3, fontsize=8, loc="lower left")
    grid[0, 0].annotate(
        "at rest: +g on z", (0.5, 9.8), (0.2, 15.5), fontsize=8, arrowprops={"arrowstyle": "-"}
    )
    grid[0, 1].annotate(
        "at rest: −g on z", (0.5, -9.8), (0.1, -15.5), fontsize=8, arrowprops={"arrowstyle": "-"}
    )
    for axes in grid[1]:
        axes.set_xlabel("seconds; broad pale lines: the truth")
    save(figure, "signals_conventions.png")


def draw_accuracy() -> None:
    """Error against frame rate, and the Allan plot of a modelled gyroscope."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
    draw_error(left)
    draw_allan(right)
    save(figure, "signals_accuracy.png")


def draw_error(axes: Axes) -> None:
    """Error of the ideal acceleration in the middle of the swing, by method and frame rate."""
    rates = np.array([15, 24, 30, 60, 120, 240])
    for name, method, marker in (
        ("spline", synthesize, "o"),
        ("finite-difference", synthesize_by_differences, "s"),
    ):
        errors = []
        for rate in rates:
            settings = Synthesis(rate_hz=50, cutoff_hz=None)
            recording = method(arm_swing(np.arange(6 * rate + 1) / rate), rate, settings)
            force, _ = truth(recording.time)
            inside = (recording.time > 2.5) & (recording.time < 5)
            errors.append(np.sqrt(((recording.acc[:, 0] - force)[inside] ** 2).mean()))
        axes.loglog(rates, errors, marker + "-", label=name)
    axes.set_xticks(rates, [str(rate) for rate in rates])
    axes.minorticks_off()
    axes.set_xlabel("frames per second")
    axes.set_ylabel("RMS error of specific force, m/s²")
    axes.set_title("no band limit, arm swing", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend()


def draw_allan(axes: Axes) -> None:
    """Allan deviation of ten hours at rest beside what each parameter should give."""
    rate, n_samples = 10.0, 360_000
    triad = Triad(noise_density=0.007, bias_instability=0.003, correlation_s=60.0, random_walk=3e-5)
    still = ImuRecording(acc=np.zeros((n_samples, 3, 3)), gyr=np.zeros((n_samples, 3, 3)), rate=rate)
    gyr = SensorModel(gyroscope=triad).apply(still, seed=0).gyr.reshape(n_samples, -1)
    angle = np.cumsum(gyr, axis=0, dtype=np.float64) / rate
    lags = np.unique(np.geomspace(1, n_samples / 6, 50).astype(int))
    tau = lags / rate
    second = [angle[2 * lag :] - 2 * angle[lag:-lag] + angle[: -2 * lag] for lag in lags]
    deviation = [np.sqrt((s**2).mean() / 2) / t for s, t in zip(second, tau, strict=True)]
    axes.loglog(tau, deviation, "k.", label="ten hours at rest")
    axes.loglog(tau, triad.noise_density / np.sqrt(2 * tau), label="noise_density / √(2τ)")
    axes.loglog(tau, np.full_like(tau, 0.664 * triad.bias_instability), label="0.664 bias_instability")
    axes.loglog(tau, triad.random_walk * np.sqrt(tau / 3), label="random_walk √(τ/3)")
    axes.set_ylim(1e-4, 3e-2)
    axes.set_xlabel("averaging time τ, s")
    axes.set_ylabel("Allan deviation, °/s")
    axes.set_title("modelled gyroscope", fontsize=10)
    axes.grid(alpha=0.3)
    axes.legend(fontsize=8)


def save(figure: plt.Figure, name: str) -> None:
    """Write a picture without its date, so that equal figures are equal files."""
    PICTURES.mkdir(exist_ok=True)
    figure.savefig(PICTURES / name, dpi=110, metadata={"Software": None})
    plt.close(figure)


if __name__ == "__main__":
    plt.switch_backend("agg")
    draw_conventions()
    draw_accuracy()
