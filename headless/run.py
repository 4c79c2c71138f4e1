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
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from blender_addon.w2w.core.augmentation import SWITCHES, parse_augmentation
from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.bone_maps import BoneMap
from blender_addon.w2w.core.imu import Synthesis
from blender_addon.w2w.core.library import Library, read_library
from blender_addon.w2w.core.sensor_presets import DEFAULT_SENSOR
from blender_addon.w2w.core.study import StudyConfig
from blender_addon.w2w.core.utility import unavailable
from blender_addon.w2w.core.windows import WindowSpec

from .advice_text import show_advice
from .bodies import parse_bodies, write_comparison
from .clip_files import WORK
from .clip_job import Outcome
from .engine import EngineError
from .event_log import SILENT, EventLog
from .exit_codes import BUSY, INTERRUPTED, NOTHING_TO_DO, SKIPPED, USAGE
from .finished import FinishedStudy
from .folder_lock import FolderBusyError, only_run
from .left_out import show_left_out
from .pipeline import Engine, Study, StudyError, make_folders, run_study, write_config
from .progress import Progress
from .report import REPORT, write_report
from .results import top_regions, write_failure, write_results
from .together import sensors_together
from .views import write_blend, write_pictures
from .watch import Watch
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
        raise _ended(str(error), USAGE, console, log) from error
    engine = Engine(workers, scheduler, clip_limit, bone_maps, round(clip_memory * 2**30))
    show_labels(found, console)
    studies = []
    for name, body in chosen:
        folder = out if len(chosen) == 1 else out / name
        studies.append((name, execute(found, body, config, folder, engine, pictures, console, report, log)))
    if len(chosen) > 1:
        show_comparison(write_comparison(studies, out), console)
    if strict and any(len(study.used) < len(study.outcomes) + len(found.skipped) for _, study in studies):
        raise _ended("Clips were skipped and --strict was asked for.", SKIPPED, console, log)
    log("finished", exit_code=0)


def _ended(text: str, code: int, console: Console, log: EventLog) -> typer.Exit:
    """Say why the run ends here; gives the exit to raise."""
    console.print(text, style="red", markup=False)
    log("finished", exit_code=code, problem=text)
    return typer.Exit(code)


def execute(
    library: Library,
    body: Body,
    config: StudyConfig,
    out: Path,
    engine: Engine,
    pictures: bool,
    console: Console,
    report: bool = True,
    log: EventLog = SILENT,
) -> Study:
    """Run a study with its progress on the console, and write everything down.

    Raises
    ------
    typer.Exit
        With the exit code, when there is no result.
    """
    try:
        make_folders(out)
        log("started", out=str(out), body=body.name, clips=len(library.clips), activities=library.activities)
        for file, reason in library.skipped:
            log("clip", file=file, used=False, reason=reason)
        watch = Watch(out, len(library.clips), log)
        with only_run(out / WORK):
            study = _execute(library, body, config, out, engine, pictures, console, watch, report)
    except FolderBusyError as error:
        raise _ended(str(error), BUSY, console, log) from error
    except OSError as error:
        text = f"No result: {out} cannot be written: {error}. What is finished is kept."
        raise _ended(text, NOTHING_TO_DO, console, log) from error
    show_outcome(study, pictures, console, report)
    log("result", out=str(out), used=len(study.used), skipped=len(_skipped(study.outcomes, library)))
    return study


def _execute(
    library: Library,
    body: Body,
    config: StudyConfig,
    out: Path,
    engine: Engine,
    pictures: bool,
    console: Console,
    watch: Watch,
    report: bool,
) -> Study:
    progress = Progress(console)
    try:
        study = run_study(library, body, config, out, engine, progress, watch)
        watch.step("testing the sensors together")
        with progress.spinner("Testing the sensors together"):
            tested = sensors_together(FinishedStudy.of(study), study.advice.subset.order)
        study = replace(study, together=tested)
        watch.step("writing results")
        write_config(study)
        write_results(study)
        if pictures:
            write_pictures(study, progress)
            write_blend(study, progress)
        if report:
            write_report(out)
    except (StudyError, EngineError) as error:
        watch.step("failed", str(error))
        if isinstance(error, StudyError):
            write_failure(out, library, error)
            show_skipped(_skipped(error.outcomes, library), console)
        raise _ended(f"No result: {error}", NOTHING_TO_DO, console, watch.log) from error
    except KeyboardInterrupt as error:
        text = "\nStopped. What is finished is kept: the same command goes on from here."
        raise _ended(text, INTERRUPTED, console, watch.log) from error
    watch.step("finished")
    return study


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


def show_labels(library: Library, console: Console) -> None:
    """Print the labelling that was understood."""
    table = Table(
        title=f"{len(library.clips)} clips, labelled by {library.labelled_by}", title_justify="left"
    )
    table.add_column("activity")
    table.add_column("clips", justify="right")
    table.add_column("for example")
    for activity, count in library.activities.items():
        example = next(clip.file for clip in library.clips if clip.activity == activity)
        table.add_row(escape(activity), str(count), escape(example))
    console.print(table)


def show_outcome(study: Study, pictures: bool, console: Console, report: bool = True) -> None:
    """Print what was found and where it stands."""
    utility = study.recommendation.utility
    skipped = _skipped(study.outcomes, study.library)
    show_skipped(skipped, console)
    show_left_out(utility.left_out, console)
    table = Table(title="Best regions (F1 of their best spot, mean over activities)", title_justify="left")
    table.add_column("region")
    table.add_column("mean F1", justify="right")
    for region, mean in top_regions(study):
        table.add_row(region, f"{mean:.3f}")
    console.print(table)
    show_advice(study.advice, utility, study.patches, study.together, console)
    console.print(f"{len(study.used)} clips used, {len(skipped)} skipped.")
    console.print(f"\nTable:    {study.out / 'utility.csv'}\nSummary:  {study.out / 'summary.json'}")
    if pictures:
        console.print(f"Heatmaps: {study.out / 'heatmaps'}\nBlender:  {study.out / 'study.blend'}")
    if report:
        console.print(f"Report:   {study.out / REPORT}")


def show_skipped(skipped: list[tuple[str, str]], console: Console) -> None:
    """Print which files were skipped, and why."""
    if not skipped:
        return
    table = Table(title=f"{len(skipped)} clips skipped", title_justify="left")
    table.add_column("file", overflow="fold")
    table.add_column("why", overflow="fold")
    for row in skipped:
        table.add_row(*map(escape, row))
    console.print(table)


def _skipped(outcomes: Sequence[Outcome], library: Library) -> list[tuple[str, str]]:
    """Files without use and the reasons."""
    return [(o.clip.file, o.reason) for o in outcomes if not o.used] + list(library.skipped)


def show_comparison(comparison: dict[str, Any], console: Console) -> None:
    """Print how far the maps of several bodies agree."""
    table = Table(
        title="How far the maps agree (Spearman's rho of mean F1 over places)", title_justify="left"
    )
    table.add_column("bodies")
    table.add_column("rho", justify="right")
    table.add_column("95 % interval", justify="right")
    for pair in comparison["agreement"]:
        low, high = pair["interval"]
        table.add_row(" and ".join(pair["bodies"]), f"{pair['spearman_mean']}", f"{low} to {high}")
    console.print(table)
