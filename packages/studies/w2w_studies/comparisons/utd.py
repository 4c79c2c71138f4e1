# SPDX-License-Identifier: GPL-3.0-or-later
"""UTD-MHAD: one worn sensor and a Kinect: does a body that follows the Kinect give the sensor's signals?"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from w2w.core.body.landmarks import SensorSite
from w2w.core.files import write_json, write_text
from w2w.core.imu.calibration import Correlations, held_out
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel
from w2w.core.imu.synthesis import STANDARD_GRAVITY
from w2w.core.keypoints.fit import fit_keypoints
from w2w.core.keypoints.joint_sets import JOINT_SETS
from w2w.core.windows.windows import WindowSpec

from ..datasets.utd_mhad import UTD_IMU_RATE, UtdTrial
from ..validation.calibrated_transfer import calibrated_transfer
from ..validation.correlation import Correlation, magnitude_correlation
from ..validation.transfer import Transfer, transfer
from .site_simulator import SiteSimulator, error_sentence

KINECT_20 = JOINT_SETS["kinect-20"]

SITES: dict[str, str | SensorSite] = {"right wrist": "right wrist", "right thigh": "right thigh front"}
WINDOW = WindowSpec(length_s=3.0, stride_s=3.0, short="reflect")
"""A window an action: they last 2 to 4 s."""

LOWPASS_HZ, LONGEST_LAG_S = 5.0, 0.5

POSE_CUTOFF_HZ = 3.0
"""Band of video pose, chosen on this data set (docs/evidence/people.md)."""


class PartOfUtd(NamedTuple):
    """What was found of the actions that one site was worn for."""

    site: str
    activities: tuple[str, ...]
    transfers: list[Transfer]
    steps: list[Transfer]
    """Simulated to real, one step of the calibration after the other (`calibrated_transfer`)."""
    alike: list[Correlations]  # signals before and after it, of people whom it was not fitted to
    fitted: list[Correlation]
    raw: list[Correlation]
    """Magnitude of specific force, real against simulated, clip by clip: through the body, and from the plain
    second difference of the nearest Kinect joint."""
    rates: list[Correlation]  # the same of angular velocity, through the body


def compare_utd(
    trials: Sequence[UtdTrial],
    cutoff_hz: float = POSE_CUTOFF_HZ,
    sensor: SensorModel = PRESETS[DEFAULT_SENSOR],
    seed: int = 0,
) -> list[PartOfUtd]:
    """Compare site by site, with the joints' paths below a frequency."""
    parts = []
    for site, placement in SITES.items():
        chosen = [trial for trial in trials if trial.recording.sites == (site,)]
        if not chosen:
            continue
        simulator = SiteSimulator({site: placement}, UTD_IMU_RATE, sensor, seed)
        pairs = [(trial.recording, simulated_trial(trial, simulator, cutoff_hz)) for trial in chosen]
        activities = tuple(dict.fromkeys(real.activity for real, _ in pairs))
        parts.append(
            PartOfUtd(
                site,
                activities,
                transfer(pairs, activities, WINDOW, seed),
                calibrated_transfer(pairs, activities, WINDOW, cutoff_hz, seed),
                held_out(pairs, LONGEST_LAG_S)[1],
                [_correlated(real.acc, made.acc) for real, made in pairs],
                [_correlated(t.recording.acc, second_difference(t, site)[:, None]) for t in chosen],
                [_correlated(real.gyr, made.gyr) for real, made in pairs],
            )
        )
    if not parts:
        raise ValueError("no action of UTD-MHAD with a sensor on the wrist or the thigh was found")
    return parts


def simulated_trial(trial: UtdTrial, simulator: SiteSimulator, cutoff_hz: float) -> ImuRecording:
    """What the worn sensor would record of a body that follows the Kinect."""
    fit = fit_keypoints(trial.skeleton, trial.skeleton_rate, KINECT_20, simulator.body, "y", cutoff_hz)
    real = trial.recording
    return simulator.record(fit.motion.labelled(real.activity, real.subject, real.clip))


def _correlated(real: np.ndarray, made: np.ndarray) -> Correlation:
    return magnitude_correlation(real[:, 0], made[:, 0], UTD_IMU_RATE, LOWPASS_HZ, LONGEST_LAG_S)


def second_difference(trial: UtdTrial, site: str) -> np.ndarray:
    """Specific force of the joint nearest a site by plain differences, in the world, shape (T, 3)."""
    joint = {"right wrist": "right_wrist", "right thigh": "right_knee"}[site]
    path = trial.skeleton[:, KINECT_20.joints.index(joint)].astype(np.float64)
    rate = trial.skeleton_rate
    force = np.gradient(np.gradient(path, 1 / rate, axis=0), 1 / rate, axis=0) + (0, STANDARD_GRAVITY, 0)
    times = np.arange(trial.recording.n_samples) / trial.recording.rate
    return np.stack([np.interp(times, np.arange(len(path)) / rate, column) for column in force.T], axis=1)


