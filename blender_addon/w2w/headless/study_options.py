# SPDX-License-Identifier: GPL-3.0-or-later
"""The options of every command that runs a study, defined once: `run` and `study mixamo` have them all."""

import functools
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, make_dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

import typer
from rich.console import Console

from ..core.parameters import Parameter, parameters_of, with_values
from ..core.patches.own_placements import read_placements
from ..core.ranking.utility import inputs_of, unavailable
from ..core.ranking.weights import read_weights
from ..core.reading.guard import LIMIT_S, MEMORY
from ..core.retargeting.bone_maps import BoneMap
from ..core.selection.constraints import read_costs
from ..core.study.config import FILES, RANKING, StudyConfig
from . import options
from .options import option
from .runs.clip_task import Engine
from .runs.covers import parse_garments
from .runs.monitor import EventLog, RunMonitor, event_line
from .stopping import STOPPED, say_for_machines

RUN = "How the run is done"
run_option = functools.partial(option, rich_help_panel=RUN)

NAMES = {"max_places": "--max", "costs": "--cost"}
"""Options with another name than their parameter."""

READ_TOGETHER = "rate", "band", "convention", "record", "recognise_by", "magnetic_dip", "window", "sensor"
"""Options that are read with others, or with words of their own."""

READERS: dict[str, Callable[[Any], tuple[Any, ...]]] = {
    "placements": lambda path: tuple(read_placements(path).items()),
    "garment": parse_garments,
    "weights": read_weights,
    "costs": read_costs,
}
"""Readers of the options that are lists, where it is not one of words."""


def declared(name: str, **other: Any) -> Any:
    """The option for a parameter that `StudyConfig` or a record in it declares.

    `other` arguments of `typer.Option` replace declared ones.
    """
    parameter = parameters_of(StudyConfig)[name]
    about: dict[str, Any] = {"help": parameter.help, "min": parameter.least, "max": parameter.most}
    about |= {"rich_help_panel": parameter.group or None} | other
    names = (NAMES[name],) if name in NAMES else ()
    return typer.Option(*names, **about)


def _default(parameter: Parameter) -> Any:
    """An option's default: "" for a list, None for a table."""
    if parameter.default == ():
        return "" if option_kind(parameter) is str else None
    return parameter.default


def option_kind(parameter: Parameter) -> Any:
    """The type of an option: words for a list, a file for a table, 0 for no limit."""
    if parameter.is_list:
        return str if get_args(parameter.kind)[0] is str else Path | None
    if get_origin(parameter.kind) is Literal:
        return str
    if parameter.is_optional and parameter.default is not None:
        return parameter.kinds[0]
    return parameter.kind


def values_of(given: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters' values from their options; a ValueError or OSError says which cannot be read."""
    return {name: _value(OPTIONS[name], value) for name, value in given.items()}


def _value(parameter: Parameter, given: Any) -> Any:
    if parameter.is_list:
        return READERS.get(parameter.name, options.words)(given) if given else ()
    return given.strip() if isinstance(given, str) else given


OPTIONS = {name: each for name, each in parameters_of(StudyConfig).items() if each.group is not None}
"""The parameters that have an option: those that are not the panel's alone."""

DeclaredOptions: Any = make_dataclass(
    "DeclaredOptions",
    [
        (name, Annotated[option_kind(parameter), declared(name)], field(default=_default(parameter)))
        for name, parameter in OPTIONS.items()
    ],
    frozen=True,
)
"""An option for each of them."""

DEFAULTS = DeclaredOptions()
"""The default of each."""


@dataclass(frozen=True)
class StudyOptions(options.PoseOptions, DeclaredOptions):
    """The options of a study: its parameters, and how it is run."""

    bodies: Annotated[
        str,
        option(
            "One or more bodies, comma-separated: neutral, female, male, with height=1.6 (m) "
            "weight=55 (kg) muscle= age= arms= legs=, or an SMPL file (a model, optionally with "
            "betas=1.2:0:-0.5 or betas=MOTION.npz). Each body gets its own study, compared at the end."
        ),
    ] = "neutral"
    workers: Annotated[int, option("Clips processed in parallel.", min=1)] = options.CORES
    stride: Annotated[
        float | None,
        option(
            "Stride of the training windows, seconds.  [default: half the window]",
            min=0.05,
            show_default=False,
            rich_help_panel=RANKING,
        ),
    ] = None
    bone_map: Annotated[
        list[Path] | None,
        option(
            "Bone map for your own rig (JSON, as in assets/templates/bone_maps); repeatable.",
            rich_help_panel=FILES,
        ),
    ] = None
    exact_labels: Annotated[
        bool,
        option("Keep activities apart that differ only in case, spaces, '_' or '-'.", rich_help_panel=FILES),
    ] = False
    pictures: Annotated[bool, run_option("Render heatmaps and save study.blend.")] = True
    report: Annotated[bool, run_option("Write report.html.")] = True
    clip_limit: Annotated[float, run_option("Time limit per clip, seconds.", min=1)] = LIMIT_S
    clip_memory: Annotated[float, run_option("Memory limit per clip, GiB.", min=0.5)] = MEMORY / 2**30
    scheduler: Annotated[
        str, run_option("Dask scheduler (tcp://host:port or a scheduler file) to run on a cluster.")
    ] = ""
    signals: Annotated[
        bool,
        run_option(
            "Keep the signals, MBs a clip; else exports, panel and w2w.stream make them again from motions.",
            "--signals/--no-signals",
        ),
    ] = True
    verify: Annotated[
        bool, run_option("Read what an earlier run left again, not only its sizes and times.", "--verify")
    ] = False
    strict: Annotated[bool, run_option("Fail (exit code 3) if any clip is skipped.")] = False
    verbose: Annotated[bool, run_option("List every clip, activity and region.", "--verbose")] = False
    log_json: Annotated[
        bool, run_option("Print machine-readable events instead: one JSON object per line.", "--log-json")
    ] = False

    def config(self) -> StudyConfig:
        """The study's parameters; a ValueError or OSError says which option is wrong."""
        alone = {name: getattr(self, name) for name in OPTIONS if name not in READ_TOGETHER}
        together = StudyConfig(
            synthesis=options.synthesis_settings(self.rate, self.band, self.convention),
            further=options.further_sensors(self.record, self.recognise_by, self.magnetic_dip),
            **options.sensor_settings(self.sensor),
            windows=options.window_spec(self.window, self.stride),
        )
        config = with_values(together, values_of(alone))
        if problem := unavailable(config.classifier):
            raise ValueError(problem)
        return config

    def engine(self) -> Engine:
        """The engine for the clips; a ValueError or OSError if a bone map or a pose option is wrong."""
        pose, memory = self.pose(), round(self.clip_memory * 2**30)
        bone_maps = tuple(BoneMap.load(path) for path in self.bone_map or ())
        if not self.signals and (self.garment or inputs_of(self.classifier) != "features"):
            why = "garments" if self.garment else f"the classifier {self.classifier}"
            raise ValueError(f"--no-signals: {why} cannot do without them")
        as_given = {name: getattr(self, name) for name in ("workers", "scheduler", "verify", "signals")}
        return Engine(**as_given, limit_s=self.clip_limit, bone_maps=bone_maps, memory=memory, pose=pose)

    def monitor(self, console: Console) -> RunMonitor:
        """The monitor for people, or for machines with --log-json."""
        if not self.log_json:
            return RunMonitor(console)
        console.quiet = True
        say_for_machines(lambda code: event_line("finished", exit_code=code, problem=STOPPED))
        return RunMonitor(console, EventLog(sys.stdout))
