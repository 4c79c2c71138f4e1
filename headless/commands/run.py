# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w run`: a folder of motion files in, heatmaps and a sensor recommendation out."""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from w2w.core.imu.augmentation import SWITCHES, parse_augmentation
from w2w.core.imu.presets import DEFAULT_SENSOR
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.labels import same_label
from w2w.core.motion.library import Library, read_library
from w2w.core.ranking.utility import unavailable
from w2w.core.study import StudyConfig

from ..console import SKIPPED, USAGE
from ..options import Costs, EveryActivity, Forbid, MaxPlaces, Must, Only, parse_bodies, parse_wishes
from ..pose_options import PoseJoints, PoseRate, PoseUnit, PoseUp, pose_facts
from ..reports.comparison import keep_foreign_comparison, write_comparison
from ..reports.console_tables import show_comparison, show_labels
from ..runs.guard import LIMIT_S, MEMORY
from ..runs.monitor import SILENT, EventLog, RunMonitor, event_line
from ..runs.own_files import ForeignFileError, keep_apart
from ..runs.study import RunPlan
from ..runs.workers import Engine
from ..signal_options import (
    AS_DEFAULT,
    Band,
    Convention,
    Rate,
    RootBand,
    Sensor,
    sensor_settings,
    synthesis_settings,
)
from ..stopping import STOPPED, say_for_machines
from ..window_options import Stride, Window, window_spec
from .execute import ended, execute


