# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole study: clips to signals, signals to a ranking, the ranking to files people open."""

from __future__ import annotations

import hashlib
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.body.shapes import bundled_targets
from w2w.core.clip_files import WORK, ClipWindows, ranking_inputs
from w2w.core.clip_ranking import LabelledClip, copies_among, rank_clips, same_motions
from w2w.core.files import UNFINISHED, file_sha256, write_json
from w2w.core.findings.notes import copies_sentence
from w2w.core.findings.summary import config_content
from w2w.core.garments.cover import FITTED
from w2w.core.motion.library import Clip, Library
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap
from w2w.core.results_folder import ClipResult, Study, StudyResults, advised
from w2w.core.study import StudyConfig, place_patches

from .clip_task import ClipTask
from .cluster import spread_over
from .folder import code_sha256, forget_running, preparing, remove_leftovers
from .garments import fit_garments
from .monitor import RunMonitor
from .workers import Engine, clip_workers, run_tasks, spread_here


class StudyError(Exception):
    """A study cannot be finished: why, what to do, and what became of the clips until then."""

    def __init__(self, message: str, clips: Sequence[ClipResult] = ()) -> None:
        super().__init__(message)
        self.clips = tuple(clips)


@dataclass(frozen=True)
class RunPlan:
    """What a run is to do, whatever the body and the folder.

    `pictures` are the heatmaps and `study.blend`; `more` are files that the command writes after the run.
    """

    library: Library
    config: StudyConfig
    engine: Engine
    pictures: bool = True
    report: bool = True
    more: tuple[str, ...] = ()
    verbose: bool = False  # list every clip, activity and region on the console


def run_study(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> Study:
    """Bake every clip and rank every patch, in a folder made by `make_folders`.

    Raises a StudyError where there is no result, an EngineError where the workers cannot go on, and an
    OSError where the folder cannot be written.
    """
    config = plan.config
    with clip_workers(plan.engine, plan.library.clips) as workers:
        with monitor.step("placing patches", "Placing patches on the body"):
            patches = _prepare(plan, body, out)
        with ThreadPoolExecutor(1) as aside:  # takes seconds, while workers leave this process idle
            pooled = aside.submit(Pooling.on, body, patches)
            clips = tuple(_bake(plan, out, monitor, workers))
    used = [result.clip for result in clips if result.used]
    if not used:
        raise StudyError("no clip can be used; the table lists the reasons", clips)
    remove_leftovers(out, {clip.name for clip in used})
    pooling = pooled.result()
    try:
        utility, ranked = _rank(used, pooling, plan, out, monitor)
    except ValueError as error:
        activities = Counter(clip.activity for clip in used)
        found = ", ".join(f"{name} ({count})" for name, count in sorted(activities.items()))
        windows = [ClipWindows.read(out, clip.name) for clip in used]
        copies = copies_sentence(copies_among(used, same_motions(used, windows)))
        raise StudyError(
            f"{error}. Clips used by activity: {found}{'. ' * bool(copies)}{copies}", clips
        ) from error
    results = StudyResults(out, utility, patches, ranked, config.as_dict())
    with monitor.step("choosing sensors to wear together", "Choosing sensors to wear together"):
        try:
            advice = advised(results, config, pooling)
        except np.linalg.LinAlgError as error:
            raise StudyError("the clips show too few different motions to choose sensors by") from error
        except ValueError as error:
            raise StudyError(f"the constraints cannot be met: {error}") from error
    return Study(plan.library, config, body, clips, results, advice)


def make_shard(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor) -> tuple[ClipResult, ...]:
    """Bake the clips of a plan that is a part of a study's, and rank nothing; other parts may be at work.

    Raises as `run_study` does, and a FolderBusyError where a run holds the folder.
    """
    with clip_workers(plan.engine, plan.library.clips) as workers:
        with monitor.step("placing patches", "Placing patches on the body"), preparing(out / WORK):
            _prepare(plan, body, out)
        return tuple(_bake(plan, out, monitor, workers))


def write_config(study: Study) -> None:
    """Save every parameter, the versions and the hashes of all inputs beside the results."""
    content = config_content(study)
    write_json(study.results.out / "config.json", content | {"code_sha256": code_sha256()})


def _prepare(plan: RunPlan, body: Body, out: Path) -> PatchSet:
    """Place the patches; on the bundled body's shapes they stay at the vertices of the neutral one."""
    config = plan.config
    bundled = bundled_targets().fit(body)
    if config.augmentation and config.augmentation.bodies and not bundled:
        raise StudyError(f"--augment bodies needs W2W's own body, and {body.name!r} is another: leave it out")
    if config.augmentation and config.garments:
        raise StudyError("--augment alters the motion of the skin alone: leave it out with --garment")
    forget_running(out, {clip.name for clip in plan.library.clips})
    try:
        patches = place_patches(Body.bundled() if bundled else body, config)
        fit_garments(config, body, patches, out)
    except ValueError as error:
        raise StudyError(str(error)) from error
    for what, name in ((body, "body.npz"), (patches, "patches.npz")):
        _save_new(what, out / WORK / name)
    try:
        config.constraints.terms(patches)
    except ValueError as error:
        raise StudyError(f"the constraints cannot be met: {error}") from error
    return patches


def _save_new(what: Body | PatchSet, path: Path) -> None:
    """Save what is not there yet as it is: a shard leaves alone what another reads."""
    fresh = path.with_name(f".{path.name}{UNFINISHED}")
    what.save(fresh)
    if path.exists() and file_sha256(path) == file_sha256(fresh):
        fresh.unlink()
    else:
        fresh.replace(path)


def _bake(plan: RunPlan, out: Path, monitor: RunMonitor, workers: Executor | None) -> list[ClipResult]:
    config, engine = plan.config, plan.engine
    files = [f"{WORK}/body.npz", f"{WORK}/patches.npz", *([FITTED] if config.garments else ())]
    inputs = hashlib.sha256(
        b"".join((out / name).read_bytes() for name in files)
        + repr((config.signal_parameters(), engine.bone_maps, engine.pose)).encode()
        + code_sha256().encode()
    ).hexdigest()
    out = out.resolve()
    tasks = [
        # the absolute path keeps a link's own name, which says its kind
        ClipTask(replace(clip, path=clip.path.absolute()), out, config, inputs, engine)
        for clip in plan.library.clips
    ]
    with monitor.bar("turning motions to signals", len(tasks), "Motions to signals") as advance:

        def progress(result: ClipResult) -> None:
            monitor.clip_done(result)
            advance(1)

        return run_tasks(tasks, engine.workers, engine.scheduler, progress, workers)


def _rank(
    used: list[Clip], pooling: Pooling, plan: RunPlan, out: Path, monitor: RunMonitor
) -> tuple[UtilityMap, tuple[LabelledClip, ...]]:
    config, out = plan.config, out.resolve()  # where a cluster finds it, too
    places = [(out, clip.name) for clip in used]
    windows = [ClipWindows.read(*place) for place in places]
    inputs = ranking_inputs(places, windows, config.classifier, config.windows)
    with monitor.bar("ranking patches", 100) as advance:
        done = 0

        def progress(fraction: float) -> None:
            nonlocal done
            advance(int(100 * fraction) - done)
            done = int(100 * fraction)

        engine, n_windows = plan.engine, sum(len(found.is_test) for found in windows)
        spread = spread_over(engine.scheduler) or spread_here(engine.workers, n_windows)
        return rank_clips(used, windows, inputs, config, progress, out / WORK, pooling=pooling, spread=spread)
