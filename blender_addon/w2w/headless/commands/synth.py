# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w synth`: what one sensor at one spot would record of one clip, as a table and a picture."""

from pathlib import Path
from typing import Annotated

from ...core.body.body import Body
from ...core.imu.formats import FORMATS, HELD, write_csv, write_recording
from ...core.imu.virtual import FurtherSensors, sensor_at
from ...core.library.library import Clip
from ...core.study.config import StudyConfig
from ...core.study.signals import place_patches, simulate as record_at
from ...core.wording import clean
from .. import options
from ..console import NOTHING_TO_DO, USAGE, Terminal, ending
from ..options import PoseOptions, argument, option, with_options
from ..runs.clip_task import Engine
from ..runs.own_files import new_file
from ..runs.workers import load_alone
from ..study_options import DEFAULTS, declared


@with_options(PoseOptions)
def synth(
    clip: Annotated[Path, argument("CLIP", "A motion file: FBX, BVH, AMC, npz, or joints.")],
    patch: Annotated[str, option("Where it sits: 'left wrist', 'sternum', 'pocket', a patch's name.")],
    out: Annotated[Path, option("File to write (x-io: a folder).", "--out", "-o")],
    kind: Annotated[
        str, option(f"{', '.join(FORMATS)}; the last two have units of their own.", "--format")
    ] = "csv",
    plot: Annotated[Path | None, option("png file to draw the signal to.")] = None,
    sensor: Annotated[str, declared("sensor")] = DEFAULTS.sensor,
    rate: Annotated[float, declared("rate")] = DEFAULTS.rate,
    band: Annotated[float, declared("band")] = DEFAULTS.band,
    root_band: Annotated[float | None, declared("root_band")] = None,
    convention: Annotated[str, declared("convention")] = DEFAULTS.convention,
    record: Annotated[str, declared("record")] = "",
    magnetic_dip: Annotated[float, declared("magnetic_dip")] = DEFAULTS.magnetic_dip,
    acc_unit: Annotated[str, option("m/s2 or g.")] = "m/s2",
    gyr_unit: Annotated[str, option("rad/s or deg/s.")] = "rad/s",
    seed: Annotated[int, declared("seed", help="Seed of the sensor's errors.")] = 0,
    *,
    asked: PoseOptions,
) -> None:
    """Write what one sensor would record of one clip: specific force and angular velocity, sensor frame.

    With --record also orientation, magnetometer and barometer.

    Exit codes: 0 written, 1 the clip cannot be used (and why), 2 wrong use.
    """
    console = Terminal()
    with ending(USAGE, console):
        if kind not in FORMATS:
            raise ValueError(f"--format must be one of {', '.join(FORMATS)}, not {kind}")
        new_file(out, plot)
        config = StudyConfig(
            **options.sensor_settings(sensor),
            synthesis=options.synthesis_settings(rate, band, convention),
            root_band_hz=root_band,
            further=_recorded_too(record, magnetic_dip, kind),
            seed=seed,
        )
        pose, body = asked.pose(), Body.bundled()
        patches = sensor_at(body, patch, lambda body: place_patches(body, config))
    name = clean(clip.name)
    with ending(NOTHING_TO_DO, console, f"No signal of {name}: "):
        _, motion, _ = load_alone(Clip(clip, name, clean(clip.stem), ""), body, Engine(pose=pose))
        recording = record_at(body, patches, motion, config)
        if kind == "csv":
            write_csv(out, recording, acc_unit=acc_unit, gyr_unit=gyr_unit)
        else:
            write_recording(out, recording, kind)
    worn_at = patches.names[0]
    signal = f"{recording.n_samples} samples at {recording.rate:g} Hz of {config.sensor} at the {worn_at}"
    console.print(f"{signal}: {clean(out)}")
    if caution := config.synthesis.caution:
        console.print(f"Caution: {caution}.", style="yellow")
    if plot is not None:
        from ...drawing.signal_figure import signal_figure  # matplotlib is slow to import

        subtitle = f"{config.sensor}, {recording.rate:g} Hz"
        signal_figure(plot, recording, title=f"{clean(clip.stem)}: {worn_at}", subtitle=subtitle)
        console.print(f"Picture: {clean(plot)}")


def _recorded_too(record: str, magnetic_dip: float, kind: str) -> FurtherSensors:
    """The sensors besides acc and gyr; a ValueError if files of this kind cannot hold it."""
    further = options.further_sensors(record, "", magnetic_dip)
    if lacking := [name for name in further.record if name not in HELD[kind]]:
        able = [name for name, held in HELD.items() if set(further.record) <= set(held)]
        raise ValueError(
            f"--record: a file of --format {kind} does not hold {', '.join(lacking)}; {' and '.join(able)} do"
        )
    return further
