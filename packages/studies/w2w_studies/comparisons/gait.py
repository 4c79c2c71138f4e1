# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk with nine worn Xsens sensors and its full-body BVH: signals, energies and gait phases by site."""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.files import write_json, write_text
from w2w.core.filtering import butterworth
from w2w.core.imu.calibration import Correlations, held_out
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.library.library import Clip
from w2w.core.motion.motion import Motion, smoothed_root
from w2w.core.ranking.agreement import Agreement, rank_agreement
from w2w.headless.runs.clip import load_clip

from ..datasets.gait import GaitTrial, read_gait
from ..datasets.gait_sites import SITES
from ..validation.correlation import Correlation, magnitude_correlation
from ..validation.protocol import Found
from ..validation.sites import SiteValidation, validate_sites
from .gait_phases import PHASES, PhasesTaught, phase_windows, phases, taught_phases
from .report import agreement_table, write_validation
from .site_simulator import SiteSimulator, error_sentence

LOWPASS_HZ, LONGEST_LAG_S, ROOT_HZ = 10.0, 0.1, 3.0


class GaitValidation(NamedTuple):
    """What was found, site by site."""

    sites: tuple[str, ...]
    simulated_at: tuple[str, ...]
    acc: list[Correlation]
    gyr: list[Correlation]
    """Magnitudes, real against simulated."""
    energy: dict[str, tuple[np.ndarray, np.ndarray]]
    """Root mean square of the alternating magnitude of each kind, (N,), real and simulated."""
    energy_agreement: dict[str, Agreement]
    phases: SiteValidation
    calibrated: list[list[Correlations]]  # of both halves of the walk, each after a calibration on the other
    taught: list[PhasesTaught]  # phases of the worn sensors, named by what was learned from simulated ones


def compare_gait(folder: Path, trial: str, seed: int, sensor: SensorModel) -> GaitValidation:
    """Simulate a trial's sensors, with a part's errors, from its BVH and compare.

    Raises ValueError if files are missing or do not belong together.
    """
    worn = read_gait(folder, trial)
    unknown = [site for site in worn.recording.sites if site not in SITES]
    if unknown:
        raise ValueError(f"where the sensors {', '.join(unknown)} sat is not known")
    sites = {site: SITES[site].on_body for site in worn.recording.sites}
    simulator = SiteSimulator(sites, worn.recording.rate, sensor, seed)
    made = simulator.record(_walk(folder / f"xsens_{trial}.bvh", worn, simulator.body))
    real = worn.recording
    n = min(real.n_samples, made.n_samples)
    acc, gyr = (
        [
            magnitude_correlation(a[:n, k], b[:n, k], real.rate, LOWPASS_HZ, LONGEST_LAG_S)
            for k in range(real.n_sensors)
        ]
        for a, b in ((real.acc, made.acc), (real.gyr, made.gyr))
    )
    energy = {
        kind: tuple(_energy(getattr(side, kind)[:n], real.rate) for side in (real, made))
        for kind in ("acc", "gyr")
    }
    phase = phases(worn)[:n]
    pairs = [(_one(real, k, n), _one(made, k, n)) for k in range(real.n_sensors)]
    sides = [phase_windows(side, phase) for side in (real, made)]
    return GaitValidation(
        real.sites, simulator.simulated_at, acc, gyr, energy,
        {kind: rank_agreement(*values, seed=seed) for kind, values in energy.items()},
        validate_sites(*sides, real.sites, PHASES, seed=seed),
        [held_out([pair], LONGEST_LAG_S)[1] for pair in pairs],
        taught_phases(pairs, phase, LONGEST_LAG_S, seed),
    )  # fmt: skip


def _one(recording: ImuRecording, sensor: int, n_samples: int) -> ImuRecording:
    """One sensor's recording, cut to a length."""
    part = slice(None, n_samples), slice(sensor, sensor + 1)
    return ImuRecording(recording.acc[part], recording.gyr[part], recording.rate, clip=recording.clip)


def _walk(path: Path, worn: GaitTrial, body: Body) -> Motion:
    """The frames of the BVH that the sensors' samples belong to; leading T-poses are not among those read."""
    if not path.is_file():
        raise ValueError(f"{path} is missing: the trial's full-body motion")
    counted = re.search(r"^\s*Frames:\s*(\d+)", path.read_text(errors="replace"), re.MULTILINE)
    if not counted:
        raise ValueError(f"{path} does not say how many frames it has")
    _, motion, _ = load_clip(Clip(path, path.name, path.stem, "walk"), body)
    motion = smoothed_root(motion, ROOT_HZ)
    first = worn.first_row - (int(counted[1]) - motion.n_frames)
    frames = slice(first, first + worn.recording.n_samples)
    if first < 0 or first + worn.recording.n_samples > motion.n_frames:
        raise ValueError(f"{path} does not reach over the sensors' samples")
    return Motion(motion.rotations[frames], motion.pelvis[frames], motion.rate, "walk", clip=path.stem)