def run(
    library: Annotated[
        Path,
        typer.Argument(
            metavar="LIBRARY",
            help="Folder of motion files (FBX, BVH, AMC, npz; csv, npy or json of joints), searched with "
            "its subfolders.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the results; made if missing.")],
    labels: Annotated[
        Path | None,
        typer.Option(
            help="csv with columns file, activity[, subject].  [default: labels from folder or file names]",
            show_default=False,
        ),
    ] = None,
    exact_labels: Annotated[
        bool,
        typer.Option(help="Keep labels apart that differ only in case, spaces or underscores."),
    ] = False,
    bodies: Annotated[
        str,
        typer.Option(
            help="One or more bodies, comma-separated: neutral, female, male, with height=1.6 (m) "
            "weight=55 (kg) muscle= age= arms= legs=, or an SMPL file (a model, optionally with "
            "betas=1.2:0:-0.5 or betas=MOTION.npz). Each body gets its own study, compared at the end."
        ),
    ] = "neutral",
    patches: Annotated[int, typer.Option(min=2, max=6890, help="Number of places on the body.")] = 512,
    rate: Rate = 50.0,
    sensor: Sensor = DEFAULT_SENSOR,
    band: Band = AS_DEFAULT.cutoff_hz,
    root_band: RootBand = None,
    convention: Convention = AS_DEFAULT.convention,
    window: Window = 2.0,
    stride: Stride = None,
    classifier: Annotated[
        str,
        typer.Option(
            help="Classifier for each place: ridge (seconds), trees (minutes), multi3net (needs PyTorch)."
        ),
    ] = "ridge",
    target: Annotated[
        float, typer.Option(min=0.01, max=1, help="F1 the set of sensors should reach.")
    ] = 0.90,
    every_activity: EveryActivity = 0.0,
    only: Only = "",
    forbid: Forbid = "",
    must: Must = "",
    max_places: MaxPlaces = None,
    costs: Costs = None,
    leave_out: Annotated[
        str, typer.Option(help="Activities to leave out, comma-separated, e.g. 'other,unknown'.")
    ] = "",
    augment: Annotated[
        str,
        typer.Option(
            help=f"Train on altered copies of every clip (never test on them): {', '.join(SWITCHES)}, "
            "comma-separated, or all."
        ),
    ] = "",
    copies: Annotated[int, typer.Option(min=1, help="Copies per clip, with --augment.")] = 4,
    folds: Annotated[
        int, typer.Option(min=2, help="Cross-validation folds; a clip is never split between them.")
    ] = 5,
    by_subject: Annotated[
        bool, typer.Option(help="Leave-one-subject-out cross-validation instead of folds.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Random seed.")] = 0,
    workers: Annotated[int, typer.Option(min=1, help="Clips processed in parallel.")] = os.cpu_count() or 1,
    pictures: Annotated[bool, typer.Option(help="Render heatmaps and save study.blend.")] = True,
    report: Annotated[bool, typer.Option(help="Write report.html.")] = True,
    title: Annotated[str, typer.Option(help="Project name for the report.")] = "",
    bone_map: Annotated[
        list[Path] | None,
        typer.Option(help="Bone map for your own rig (JSON, as in assets/templates/bone_maps); repeatable."),
    ] = None,
    pose_rate: PoseRate = None,
    pose_unit: PoseUnit = "",
    pose_up: PoseUp = "",
    pose_joints: PoseJoints = "",
    clip_limit: Annotated[float, typer.Option(min=1, help="Time limit per clip, seconds.")] = LIMIT_S,
    clip_memory: Annotated[float, typer.Option(min=0.5, help="Memory limit per clip, GiB.")] = MEMORY / 2**30,
    scheduler: Annotated[
        str, typer.Option(help="Dask scheduler (tcp://host:port or a scheduler file) to run on a cluster.")
    ] = "",
    strict: Annotated[bool, typer.Option(help="Fail (exit code 3) if any clip is skipped.")] = False,
    log_json: Annotated[
        bool,
        typer.Option("--log-json", help="Print machine-readable events instead: one JSON object per line."),
    ] = False,
) -> None:
    """Find the best places for a sensor from a folder of motion files.

    OUT then holds `report.html`, `summary.json`, `utility.csv`, `heatmaps/*.png`, `study.blend`,
    `motions/*.npz`, `signals/*.npz` and `config.json`. Run the same command again to resume a run that
    was stopped.

    Exit codes: 0 success, 1 no result (the message says why), 2 wrong arguments, 3 clips were skipped
    and --strict was given, 4 another run is using OUT; 130, 143 and 129 stopped by Ctrl-C,
    SIGTERM and SIGHUP.
    """
    console = Console(highlight=False, quiet=log_json)
    monitor = RunMonitor(console, EventLog(sys.stdout) if log_json else SILENT)
    if log_json:
        say_for_machines(lambda code: event_line("finished", exit_code=code, problem=STOPPED))
    try:
        config = StudyConfig(
            patches=patches,
            synthesis=synthesis_settings(rate, band, convention),
            root_band_hz=root_band,
            **sensor_settings(sensor),
            windows=window_spec(window, stride),
            classifier=classifier,
            augmentation=parse_augmentation(augment, copies),
            folds=folds,
            by_subject=by_subject,
            target=target,
            every_activity=every_activity,
            max_places=max_places,
            constraints=parse_wishes(only, forbid, must, costs),
            seed=seed,
            title=title.strip(),
        )
        if problem := unavailable(config.classifier):
            raise ValueError(problem)
        keep_apart(library, out)
        found = without(read_library(library, labels, exact_labels), leave_out)
        chosen = parse_bodies(bodies)
        if len(chosen) > 1:
            keep_foreign_comparison(out)
        pose = pose_facts(pose_rate, pose_unit, pose_up, pose_joints)
        bone_maps = tuple(BoneMap.load(path) for path in bone_map or ())
    except (ValueError, OSError, ForeignFileError) as error:
        raise ended(str(error), USAGE, monitor) from error
    engine = Engine(workers, scheduler, clip_limit, bone_maps, round(clip_memory * 2**30), pose)
    plan = RunPlan(found, config, engine, pictures, report)
    show_labels(found, console)
    studies = []
    for name, body in chosen:
        folder = out if len(chosen) == 1 else out / name
        studies.append((name, execute(plan, body, folder, monitor)))
    if len(chosen) > 1:
        show_comparison(write_comparison(studies, out), console)
    if strict and any(len(study.used) < len(study.clips) + len(found.skipped) for _, study in studies):
        raise ended("Clips were skipped, and --strict was given.", SKIPPED, monitor)
    monitor.log("finished", exit_code=0)


def without(library: Library, activities: str) -> Library:
    """The library less some activities, given by commas.

    Raises
    ------
    ValueError
        If no clip shows one of them, or none is left.
    """
    given = {same_label(name): name.strip() for name in activities.split(",") if name.strip()}
    names = {name for name in library.activities if same_label(name) in given}
    unknown = set(given) - {same_label(name) for name in names}
    if unknown:
        raise ValueError(
            f"--leave-out: no clip is labelled {', '.join(sorted(given[key] for key in unknown))}"
        )
    kept = tuple(clip for clip in library.clips if clip.activity not in names)
    if not kept:
        raise ValueError("--leave-out leaves no clip")
    dropped = [
        (clip.file, f"{clip.activity} is left out (--leave-out)")
        for clip in library.clips
        if clip.activity in names
    ]
    return replace(library, clips=kept, skipped=(*library.skipped, *dropped))
