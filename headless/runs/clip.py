# SPDX-License-Identifier: GPL-3.0-or-later
"""The work on one clip, from its file to its motion, signals and features on disk."""

from __future__ import annotations

import hashlib
import json
import re
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from w2w.core.body.body import Body
from w2w.core.clip_files import WORK, copy_file, features_file, write_features
from w2w.core.files import UNFINISHED, file_sha256, write_json
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.duplicates import motion_signature
from w2w.core.motion.library import Clip
from w2w.core.motion.motion import Motion
from w2w.core.motion.motion_file import readable_size, unreadable
from w2w.core.motion.source import UnusableMotion, reason_of
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.windows import TooShortError
from w2w.core.study import StudyConfig, copies_of, describe, record

from ..needs_blender import NoBlenderError
from .guard import LIMIT_S, MEMORY, guarded, timed_out, untimed
from .load_clip import load_clip
from .own_files import files_of_record, remove_own


@dataclass(frozen=True)
class Job:
    """All that a worker needs to know about one clip.

    Parameters
    ----------
    clip : Clip
    out : Path
        The study's output folder.
    config : StudyConfig
    inputs : str
        Hash of the body, the patches, the config and the code that the outcome depends on.
    limit_s : float
        Seconds after which a worker gives the clip up.
    bone_maps : tuple of BoneMap
        The user's own, tried before the bundled ones.
    memory : int
        Bytes that a worker may take.
    """

    clip: Clip
    out: Path
    config: StudyConfig
    inputs: str
    limit_s: float = LIMIT_S
    bone_maps: tuple[BoneMap, ...] = ()
    memory: int = MEMORY

    @property
    def motion_file(self) -> Path:
        """The retargeted motion."""
        return self.out / "motions" / f"{self.clip.name}.npz"

    @property
    def signals_file(self) -> Path:
        """The recording of all patches."""
        return self.out / "signals" / f"{self.clip.name}.npz"

    @property
    def features_file(self) -> Path:
        """Windows as features, for the ranking."""
        return features_file(self.out, self.clip.name)

    @property
    def record_file(self) -> Path:
        """What was done, and from what: written before the files get their names."""
        return self.out / WORK / "clips" / f"{self.clip.name}.json"

    @property
    def marker(self) -> Path:
        """There while a worker is at it."""
        return self.out / WORK / "running" / self.clip.name

    def key(self, source_sha256: str) -> str:
        """Hash of everything that the outcome depends on."""
        parts = (self.inputs, source_sha256, self.clip.activity, self.clip.subject, self.clip.name)
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()


def unfinished(path: Path) -> Path:
    """Where a motion or recording stands until the clip's record names it."""
    return path.with_name(f".{path.name}{UNFINISHED}")


@dataclass(frozen=True)
class Outcome:
    """What became of a clip.

    Parameters
    ----------
    clip : Clip
    reason : str
        Why it was skipped; empty where it is used.
    details : dict
        What the summary says of a used clip: take, frames, rate, duration, windows, skeleton.
    source_sha256 : str
        Hash of the clip's file.
    """

    clip: Clip
    reason: str
    details: dict[str, Any]
    source_sha256: str

    @property
    def used(self) -> bool:
        """Whether the clip takes part in the ranking."""
        return not self.reason


SAMPLE_BYTES = 24
"""Bytes of one sample of one sensor: six values in single precision."""

SIGNALS_SHARE = 4
"""Signals may take this part of a worker's memory; their windows and features want as much again."""


def work_in_worker(job: Job) -> Outcome:
    """Do a clip's work in a worker process that ends itself when it takes too much."""
    job.marker.parent.mkdir(parents=True, exist_ok=True)
    job.marker.write_text("")
    try:
        with guarded(job.limit_s, job.memory, job.marker):
            return do_clip(job)
    finally:
        job.marker.unlink(missing_ok=True)


def record_death(job: Job) -> Outcome:
    """The outcome of a clip that killed its worker, kept so that no later run tries it again."""
    source = _marked_source(job)
    if timed_out(job.marker):
        reason = f"it took longer than the limit of {job.limit_s:g} s (see --clip-limit)"
    else:
        reason = (
            "Blender crashed on it: it is damaged in a way that the importer does not survive, or it needs "
            f"more than {job.memory / 2**30:g} GiB of memory (see --clip-memory)"
        )
    job.marker.unlink(missing_ok=True)
    if not source:  # it died while reading the file's bytes: nothing to know it by
        return Outcome(job.clip, reason, {}, "")
    return _conclude(job, source, reason, {}, ())


def do_clip(job: Job) -> Outcome:
    """Do a clip's work, or take up what an earlier run finished.

    Never raises for what is wrong with a clip: the outcome says it.

    Raises
    ------
    NoBlenderError
        If Blender's module cannot be imported here, so that no clip could be read.
    """
    try:
        return _do_clip(job)
    finally:
        for path in (job.motion_file, job.signals_file):
            unfinished(path).unlink(missing_ok=True)


def _do_clip(job: Job) -> Outcome:
    try:
        readable_size(job.clip.path)  # pipes and devices never end
        source = file_sha256(job.clip.path)
    except UnusableMotion as error:
        return Outcome(job.clip, reason_of(error), {}, "")
    except OSError as error:
        return Outcome(job.clip, unreadable(error), {}, "")
    _mark_source(job, source)
    key = job.key(source)
    with untimed():
        done = _finished(job, key)
    if done is not None:
        return Outcome(job.clip, done["reason"], done["details"], source)
    try:
        with threadpool_limits(1):  # sums split over threads round otherwise: not the same bytes everywhere
            details, files = _make(job)
    except (UnusableMotion, ValueError) as error:  # core says ValueErrors for people: too short, not finite
        return _conclude(job, source, reason_of(error), {}, ())
    except MemoryError:
        reason = f"it needs more than {job.memory / 2**30:g} GiB of memory (see --clip-memory)"
        return _conclude(job, source, reason, {}, ())
    except OSError:
        if job.clip.path.exists():
            raise  # the output folder's fault: the disk is full or gone
        return Outcome(job.clip, "it went away while it was being read", {}, source)
    except NoBlenderError:
        raise  # no fault of the clip's, so no record of it
    except Exception as error:  # a fault of ours costs this clip, not the night
        reason = f"W2W failed on it, please report this: {type(error).__name__}: {error}"
        return _conclude(job, source, reason, {}, ())
    return _conclude(job, source, "", details, files)