def _energy(values: np.ndarray, rate: float) -> np.ndarray:
    slow = butterworth(values.transpose(1, 2, 0).astype(np.float64), rate, LOWPASS_HZ, 2, zero_phase=True)
    return np.linalg.norm(slow, axis=1).std(axis=1)


def write_gait(out: Path, found: GaitValidation, sensor: SensorModel) -> str:
    """Write ``report.md`` and ``signals.json``, besides `write_validation`'s files; returns the report."""
    notes = [
        "Paired: one walk of one person; nothing is fitted. The BVH is from the same suit's sensors, so the "
        "pose is not independent of them; its root path is low-passed at 3 Hz (docs/signals.md).",
        error_sentence(sensor),
        "Gait phases by the speed of Vicon's ankles; stretches of a second are never split.",
    ]
    phases = Found("phases", "", found.phases, notes, found.simulated_at)
    write_validation(out, phases, "Gait phases: worn and simulated sensors")
    lines = ["# Gait: nine worn sensors and simulated ones", "", *(f"- {note}" for note in notes), ""]
    lines += _signal_table(found)
    lines += ["", *_calibrated_table(found)]
    lines += ["", "| ranking of the sites by | rho | 95 % interval (sites) | p |", "|---|---|---|---|"]
    names = {"acc": "energy of acceleration", "gyr": "energy of angular velocity"}
    for kind, found_so in found.energy_agreement.items():
        lines.append(
            f"| {names[kind]} | {found_so.spearman:.2f} | {found_so.low:.2f} to {found_so.high:.2f} | "
            f"{found_so.p_value:.3f} |"
        )
    lines += ["", "## Gait phases", "", found.phases.sentence(), "", *agreement_table(found.phases), ""]
    lines += _taught_table(found)
    lines += ["![F1 of gait phases by site](f1_sites_phases.png)", ""]
    write_json(out / "signals.json", _content(found))
    write_text(out / "report.md", "\n".join(lines))
    return "\n".join(lines)


def _signal_table(found: GaitValidation) -> Sequence[str]:
    lines = [
        "| site | patch | acc r | best lag | gyr r | best lag | acc energy real, simulated | gyr energy |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for k, (site, patch) in enumerate(zip(found.sites, found.simulated_at, strict=True)):
        energies = [", ".join(f"{side[k]:.2f}" for side in found.energy[kind]) for kind in ("acc", "gyr")]
        lines.append(
            f"| {site} | {patch} | {found.acc[k].zero_lag:.2f} | {found.acc[k].best_lag:.2f} "
            f"| {found.gyr[k].zero_lag:.2f} | {found.gyr[k].best_lag:.2f} | {energies[0]} | {energies[1]} |"
        )
    return lines


def _calibrated_table(found: GaitValidation) -> list[str]:
    lines = [
        "r over samples and axes, of each half of the walk after a calibration on the other:",
        "",
        "| site | force, as simulated | calibrated | turning, as simulated | calibrated |",
        "|---|---|---|---|---|",
    ]
    for site, halves in zip(found.sites, found.calibrated, strict=True):
        cells = np.mean([(*half.force, *half.turning) for half in halves], axis=0)
        lines.append(f"| {site} | {' | '.join(f'{r:.2f}' for r in cells)} |")
    return lines


def _taught_table(found: GaitValidation) -> list[str]:
    lines = [
        "Each half of the walk is named by what was learned from the other, with nothing fitted to it; macro "
        "F1 (95 % of resamples of its stretches of a second):",
        "",
        "| learned from | mean of the sites | by site |",
        "|---|---|---|",
    ]
    for one in found.taught:
        sites = ", ".join(f"{site} {f1:.2f}" for site, f1 in zip(found.sites, one.by_site, strict=True))
        lines.append(f"| {one.way} | {one.mean:.2f} ({one.low:.2f} to {one.high:.2f}) | {sites} |")
    return [*lines, ""]


def _content(found: GaitValidation) -> dict:
    return {
        site: {
            "patch": found.simulated_at[k],
            "acc": [round(v, 4) for v in found.acc[k]],
            "gyr": [round(v, 4) for v in found.gyr[k]],
            **{
                f"{kind} energy": [round(float(side[k]), 4) for side in found.energy[kind]]
                for kind in ("acc", "gyr")
            },
            **{
                f"{kind} r before and after calibration": np.mean(
                    [getattr(half, kind) for half in found.calibrated[k]], axis=0
                )
                .round(4)
                .tolist()
                for kind in Correlations._fields
            },
        }
        for k, site in enumerate(found.sites)
    }
