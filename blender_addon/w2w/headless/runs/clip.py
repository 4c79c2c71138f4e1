# SPDX-License-Identifier: GPL-3.0-or-later
"""The work on one clip, from its file to its motion, signals and features on disk."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ...core.body.body import Body
from ...core.files import file_sha256
from ...core.imu.cover import FITTED, ClothSensors, Cover, load_covers
from ...core.library.library import Clip
from ...core.motion.motion import Motion
from ...core.motion.signature import motion_signature
from ...core.motion.source import UnusableMotion, readable_size, reason_of, unreadable
from ...core.patches.patches import PatchSet
from ...core.reading.clips import fit_clip, read_clip
from ...core.reading.formats import Source
from ...core.reading.guard import allowed_memory, crashed, guarded, quiet_output, timed_out, untimed
from ...core.reading.reader import Death
from ...core.study.clip_files import WORK, mark_changing, write_features
from ...core.study.signals import describe, measured, simulate
from ...core.threads import unthreaded_products
from ..blender import NoBlenderError, needs_blender
from .clip_task import ClipTask, Engine, Looks, Record, mark_read, marked_read
from .records import finished, not_kept, record_of, unfinished

SAMPLE_BYTES = 24
"""Bytes of one sample of one sensor: six values in single precision."""

CRASHES = 2
"""Crashes of a worker of its own after which a clip is given up."""

TRIES = 6
"""Workers of its own that a clip gets before it is left to the next run."""

READS = 3
"""Times that a clip is read before it is skipped because its file keeps changing."""

SIGNALS_SHARE = 4
"""Part of a worker's memory that signals may take: windows and features take as much again."""


def get_ready(blender: bool) -> None:
    """Import what a clip needs before there is work: filters take half a second, Blender seconds.

    What fails here fails again at the first clip that needs it, which says so.
    """
    with guarded(), quiet_output():
        import scipy.signal  # noqa: F401

        if blender:
            from ...scene.motion import takes  # noqa: F401


def work_in_worker(task: ClipTask) -> Record:
    """Do a clip's work in a worker process that ends itself when it takes too much."""
    task.marker.parent.mkdir(parents=True, exist_ok=True)
    task.marker.write_text("")
    try:
        with guarded(task.engine.limit_s, task.engine.memory, task.marker):
            return do_clip(task)
    finally:
        task.marker.unlink(missing_ok=True)


def record_death(task: ClipTask) -> Record:
    """The record of a clip that killed its worker, kept so that no later run tries it again."""
    seen, late = marked_read(task), timed_out(task.marker)
    task.marker.unlink(missing_ok=True)
    if not late and allowed_memory() < task.engine.memory:
        return _out_of_memory(task, seen)
    if late:
        reason = f"it took longer than the limit of {task.engine.limit_s:g} s (see --clip-limit)"
    else:
        reason = (
            "the program that reads it crashed: it is damaged in a way that it does not survive, or it needs "
            f"more than {task.engine.memory / 2**30:g} GiB of memory (see --clip-memory)"
        )
    if not seen["sha256"]:  # it died while reading the file's bytes: nothing to know it by
        return not_kept(task, reason)
    return _recorded(task, seen, reason, limits=task.engine.limits)


def give_up(task: ClipTask, death: Death) -> Record:
    """The record of a clip that killed or outlasted who looked at it first, kept for later runs."""
    looks = task.look()
    try:
        seen = {"sha256": file_sha256(task.clip.path), "looks": looks}
    except OSError as error:
        return not_kept(task, unreadable(error))
    hint = " (see --clip-limit)"
    reason = death.reason.removesuffix(hint) + hint
    return record_of(task, seen, reason, limits=task.engine.limits, unseen=True)


def try_alone(task: ClipTask, once: Callable[[ClipTask], Record | None]) -> Record:
    """Do a task at which workers died, again and again with a worker of its own.

    A clip is to blame only if it crashes such a worker twice, or takes too long: workers are also killed
    from outside, when their job ends or the machine is short of memory. `once` returns None if its worker
    died.
    """
    crashes = 0
    for _ in range(TRIES):
        task.marker.unlink(missing_ok=True)  # it says how another try ended
        if (record := once(task)) is not None:
            return record
        crashes += crashed(task.marker)
        if timed_out(task.marker) or crashes == CRASHES:
            return record_death(task)
    task.marker.unlink(missing_ok=True)
    reason = "not done yet: workers were killed while at it; run again to take it up"
    return not_kept(task, reason)


def do_clip(task: ClipTask) -> Record:
    """Do a clip's work, or find what an earlier run finished; its files get their names with its record.

    The record says what is wrong with a clip; a NoBlenderError means that no clip could be read here.
    """
    for _ in range(READS):
        looks, is_done = task.look(), False
        try:
            record = _do_clip(task, looks)
            is_done = task.look() == looks
        finally:
            for path in () if is_done else (task.motion_file, task.signals_file):
                unfinished(path).unlink(missing_ok=True)
        if is_done:
            return record
    return not_kept(task, "it changes while it is being read: run again once nothing writes it")


