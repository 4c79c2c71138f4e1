# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of every command that runs a study, defined once: `run` and `study mixamo` have them all."""

from __future__ import annotations

import functools
import inspect
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer
from rich.console import Console

from w2w.core.body.body import Body
from w2w.core.imu.augmentation import SWITCHES, parse_augmentation
from w2w.core.imu.further import NOTHING
from w2w.core.imu.presets import DEFAULT_SENSOR
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.patches.own_placements import read_placements
from w2w.core.ranking.utility import unavailable
from w2w.core.ranking.weights import read_weights
from w2w.core.study import StudyConfig

from . import options, pose_options, signal_options, window_options
from .runs.garments import parse_garments
from .runs.guard import LIMIT_S, MEMORY
from .runs.monitor import EventLog, RunMonitor, event_line
from .runs.workers import Engine
from .stopping import STOPPED, say_for_machines


@dataclass(frozen=True)
class StudyOptions:
    """What is asked of a study, as the command line gives it."""

    exact_labels: Annotated[
        bool,
        typer.Option(help="Keep labels apart that differ only in case, spaces or underscores."),
    ] = False
    bodies: Annotated[
        str,
        typer.Option(
            help="One or more bodies, comma-separated: neutral, female, male, with height=1.6 (m) "
            "weight=55 (kg) muscle= age= arms= legs=, or an SMPL file (a model, optionally with "
            "betas=1.2:0:-0.5 or betas=MOTION.npz). Each body gets its own study, compared at the end."
        ),
    ] = "neutral"
    patches: Annotated[int, typer.Option(min=2, max=6890, help="Number of patches on the body.")] = 512
    placements: Annotated[
        Path | None,
        typer.Option(
            help="Spots of your own beside them: csv with columns name, vertex, or name, x, y, z (metres "
            "on the body at rest, z up, soles at z = 0)."
        ),
    ] = None
    garment: Annotated[
        str,
        typer.Option(
            help="What is worn: tshirt, trousers, or FILE.blend:OBJECT, one of yours that follows W2W's body "
            "there; several comma-separated, the outer first. Patches that it covers are then on the "
            "cloth, which Blender simulates: minutes a clip."
        ),
    ] = ""
    rate: signal_options.Rate = 50.0
    sensor: signal_options.Sensor = DEFAULT_SENSOR
    band: signal_options.Band = signal_options.AS_DEFAULT.cutoff_hz
    root_band: signal_options.RootBand = None
    convention: signal_options.Convention = signal_options.AS_DEFAULT.convention
    record: signal_options.Record = ""
    recognise_by: signal_options.RecogniseBy = ""
    magnetic_dip: signal_options.MagneticDip = NOTHING.dip_deg
    window: window_options.Window = 2.0
    stride: window_options.Stride = None
    classifier: options.Classifier = "ridge"
    target: Annotated[float, typer.Option(min=0.01, max=1, help="F1 the set of sensors should reach.")] = 0.90
    every_activity: options.EveryActivity = 0.0
    background: options.Background = ""
    weights: options.Weights = None
    only: options.Only = ""
    forbid: options.Forbid = ""
    must: options.Must = ""
    max_places: options.MaxPlaces = None
    costs: options.Costs = None
    augment: Annotated[
        str,
        typer.Option(
            help=f"Train on altered copies of every clip (never test on them): {', '.join(SWITCHES)}, "
            "comma-separated, or all; mirror exchanges left and right, except where an activity names a side."
        ),
    ] = ""
    copies: Annotated[int, typer.Option(min=1, help="Copies per clip, with --augment.")] = 4
    folds: Annotated[
        int, typer.Option(min=2, help="Cross-validation folds; a clip is never split between them.")
    ] = 5
    by_subject: Annotated[
        bool, typer.Option(help="Leave-one-subject-out cross-validation instead of folds.")
    ] = False
    seed: Annotated[int, typer.Option(min=0, help="Random seed.")] = 0
    workers: Annotated[int, typer.Option(min=1, help="Clips processed in parallel.")] = os.cpu_count() or 1
    pictures: Annotated[bool, typer.Option(help="Render heatmaps and save study.blend.")] = True
    report: Annotated[bool, typer.Option(help="Write report.html.")] = True
    title: Annotated[str, typer.Option(help="Project name for the report.")] = ""
    bone_map: Annotated[
        list[Path] | None,
        typer.Option(help="Bone map for your own rig (JSON, as in assets/templates/bone_maps); repeatable."),
    ] = None
    pose_rate: pose_options.PoseRate = None
    pose_unit: pose_options.PoseUnit = ""
    pose_up: pose_options.PoseUp = ""
    pose_joints: pose_options.PoseJoints = ""
    clip_limit: Annotated[float, typer.Option(min=1, help="Time limit per clip, seconds.")] = LIMIT_S
    clip_memory: Annotated[float, typer.Option(min=0.5, help="Memory limit per clip, GiB.")] = MEMORY / 2**30
    scheduler: Annotated[
        str, typer.Option(help="Dask scheduler (tcp://host:port or a scheduler file) to run on a cluster.")
    ] = ""
    strict: Annotated[bool, typer.Option(help="Fail (exit code 3) if any clip is skipped.")] = False
    log_json: Annotated[
        bool,
        typer.Option("--log-json", help="Print machine-readable events instead: one JSON object per line."),
    ] = False

    def config(self) -> StudyConfig:
        """The study's parameters.

        Raises
        ------
        ValueError, OSError
            If an option is wrong, or a file it names cannot be read; the message says which.
        """
        config = StudyConfig(
            patches=self.patches,
            placements=tuple(read_placements(self.placements).items()) if self.placements else (),
            garments=parse_garments(self.garment),
            synthesis=signal_options.synthesis_settings(self.rate, self.band, self.convention),
            root_band_hz=self.root_band,
            further=signal_options.further_sensors(self.record, self.recognise_by, self.magnetic_dip),
            **signal_options.sensor_settings(self.sensor),
            windows=window_options.window_spec(self.window, self.stride),
            classifier=self.classifier,
            augmentation=parse_augmentation(self.augment, self.copies),
            folds=self.folds,
            by_subject=self.by_subject,
            target=self.target,
            every_activity=self.every_activity,
            background=options.words(self.background),
            weights=read_weights(self.weights) if self.weights else (),
            max_places=self.max_places,
            constraints=options.parse_wishes(self.only, self.forbid, self.must, self.costs),
            seed=self.seed,
            title=self.title.strip(),
        )
        if problem := unavailable(config.classifier):
            raise ValueError(problem)
        return config

    def chosen_bodies(self) -> list[tuple[str, Body]]:
        """The bodies asked for, each with a name.

        Raises
        ------
        ValueError
            If a description is not understood.
        """
        return options.parse_bodies(self.bodies)

    def engine(self) -> Engine:
        """Who does the clips, and how they are read.

        Raises
        ------
        ValueError, OSError
            If a bone map or a fact of joint positions is wrong.
        """
        pose = pose_options.pose_facts(self.pose_rate, self.pose_unit, self.pose_up, self.pose_joints)
        bone_maps = tuple(BoneMap.load(path) for path in self.bone_map or ())
        memory = round(self.clip_memory * 2**30)
        return Engine(self.workers, self.scheduler, self.clip_limit, bone_maps, memory, pose)

    def monitor(self, console: Console) -> RunMonitor:
        """Tells people, or machines with --log-json, how far the run has come."""
        if not self.log_json:
            return RunMonitor(console)
        console.quiet = True
        say_for_machines(lambda code: event_line("finished", exit_code=code, problem=STOPPED))
        return RunMonitor(console, EventLog(sys.stdout))


def with_study_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command every option of `StudyOptions` beside its own; it gets them as its argument `asked`."""
    own = inspect.signature(command)
    hints = get_type_hints(command, include_extras=True)
    shared_hints = get_type_hints(StudyOptions, include_extras=True)
    parameters = [
        parameter.replace(annotation=hints[name], kind=inspect.Parameter.KEYWORD_ONLY)
        for name, parameter in own.parameters.items()
        if name != "asked"
    ]
    shared = [
        inspect.Parameter(
            item.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=item.default,
            annotation=shared_hints[item.name],
        )
        for item in fields(StudyOptions)
    ]

    @functools.wraps(command)
    def wrapped(**given: Any) -> None:
        asked = StudyOptions(**{item.name: given.pop(item.name) for item in shared})
        command(**given, asked=asked)

    del wrapped.__wrapped__  # its signature is another
    wrapped.__signature__ = own.replace(parameters=[*parameters, *shared])
    wrapped.__annotations__ = {parameter.name: parameter.annotation for parameter in (*parameters, *shared)}
    return wrapped