def _make(job: Job) -> tuple[dict[str, Any], tuple[Path, ...]]:
    body, patches = _body_and_patches(job.out, job.inputs)
    _, motion, details = load_clip(job.clip, body, job.bone_maps)
    _refuse_too_long(motion, job)
    recording = record(body, patches, motion, job.config)
    features, is_test = describe(recording, job.config)
    copies, copy_files = _make_copies(job, body, patches, motion)
    signature = motion_signature(motion)
    with untimed():
        write_features(job.features_file, [features, *copies], is_test, signature)
        motion.save(unfinished(job.motion_file))
        recording.save(unfinished(job.signals_file))
    details = {**details, "windows": len(is_test), "test_windows": int(np.sum(is_test))}
    if job.config.augmentation is not None:
        details |= {"copies": len(copies), "copy_windows": sum(len(copy) for copy in copies)}
    return details, (job.motion_file, job.signals_file, job.features_file, *copy_files)


def _make_copies(
    job: Job, body: Body, patches: PatchSet, motion: Motion
) -> tuple[list[np.ndarray], list[Path]]:
    """Features of the augmented copies, and the files of their recordings where they are kept."""
    features, files = [], []
    for recording in copies_of(body, patches, motion, job.config):
        try:
            features.append(describe(recording, job.config)[0])
        except TooShortError:  # played faster, a short clip may no longer fill a window
            continue
        if job.config.keeps_copies():
            files.append(copy_file(job.out, job.clip.name, len(files)))
            with untimed():
                recording.save(files[-1])
    return features, files


def _refuse_too_long(motion: Motion, job: Job) -> None:
    """Refuse signals that would take more than their share of the worker's memory."""
    config = job.config
    rate = max(config.synthesis.rate_hz, config.sensor_model().rate_hz or 0.0)
    per_second = rate * config.patches * SAMPLE_BYTES
    longest = job.memory / SIGNALS_SHARE / per_second
    if motion.duration > longest:
        raise UnusableMotion(
            f"it lasts {motion.duration / 60:.0f} minutes, and its signals at {config.patches} places would "
            f"take {motion.duration * per_second / 2**30:.1f} GiB: cut it into parts of at most "
            f"{longest / 60:.0f} minutes, or raise --clip-memory"
        )


def _conclude(
    job: Job, source: str, reason: str, details: dict[str, Any], files: tuple[Path, ...]
) -> Outcome:
    """Write down what became of a clip: only now does it count as done.

    The record goes first and the files get their names after it, so that a kill at any moment
    leaves no file of ours that no record names; `_finished` names them where it did not come to it.
    """
    with untimed():
        _record(job, source, reason, details, files)
    return Outcome(job.clip, reason, details, source)


def _record(job: Job, source: str, reason: str, details: dict[str, Any], files: tuple[Path, ...]) -> None:
    names = {path.relative_to(job.out).as_posix(): _standing(path) for path in files}
    before = files_of_record(job.record_file)
    remove_own(job.out, {name: value for name, value in before.items() if name not in names})
    content = {
        "key": job.key(source),
        "reason": reason,
        "details": details,
        "files": {name: file_sha256(path) for name, path in names.items()},
    }
    write_json(job.record_file, content)
    for name, path in names.items():
        path.replace(job.out / name)


def _standing(path: Path) -> Path:
    """Where a file of a clip is until it is recorded."""
    return unfinished(path) if unfinished(path).exists() else path


def _mark_source(job: Job, source: str) -> None:
    """Note the hash for `record_death`, which must not read a file that killed a worker."""
    if job.marker.exists():
        with job.marker.open("a", encoding="ascii") as stream:
            stream.write(f"{source}\n")


def _marked_source(job: Job) -> str:
    """The hash of the clip's file; empty where the worker did not come so far."""
    try:
        first = job.marker.read_text(errors="replace").partition("\n")[0]
    except OSError:
        return ""
    return first if re.fullmatch("[0-9a-f]{64}", first) else ""


def _finished(job: Job, key: str) -> dict[str, Any] | None:
    """The record of an earlier run, if its inputs are the same and its files are whole."""
    try:
        done = json.loads(job.record_file.read_text(encoding="utf-8"))
        if done["key"] != key or not isinstance(done["reason"], str) or not isinstance(done["details"], dict):
            return None
        whole = all(_is_whole(job.out / name, value) for name, value in done["files"].items())
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return done if whole else None


def _is_whole(path: Path, sha256: str) -> bool:
    """Whether a file is as its record says; one that a kill left without its name gets it now."""
    nameless = unfinished(path)
    if nameless.exists() and file_sha256(nameless) == sha256:
        nameless.replace(path)
    return file_sha256(path) == sha256


@cache
def _body_and_patches(out: Path, inputs: str) -> tuple[Body, PatchSet]:  # noqa: ARG001 - a key of the cache
    """The study's body and patches, read once a worker and study."""
    return Body.load(out / WORK / "body.npz"), PatchSet.load(out / WORK / "patches.npz")