def _do_clip(task: ClipTask, looks: Looks) -> Record:
    try:
        readable_size(task.clip.path)  # pipes and devices never end
        seen: Record = {"sha256": file_sha256(task.clip.path), "looks": looks}
    except UnusableMotion as error:
        return not_kept(task, reason_of(error))
    except OSError as error:
        return not_kept(task, unreadable(error))
    mark_read(task, seen)
    key = task.key(seen["sha256"])
    with untimed():
        if (done := finished(task, key, seen)) is not None:
            return done
    try:
        with unthreaded_products():  # the same bytes everywhere
            made = _make(task)
    except MemoryError:
        return _out_of_memory(task, seen)
    except OSError:
        if task.clip.path.exists():
            raise  # the output folder's fault: the disk is full or gone
        return not_kept(task, "it went away while it was being read")
    except NoBlenderError:
        raise  # no fault of the clip's, so no record of it
    except Exception as error:  # even a fault of ours costs this clip, not the night
        if isinstance(error, ImportError) and allowed_memory() < task.engine.memory:  # no room for a library
            return _out_of_memory(task, seen)
        return _recorded(task, seen, reason_of(error))
    return _recorded(task, seen, made=made)


def _out_of_memory(task: ClipTask, seen: Record) -> Record:
    """The record of a clip that needs too much memory, kept unless it was not W2W that allowed so little."""
    allowed = allowed_memory()
    if allowed < task.engine.memory:
        reason = f"it takes more than the {allowed / 2**30:.1f} GiB of memory that W2W may use here (ulimit)"
        return not_kept(task, reason)
    reason = f"it needs more than {task.engine.memory / 2**30:g} GiB of memory (see --clip-memory)"
    return _recorded(task, seen, reason, limits=task.engine.limits)


def _make(task: ClipTask) -> tuple[dict[str, Any], tuple[Path, ...]]:
    body, patches = _body_and_patches(task.out, task.inputs)
    how = task.engine
    _, motion, details = load_clip(task.clip, body, how)
    _refuse_too_long(motion, task)
    on_cloth = _sensors_on_cloth(task, body, patches, motion)
    recording = simulate(body, patches, motion, task.config, on_cloth)
    features, is_test = describe(recording, task.config)
    signature = motion_signature(motion)
    with untimed():
        mark_changing(task.out)
        write_features(task.features_file, features, is_test, signature)
        motion.save(unfinished(task.motion_file))
        if task.engine.signals:
            recording.save(unfinished(task.signals_file))
    details = {**details, "windows": len(is_test), "test_windows": int(np.sum(is_test))}
    details |= task.config.sensor_model().full_scale_content(recording)
    if on_cloth is not None:
        details |= on_cloth.facts()
    kept = (task.signals_file,) if task.engine.signals else ()
    return details, (task.motion_file, *kept, task.features_file)


def _sensors_on_cloth(task: ClipTask, body: Body, patches: PatchSet, motion: Motion) -> ClothSensors | None:
    """The places of the sensors on cloth, as Blender moves it; None where all sit on the skin."""
    if task.config.on_skin:
        return None
    covers = _covers(task.out, task.inputs)
    with needs_blender(), quiet_output():
        from ...scene.cloth.bake import followed

        return followed(body, patches, covers, measured(motion, task.config))


PLAIN = Engine()


def load_clip(clip: Clip, body: Body, how: Engine = PLAIN) -> tuple[Source, Motion, dict[str, Any]]:
    """Read a clip's file and retarget it to the body, under the clip's labels.

    Returns what the file holds, the motion, and facts: take, skeleton, scale, frames, rate, duration. Raises
    UnusableMotion and NoBlenderError.
    """
    with needs_blender():
        source = read_clip(clip, how)
    found = fit_clip(source, clip, body, how)
    return source, found.motion, found.facts()


def _refuse_too_long(motion: Motion, task: ClipTask) -> None:
    """Refuse signals that would take more than their share of the worker's memory."""
    config = task.config
    rate = max(config.synthesis.rate_hz, config.sensor_model().rate_hz or 0.0)
    per_second = rate * config.patches * (SAMPLE_BYTES + config.further.sample_bytes)
    longest = task.engine.memory / SIGNALS_SHARE / per_second
    if motion.duration > longest:
        raise UnusableMotion(
            f"it lasts {motion.duration / 60:.0f} minutes, and its signals at {config.patches} patches would "
            f"take {motion.duration * per_second / 2**30:.1f} GiB: cut it into parts of at most "
            f"{longest / 60:.0f} minutes, or raise --clip-memory"
        )


def _recorded(task: ClipTask, *what: Any, **more: Any) -> Record:
    """`record_of` a clip, whose hashes are not its own time."""
    with untimed():
        return record_of(task, *what, **more)


@cache  # read once a worker and study
def _body_and_patches(out: Path, inputs: str) -> tuple[Body, PatchSet]:  # noqa: ARG001 - a key of the cache
    return Body.load(out / WORK / "body.npz"), PatchSet.load(out / WORK / "patches.npz")


@cache
def _covers(out: Path, inputs: str) -> Mapping[str, Cover]:  # noqa: ARG001 - a key of the cache
    """What covers the skin, read once per worker and study."""
    return load_covers(out / FITTED)
