# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run`: a folder of motion files in, heatmaps and a sensor recommendation out."""

from __future__ import annotations

if __name__ == "__main__":  # blender --background --python headless/run.py -- LIBRARY --out OUT
    import sys
    from pathlib import Path

    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
    from headless.from_blender import run_command

    run_command("run")

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from blender_addon.w2w.core.augmentation import SWITCHES, parse_augmentation
from blender_addon.w2w.core.bone_maps import BoneMap
from blender_addon.w2w.core.imu import Synthesis
from blender_addon.w2w.core.library import Library, read_library
from blender_addon.w2w.core.sensor_presets import DEFAULT_SENSOR
from blender_addon.w2w.core.study import StudyConfig
from blender_addon.w2w.core.utility import unavailable
from blender_addon.w2w.core.windows import WindowSpec

from .bodies import parse_bodies, write_comparison
from .engine import Engine
from .event_log import SILENT, EventLog
from .execute import ended, execute
from .exit_codes import SKIPPED, USAGE
from .run_tables import show_comparison, show_labels
from .wishes import Costs, Forbid, MaxPlaces, Must, Only, parse_wishes
from .worker_guard import LIMIT_S, MEMORY


def run(
    library: Annotated[
        Path,
        typer.Argument(
            metavar="LIBRARY", help="Folder of motion files (FBX, BVH, npz), with its subfolders."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; made if missing.")],
    labels: Annotated[
        Path | None,
        typer.Option(
            help="csv with columns file, activity[, subject]. Else folder names, else file names label."
        ),
    ] = None,
    bodies: Annotated[
        str,
        typer.Option(
            help="Body or bodies, by commas: neutral, female, male, with height=1.6 (m) weight=55 (kg) "
            "muscle= age= arms= legs=, or an SMPL file (a model, if you like with betas=1.2:0:-0.5 or "
            "betas=MOTION.npz). Several give a study each, and how far they agree."
        ),
    ] = "neutral",
    patches: Annotated[int, typer.Option(min=2, max=6890, help="Places on the body.")] = 512,
    rate: Annotated[float, typer.Option(min=5, max=1000, help="Sensor rate, Hz.")] = 50.0,
    sensor: Annotated[str, typer.Option(help="Sensor preset, or 'ideal' for no errors.")] = DEFAULT_SENSOR,
    window: Annotated[float, typer.Option(min=0.1, help="Window length, seconds.")] = 2.0,
    stride: Annotated[float, typer.Option(min=0.05, help="Stride of training windows, seconds.")] = 1.0,
    classifier: Annotated[
        str,
        typer.Option(
            help="What learns at each place: ridge (seconds), trees (minutes), multi3net (PyTorch)."
        ),
    ] = "ridge",
    target: Annotated[
        float, typer.Option(min=0.01, max=1, help="F1 that the set of sensors shall reach.")
    ] = 0.90,
    only: Only = "",
    forbid: Forbid = "",
    must: Must = "",
    max_places: MaxPlaces = None,
    costs: Costs = None,
    leave_out: Annotated[
        str, typer.Option(help="Activities to leave out, by commas, such as 'other,unknown'.")
    ] = "",
    augment: Annotated[
        str,
        typer.Option(
            help=f"Copies of every clip to train on, never to test: {', '.join(SWITCHES)}, by commas, or all."
        ),
    ] = "",
    copies: Annotated[int, typer.Option(min=1, help="Copies a clip, with --augment.")] = 4,
    folds: Annotated[
        int, typer.Option(min=2, help="Folds of the cross-validation; clips never straddle one.")
    ] = 5,
    by_subject: Annotated[
        bool, typer.Option(help="Leave one subject out at a time instead of folds.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Seed of every random draw.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Clips worked on at the same time.")] = os.cpu_count()
    or 1,
    pictures: Annotated[bool, typer.Option(help="Draw heatmaps and save study.blend.")] = True,
    report: Annotated[bool, typer.Option(help="Write report.html, a page with everything in it.")] = True,
    bone_map: Annotated[
        list[Path] | None,
        typer.Option(
            help="Bone map of your own rig (JSON, as in assets/templates/bone_maps); may be repeated."
        ),
    ] = None,
    clip_limit: Annotated[
        float, typer.Option(min=1, help="Seconds after which a clip is given up.")
    ] = LIMIT_S,
    clip_memory: Annotated[
        float, typer.Option(min=0.5, help="Memory a worker may take for a clip, GiB.")
    ] = MEMORY / 2**30,
    scheduler: Annotated[
        str, typer.Option(help="Dask scheduler (tcp://host:port or a scheduler file) to work on a cluster.")
    ] = "",
    strict: Annotated[bool, typer.Option(help="Fail (exit code 3) if any clip is skipped.")] = False,
    log_json: Annotated[
        bool, typer.Option("--log-json", help="Print events for machines instead: one JSON object a line.")
    ] = False,
) -> None:
    """Find the best places for a sensor from a folder of motion files.

    OUT then holds `report.html`, `summary.json`, `utility.csv`, `heatmaps/*.png`, `study.blend`,
    `motions/*.npz`, `signals/*.npz` and `config.json`. Run again with the same OUT to go on where a run
    was stopped.

    Exit codes: 0 all well, 1 no result (what is wrong is said), 2 wrong use, 3 clips were skipped with
    --strict, 4 another run works in OUT, 130 stopped by Ctrl-C.
    """
    console = Console(highlight=False, quiet=log_json)
    log = EventLog(sys.stdout) if log_json else SILENT
    try:
        config = StudyConfig(
            patches=patches,
            synthesis=Synthesis(rate_hz=rate),
            sensor=sensor,
            windows=WindowSpec(length_s=window, stride_s=stride),
            classifier=classifier,
            augmentation=parse_augmentation(augment, copies),
            folds=folds,
            by_subject=by_subject,
            target=target,
            max_places=max_places,
            constraints=parse_wishes(only, forbid, must, costs),
            seed=seed,
        )
        if problem := unavailable(config.classifier):
            raise ValueError(problem)
        found = without(read_library(library, labels), leave_out)
        chosen = parse_bodies(bodies)
        bone_maps = tuple(BoneMap.load(path) for path in bone_map or ())
    except (ValueError, OSError) as error:
        raise ended(str(error), USAGE, console, log) from error
    engine = Engine(workers, scheduler, clip_limit, bone_maps, round(clip_memory * 2**30))
    show_labels(found, console)
    studies = []
    for name, body in chosen:
        folder = out if len(chosen) == 1 else out / name
        studies.append((name, execute(found, body, config, folder, engine, pictures, console, report, log)))
    if len(chosen) > 1:
        show_comparison(write_comparison(studies, out), console)
    if strict and any(len(study.used) < len(study.outcomes) + len(found.skipped) for _, study in studies):
        raise ended("Clips were skipped and --strict was asked for.", SKIPPED, console, log)
    log("finished", exit_code=0)


def without(library: Library, activities: str) -> Library:
    """The library less some activities, given by commas.

    Raises
    ------
    ValueError
        If no clip shows one of them, or none is left.
    """
    names = {name.strip() for name in activities.split(",") if name.strip()}
    unknown = names - set(library.activities)
    if unknown:
        raise ValueError(f"--leave-out: no clip is labelled {', '.join(sorted(unknown))}")
    kept = tuple(clip for clip in library.clips if clip.activity not in names)
    if not kept:
        raise ValueError("--leave-out leaves no clip")
    dropped = [
        (clip.file, f"{clip.activity} is left out (--leave-out)")
        for clip in library.clips
        if clip.activity in names
    ]
    return replace(library, clips=kept, skipped=(*library.skipped, *dropped))
