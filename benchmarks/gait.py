# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole road against worn sensors: full-body Xsens BVH in, nine real IMUs as the truth.

    python -m benchmarks.gait [--lowpass 10] [--plot OUT.png] [--json OUT.json]

The BVH is read through Blender, retargeted to the bundled body, skinned; the patch nearest each
worn sensor's site gives its signal. No lever arm, time shift, bias or scale is fitted: only one
constant rotation a sensor, from the sensor's axes to the patch's, since nobody knows how a strap
sat. Real and simulated signals are low-passed alike (Butterworth, zero phase). Scores are
Pearson's r, the mean of the three axes. The baseline in the same run are the Vicon joints: the
path of the nearest joint and the turn of its segment, with the lever arm fitted as well.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import bpy
import numpy as np
from scipy.signal import welch
from scipy.spatial.transform import Rotation

from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.files import write_json
from blender_addon.w2w.core.filtering import butterworth
from blender_addon.w2w.core.imu import Synthesis, synthesize
from blender_addon.w2w.core.imu_datasets import GaitTrial, read_gait
from blender_addon.w2w.core.motion import Motion
from blender_addon.w2w.core.patches import sample_patches
from blender_addon.w2w.core.placements import resolve
from blender_addon.w2w.core.recording import ImuRecording
from blender_addon.w2w.core.retarget import retarget
from blender_addon.w2w.core.skinning import patch_matrices
from blender_addon.w2w.scene.clips import read_clip

DATA = Path(__file__).resolve().parents[2] / "shared" / "data" / "imu" / "gait"
TRIAL = "S02-Trial-Walk-1"

BVH_FRAMES = 2503
"""Frames of the BVH file; the sensors' rows are counted in them."""

SITES = {
    "Pelvis": "sacrum",
    "L_UpLeg": "left thigh lateral",
    "R_UpLeg": "right thigh lateral",
    "L_LowLeg": "left lower leg medial",
    "R_LowLeg": "right lower leg medial",
    "L_LowLeg2": "left shin",
    "R_LowLeg2": "right shin",
    "L_Foot": "left instep",
    "R_Foot": "right instep",
}
"""Region that each worn sensor sat on: Xsens's own placements (MVN manual) and, for the second
sensor of a lower leg, its front."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--lowpass", type=float, default=10.0, help="Hz, of real and simulated signals")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--plot", type=Path, help="power spectra side by side")
    options = parser.parse_args()
    trial = read_gait(DATA, TRIAL)
    real = _filtered(trial.recording, options.lowpass)
    simulated = _filtered(simulate(trial), options.lowpass)
    rows = {}
    for sensor, site in enumerate(real.sites):
        aligned = align(simulated, real, sensor)
        rows[site] = {
            "patch": simulated.sites[sensor],
            "acc_r": correlation(aligned[0], real.acc[:, sensor]),
            "gyr_r": correlation(aligned[1], real.gyr[:, sensor]),
            "acc_rmse": rms(aligned[0] - real.acc[:, sensor]),
            "gyr_rmse": rms(aligned[1] - real.gyr[:, sensor]),
        }
        print(
            f"{site:10s} {rows[site]['patch']:28s}"
            + "".join(f" {name} {rows[site][name]:.3f}" for name in list(rows[site])[1:])
        )
    means = {name: float(np.mean([row[name] for row in rows.values()])) for name in ("acc_r", "gyr_r")}
    print(f"{'mean':10s} {'':28s} acc_r {means['acc_r']:.3f} gyr_r {means['gyr_r']:.3f}")
    if options.json:
        write_json(options.json, {"sites": rows, "mean": means, "lowpass_hz": options.lowpass})
    if options.plot:
        plot_spectra(options.plot, real, simulated)


def simulate(trial: GaitTrial) -> ImuRecording:
    """Ideal signals at the worn sites, at the sensors' rate and over the sensors' frames."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    body = Body.bundled()
    motion = retarget(read_clip(DATA / f"xsens_{TRIAL}.bvh"), body).motion
    first = trial.first_row - (BVH_FRAMES - motion.n_frames)  # leading T-pose frames are not read
    frames = slice(first, first + trial.recording.n_samples)
    patches = sample_patches(body)
    chosen = [resolve(SITES[site], body, patches) for site in trial.recording.sites]
    matrices = patch_matrices(
        body, patches, Motion(motion.rotations[frames], motion.pelvis[frames], motion.rate)
    )
    ideal = synthesize(
        matrices[:, chosen], motion.rate, Synthesis(rate_hz=trial.recording.rate, cutoff_hz=None)
    )
    return ImuRecording(ideal.acc, ideal.gyr, ideal.rate, tuple(patches.names[patch] for patch in chosen))


def align(simulated: ImuRecording, real: ImuRecording, sensor: int) -> tuple[np.ndarray, np.ndarray]:
    """The simulated signals in the real sensor's axes: one rotation for the whole trial."""
    acc, gyr = simulated.acc[:, sensor], simulated.gyr[:, sensor]
    theirs = [real.acc[:, sensor], real.gyr[:, sensor]]
    weights = [1 / rms(values) for values in theirs]
    ours_all = np.concatenate([acc * weights[0], gyr * weights[1]])
    theirs_all = np.concatenate([theirs[0] * weights[0], theirs[1] * weights[1]])
    rotation, _ = Rotation.align_vectors(theirs_all, ours_all)
    return rotation.apply(acc), rotation.apply(gyr)


def correlation(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Pearson's r, mean of the three axes."""
    return float(np.mean([np.corrcoef(ours[:, axis], theirs[:, axis])[0, 1] for axis in range(3)]))


def rms(values: np.ndarray) -> float:
    """Root mean square of the vectors' lengths, a third for each axis."""
    return float(np.sqrt(np.mean(values**2)))


def plot_spectra(path: Path, real: ImuRecording, simulated: ImuRecording) -> None:
    """Power spectra of every site, real beside simulated, summed over the axes."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12, 5), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(real.sites), sharex=True, sharey="row")
    for sensor, site in enumerate(real.sites):
        for row, (name, unit) in enumerate((("acc", "(m/s²)²/Hz"), ("gyr", "(rad/s)²/Hz"))):
            for recording, colour, label in ((real, "#1d2530", "worn"), (simulated, "#d1495b", "simulated")):
                frequency, power = welch(
                    getattr(recording, name)[:, sensor], recording.rate, nperseg=256, axis=0
                )
                axes[row, sensor].semilogy(
                    frequency, power.sum(axis=1), color=colour, linewidth=1, label=label
                )
            axes[row, sensor].set_xlim(0, 12)
            axes[row, 0].set_ylabel(f"{name} power, {unit}")
        axes[0, sensor].set_title(site, fontsize=9)
    axes[0, -1].legend(fontsize=7)
    figure.supxlabel("Frequency, Hz")
    figure.savefig(path)


def _filtered(recording: ImuRecording, cutoff: float) -> ImuRecording:
    acc, gyr = (
        np.moveaxis(butterworth(np.moveaxis(values, 0, -1), recording.rate, cutoff, zero_phase=True), -1, 0)
        for values in (recording.acc, recording.gyr)
    )
    return ImuRecording(acc, gyr, recording.rate, recording.sites)


if __name__ == "__main__":
    main()
