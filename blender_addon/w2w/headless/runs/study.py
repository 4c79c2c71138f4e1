# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole study: clips to signals, signals to a ranking, the ranking to files people open."""

import hashlib
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import closing, nullcontext
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from ...core.body.body import Body
from ...core.body.shapes import bundled_targets
from ...core.files import stamp, write_json
from ...core.findings.cautions import copies_sentence
from ...core.findings.summary import config_content
from ...core.library.library import Clip, Library
from ...core.motion.up import UPSIDE_DOWN, mostly_head_down
from ...core.patches.patches import PatchSet
from ...core.ranking.pooling import Pooling
from ...core.ranking.stream import Stream
from ...core.ranking.utility import UtilityMap
from ...core.reading.reader import Death
from ...core.study.choosing import Choices, tried_stream
from ...core.study.clip_files import (
    NO_SIGNATURE,
    WORK,
    ClipWindows,
    FilesToRank,
    Signatures,
    mark_changing,
    ranking_inputs,
)
from ...core.study.config import StudyConfig
from ...core.study.ranking import copies_among, rank_clips, same_motions
from ...core.study.results import ClipResult, SimulatedClips, Study, StudyResults
from ...core.study.signals import place_patches
from ...core.threads import unthreaded_products
from ...core.wording import restated
from .clip import give_up
from .clip_task import ClipTask, Engine, Record, digest_of_path
from .cluster import spread_over
from .covers import fit_covers
from .folder import (
    SUMMARY,
    code_sha256,
    forget_running,
    placed_files,
    preparing,
    remove_leftovers,
    save_new,
    signals_made_by,
)
from .monitor import RunMonitor
from .records import Records, keeping, lists_in, read_records, result_of, tidy, untouched
from .workers import Crew, run_tasks, spread_here

TOO_ALIKE = "the clips show too few different motions"


class StudyError(Exception):
    """A study cannot be finished: why, what to do, and what became of the clips until then."""

    def __init__(self, message: str, clips: Sequence[ClipResult] = ()) -> None:
        super().__init__(message)
        self.clips = tuple(clips)


@dataclass(frozen=True)
class RunPlan:
    """The settings of a run that do not depend on the body and the folder.

    `deadly` are the files that killed or outlasted who looked at them first;
    `pictures` are the heatmaps and `study.blend`; `more` are files that the command writes after the run;
    `again` has all results made even where they would be as they are. The `crew` works for it on this
    machine; who runs the plan ends it. The patches are `placed` meanwhile, or when they are needed.
    `look` adds what a first look at all files tells, once there is something to do.
    """

    library: Library
    config: StudyConfig
    engine: Engine
    pictures: bool = True
    report: bool = True
    more: tuple[str, ...] = ()
    again: bool = True
    verbose: bool = False  # list every clip, activity and region on the console
    deadly: Mapping[Path, Death] = field(default_factory=dict)
    crew: Crew = field(default_factory=Crew)
    placed: Future[PatchSet] | None = None
    look: Callable[["RunPlan"], "RunPlan"] = lambda plan: plan


@dataclass(frozen=True)
class BakedStudy:
    """A study up to the signals of its clips."""

    body: Body
    patches: PatchSet
    clips: tuple[ClipResult, ...]
    pooling: Pooling