def write_utd(out: Path, parts: Sequence[PartOfUtd], sensor: SensorModel) -> str:
    """Write ``report.md``, ``validation.json`` and a picture a site; returns the report."""
    from .figures import confusions_figure  # matplotlib is slow to import

    out.mkdir(parents=True, exist_ok=True)
    lines = [
        "# UTD-MHAD: worn sensor and Kinect",
        "",
        "Paired: each action was worn and seen at once. The skeleton is stretched to the sensor's span "
        "(`UtdTrial.skeleton_rate`). The person tested is never trained on, nor used to find how the sensor "
        f"sat. {error_sentence(sensor)}",
        "",
    ]
    for part in parts:
        name = part.site.replace(" ", "_")
        confusions_figure(
            out / f"confusions_{name}.png",
            {f"{t.trained} to {t.tested}: F1 {t.macro_f1:.2f}": t.confusion for t in part.transfers},
            part.activities,
            f"UTD-MHAD, {part.site}: trained on one, tested on the other",
        )
        lines += [*_lines(part), "", f"![Confusions](confusions_{name}.png)", ""]
    write_json(out / "validation.json", {part.site: _content(part) for part in parts})
    text = "\n".join(lines)
    write_text(out / "report.md", text)
    return text


def _lines(part: PartOfUtd) -> list[str]:
    lines = [f"## {part.site}: {len(part.fitted)} clips of {len(part.activities)} actions", ""]
    lines += ["| trained on | tested on | macro F1 | 95 % interval | accuracy |", "|---|---|---|---|---|"]
    lines += [
        f"| {t.trained} | {t.tested} | {t.macro_f1:.2f} | {t.low:.2f} to {t.high:.2f} | {t.accuracy:.2f} |"
        for t in part.transfers
    ]
    lines += [
        "",
        "| magnitude, below 5 Hz, median r | zero lag | best lag | amplitude |",
        "|---|---|---|---|",
    ]
    for name, found in (
        ("specific force, plain differences of the joint", part.raw),
        ("specific force, through the body", part.fitted),
        ("angular velocity, through the body", part.rates),
    ):
        zero, best, _, size = np.median(np.array(found), axis=0)
        lines.append(f"| {name} | {zero:.2f} | {best:.2f} | {size:.2f} |")
    lines += ["", *_calibrated_lines(part)]
    ways = {(t.trained, t.tested): t.f1 for t in part.transfers}
    lines += ["", "| F1 by action | " + " | ".join(f"{a} to {b}" for a, b in ways) + " |"]
    lines += ["|---|" + "---|" * len(ways)]
    lines += [
        f"| {activity} | " + " | ".join(f"{f1[number]:.2f}" for f1 in ways.values()) + " |"
        for number, activity in enumerate(part.activities)
    ]
    return lines


def _calibrated_lines(part: PartOfUtd) -> list[str]:
    """Simulated to real, the sensor calibrated on the people who are not tested."""
    lines = [
        "| trained on simulated signals, tested on a person never seen | macro F1 | 95 % interval |",
        "|---|---|---|",
    ]
    lines += [f"| {t.trained} | {t.macro_f1:.2f} | {t.low:.2f} to {t.high:.2f} |" for t in part.steps]
    lines += ["", "| r over samples and axes, median | as simulated | calibrated |", "|---|---|---|"]
    for name, kind in (("specific force", "force"), ("angular velocity", "turning")):
        before, after = np.median([getattr(one, kind) for one in part.alike], axis=0)
        lines.append(f"| {name} | {before:.2f} | {after:.2f} |")
    return lines


def _content(part: PartOfUtd) -> dict[str, Any]:
    medians = {
        name: dict(
            zip(Correlation._fields, np.median(np.array(found), axis=0).round(4).tolist(), strict=True)
        )
        for name, found in (("raw", part.raw), ("fitted", part.fitted), ("rates", part.rates))
    }
    ways = {
        f"{t.trained} to {t.tested}": {
            "macro_f1": round(t.macro_f1, 4),
            "interval": [round(t.low, 4), round(t.high, 4)],
            "accuracy": round(t.accuracy, 4),
            "confusion": t.confusion.tolist(),
        }
        for t in part.transfers
    }
    steps = {
        t.trained: {"macro_f1": round(t.macro_f1, 4), "interval": [round(t.low, 4), round(t.high, 4)]}
        for t in part.steps
    }
    alike = {
        kind: np.median([getattr(one, kind) for one in part.alike], axis=0).round(4).tolist()
        for kind in Correlations._fields
    }
    return {
        "actions": list(part.activities),
        "transfer": ways,
        "calibrated": steps,
        "median_r_before_and_after": alike,
        "median_correlation": medians,
    }
