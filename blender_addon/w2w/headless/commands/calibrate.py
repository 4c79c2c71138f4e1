# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w calibrate`: fit a simulated sensor to one's own, worn with a matching motion."""

from pathlib import Path
from typing import Annotated

import numpy as np

from ...core.imu.calibration import Calibration, Correlations, calibrate as fit, held_out
from ...core.imu.presets import write_sensor
from ...core.imu.synthesis import FOLDED_BACK
from ...core.parameters import with_values
from ...core.study.config import StudyConfig
from ...core.wording import clean, count
from ..console import NOTHING_TO_DO, USAGE, Terminal, ending
from ..options import PoseOptions, argument, chosen_sensor, option, with_options
from ..runs.monitor import RunMonitor
from ..runs.own_files import new_file
from ..runs.own_sensor import Simulator, files_together, read_pairs
from ..study_options import DEFAULTS, declared


@with_options(PoseOptions)
def calibrate(
    real: Annotated[
        Path,
        argument(
            "REAL", "What the worn sensor recorded: csv, Xsens txt, x-io folder or npz; or a folder of such."
        ),
    ],
    motion: Annotated[
        Path,
        argument(
            "MOTION",
            "The motion of its wearer at that time (FBX, BVH, npz, joints from video); or a folder with "
            "a file of the same name for each in REAL.",
        ),
    ],
    patch: Annotated[str, option("Where it was worn: 'left wrist', 'sternum', a patch's name.")],
    out: Annotated[Path, option("JSON file to write, for --sensor.", "--out", "-o")],
    sensor: Annotated[str, declared("sensor")] = DEFAULTS.sensor,
    shift: Annotated[
        float, option("Most seconds that sensor and motion may be apart.", min=0.02, max=10)
    ] = 0.5,
    band: Annotated[float, declared("band")] = DEFAULTS.band,
    root_band: Annotated[float | None, declared("root_band")] = None,
    *,
    asked: PoseOptions,
) -> None:
    """Fit how a sensor sat, its soft tissue and its noise to a few minutes of your own recordings.

    The file it writes is a sensor for `run`, `synth`, `export` and all else that takes --sensor: --sensor's
    range, resolution and filters, with what was fitted. Its worth is measured on recordings that were left
    out of the fit.

    Exit codes: 0 written, 1 nothing could be used (and why), 2 wrong use.
    """
    console = Terminal()
    with ending(USAGE, console):
        base = chosen_sensor(sensor)
        if out.suffix.lower() != ".json":
            raise ValueError(f"--out must end in .json, as --sensor expects it, not {clean(out.name)}")
        new_file(out)
        files = files_together(real, motion)
        config = with_values(StudyConfig(sensor="ideal"), {"band": band or None, "root_band": root_band})
        simulate = Simulator(patch, config, asked.pose())
    with ending(NOTHING_TO_DO, console, "Not calibrated: "):
        with RunMonitor(console).step("reading and simulating"):
            pairs, left_out = read_pairs(files, simulate)
        for file, why in left_out:
            console.print(f"{file} is left out: {why}", style="yellow")
        with RunMonitor(console).step("fitting"):
            found = fit(pairs, shift)
            what, gains = held_out(pairs, shift)
        write_sensor(out, found.sensor(base, out.stem))
    if not band:
        console.print(f"Caution: {FOLDED_BACK}.", style="yellow")
    for line in [*found_lines(found, simulate.patch), *gain_lines(what, gains)]:
        console.print(line)
    console.print(f"Written: {clean(out)}. Give it to --sensor.")


def found_lines(found: Calibration, patch: str) -> list[str]:
    """Sentences about what was fitted."""
    tissue = "Soft tissue: none that helps."
    if found.tissue is not None:
        hertz, damping, share = found.tissue
        tissue = f"Soft tissue: {hertz:.1f} Hz, damping {damping:g}, {100 * share:.0f} % of the motion."
    shifts = np.array(found.shifts_s)
    apart = f"{shifts.min():+.2f} to {shifts.max():+.2f} s" if len(shifts) > 1 else f"{shifts[0]:+.2f} s"
    return [
        f"{count('recording', len(shifts))} against the {patch}; the sensor later by {apart}.",
        f"The sensor sat turned by {np.degrees(found.turn.magnitude()):.0f} degrees from the patch's axes.",
        tissue,
        f"Noise: {1e6 * found.acc_noise / 9.80665:.0f} ug/sqrt(Hz), "
        f"{1e3 * np.degrees(found.gyr_noise):.1f} mdps/sqrt(Hz), at most.",
    ]


def gain_lines(what: str, gains: list[Correlations]) -> list[str]:
    """Sentences about the correlation of simulated and worn signals before and after."""
    lines = []
    for name, kind in (("specific force", "force"), ("angular velocity", "turning")):
        before, after = np.median([getattr(gain, kind) for gain in gains], axis=0)
        r = f"{before:.2f} as simulated, {after:.2f} calibrated"
        lines.append(f"r of {name}, each {what} left out of the fit: {r}.")
    return lines