def make_signals(plan: RunPlan, body: Body, out: Path, monitor: RunMonitor, shard: str = "") -> BakedStudy:
    """Bake every clip of a plan in a folder made by `make_folders`, or a shard of them next to other shards.

    Raises a StudyError if no clip can be used, an EngineError if the workers cannot go on, an OSError
    where the folder cannot be written, and for a shard a FolderBusyError if a run holds the folder.
    """
    if not (out / SUMMARY).is_file():  # a first run: until it ends there is nothing to read
        mark_changing(out)
    if not lists_in(out):  # a resume may have nothing left to do: it starts workers once it has
        plan.crew.get_ready(plan.engine, plan.library.clips)
    alone = preparing(out / WORK) if shard else nullcontext()
    with monitor.step("placing patches", "Placing patches on the body"), alone:
        patches = _prepare(plan, body, out)
    with ThreadPoolExecutor(1) as beside:
        pooling = beside.submit(Pooling.on, None if shard else body, patches)
        clips, records = _bake(plan, out, monitor, shard)
    if not shard:
        if not any(result.used for result in clips):
            raise StudyError("no clip can be used; the table lists the reasons", clips)
        _refuse_head_down(clips)
        used = {result.clip.name for result in clips if result.used}
        remove_leftovers(out, {clip.name for clip in plan.library.clips}, used, records)
    return BakedStudy(body, patches, clips, pooling.result())


def _refuse_head_down(clips: Sequence[ClipResult]) -> None:
    """Refuse a library whose people hang head down in most frames; a few handstands are motions."""
    details = [result.details for result in clips if result.used]
    if mostly_head_down((facts.get("frames", 0), "head_down" in facts) for facts in details):
        raise StudyError(UPSIDE_DOWN, clips)


Ranked: TypeAlias = tuple[StudyResults, Future[Stream | None]]
"""A ranked study, and the stream of its clips (`tried_stream`), which knows F1 of each spot."""


def rank_study(plan: RunPlan, baked: BakedStudy, out: Path, monitor: RunMonitor) -> Ranked:
    """Rank every patch by the signals that were made; the stream is found beside it.

    Raises a StudyError if there is no result, and an EngineError if the workers cannot go on.
    """
    config, pooling = plan.config, baked.pooling
    used = [result.clip for result in baked.clips if result.used]
    failed = partial(StudyError, clips=baked.clips)
    with closing(Signatures(out / WORK)) as signatures, restated("", ValueError, failed):
        files = _files_to_rank(used, config, out, signatures)
        ranked = same_motions(used, files.windows, signatures)
    spread = spread_over(plan.engine.scheduler) or spread_here(plan.engine.workers, plan.crew)
    rank = partial(rank_clips, ranked, files.windows, files.inputs, config, pooling)
    clips = SimulatedClips(out, baked.patches, ranked, config.as_dict(), read=files)
    try:
        with (
            restated(f"{TOO_ALIKE} to rank patches by", np.linalg.LinAlgError, failed),
            unthreaded_products(),  # for both: else threads, and so rounding, would go by who ends first
            ThreadPoolExecutor(1) as beside,
            closing(plan.crew),
        ):
            stream = beside.submit(tried_stream, clips, config)
            utility = _with_bar(partial(rank, work=out.resolve() / WORK, spread=spread), monitor)
    except ValueError as error:
        activities = Counter(clip.activity for clip in used)
        found = ", ".join(f"{name} ({count})" for name, count in sorted(activities.items()))
        problem = f"{error}. Clips used by activity: {found}", copies_sentence(copies_among(used, ranked))
        raise StudyError(". ".join(filter(None, problem)), baked.clips) from error
    results = StudyResults(out, baked.patches, ranked, config.as_dict(), utility, read=files)
    return results, stream


def choose_in_study(
    plan: RunPlan,
    baked: BakedStudy,
    ranked: Ranked,
    monitor: RunMonitor,
    mapped: Callable[[StudyResults], None],
) -> Study:
    """Choose sensors in a ranked study; `mapped` is given its map, in a stream, before that.

    Raises a StudyError if the constraints cannot be met.
    """
    with (
        monitor.step("choosing sensors to wear together"),
        restated("the constraints cannot be met:", ValueError, StudyError),
        restated(f"{TOO_ALIKE} to choose sensors by", np.linalg.LinAlgError, StudyError),
    ):
        choices = Choices(ranked[0], plan.config, ranked[1].result())
        mapped(choices.study)
        advice = choices.under(plan.config)
    return Study(plan.library, plan.config, baked.body, baked.clips, choices.study, advice)


def write_config(study: Study) -> None:
    """Save every parameter, the versions and the hashes of all inputs with the results."""
    write_json(study.results.out / "config.json", config_content(study) | {"code_sha256": code_sha256()})


def placed_on(body: Body, config: StudyConfig) -> PatchSet:
    """The patches on a body; on the bundled one's shapes they stay at the vertices of the neutral one."""
    return place_patches(Body.bundled() if bundled_targets().fit(body) else body, config)


def _prepare(plan: RunPlan, body: Body, out: Path) -> PatchSet:
    """Write the body and the patches."""
    config = plan.config
    forget_running(out, {clip.name for clip in plan.library.clips})
    with restated("", ValueError, StudyError):
        patches = plan.placed.result() if plan.placed else placed_on(body, config)
        fit_covers(config, body, patches, out)
    save_new(body.save, out, f"{WORK}/body.npz")
    save_new(patches.save, out, f"{WORK}/patches.npz")
    with restated("the constraints cannot be met:", ValueError, StudyError):
        config.constraints.terms(patches)
    return patches


def _bake(
    plan: RunPlan, out: Path, monitor: RunMonitor, shard: str
) -> tuple[tuple[ClipResult, ...], Records]:
    """The result of each clip, and the records that the folder had before."""
    config, engine = plan.config, plan.engine
    inputs = hashlib.sha256(
        b"".join(path.read_bytes() for path in placed_files(out))
        + repr((config.signal_parameters(), engine.bone_maps, engine.pose, engine.signals)).encode()
        + signals_made_by().encode()
    ).hexdigest()
    out = out.resolve()
    records = read_records(out) if shard else tidy(out)
    library = digest_of_path(plan.library.folder)
    clips = {clip.name: clip for clip in plan.library.clips}
    results: dict[str, ClipResult] = {}
    due, died = [], []
    turning = monitor.bar("turning motions to signals", len(plan.library.clips), "Motions to signals")
    with turning as advance, keeping(out, records, shard) as keep:

        def known(record: Record) -> None:
            clip = clips[record["clip"]]
            results[clip.name] = result = result_of(clip, record).small()
            monitor.clip_done(result)

        def made(record: Record) -> None:
            keep(record)
            known(record)
            advance(1)

        for clip in plan.library.clips:
            its = replace(engine, rests=engine.rests.of_file(clip.file))
            task = ClipTask(clip, out, config, inputs, its, records.text(clip.name), library)
            if not engine.verify and (record := untouched(task)):
                known(record)
            elif (death := plan.deadly.get(clip.path)) and death.stamp == stamp(clip.path):
                died.append((task, death))
            else:
                due.append(task)
        advance(len(results))
        for task, death in died:
            made(give_up(task, death))
        run_tasks(due, engine.workers, engine.scheduler, made, plan.crew)
    return tuple(results[clip.name] for clip in plan.library.clips), records


def _files_to_rank(used: list[Clip], config: StudyConfig, out: Path, signatures: Signatures) -> FilesToRank:
    """The contents of the clips' files for the ranking; their signatures go elsewhere."""
    out = out.resolve()  # where a cluster finds it, too
    places = [(out, clip.name) for clip in used]
    windows = []
    for place in places:
        found = ClipWindows.read(*place)
        signatures.append(found.signature)
        windows.append(replace(found, signature=NO_SIGNATURE))
    inputs = ranking_inputs(places, windows, config.classifier, config.windows)
    return FilesToRank(tuple(windows), inputs, config.classifier)


def _with_bar(rank: Callable[..., UtilityMap], monitor: RunMonitor) -> UtilityMap:
    """The result of a ranking, with a progress bar."""
    with monitor.bar("ranking patches", 100) as advance:
        done = 0

        def progress(fraction: float) -> None:
            nonlocal done
            advance(int(100 * fraction) - done)
            done = int(100 * fraction)

        return rank(progress=progress)
