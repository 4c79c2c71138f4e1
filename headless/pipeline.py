# SPDX-License-Identifier: GPL-3.0-or-later
"""A whole study: clips to signals, signals to a ranking, the ranking to files people open."""

from __future__ import annotations

import hashlib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import joblib
import numpy as np

from blender_addon.w2w.core.body import Body
from blender_addon.w2w.core.files import write_json
from blender_addon.w2w.core.library import Clip, Library
from blender_addon.w2w.core.patches import PatchSet
from blender_addon.w2w.core.study import Recommendation, StudyConfig, place_patches, recommend, same_clips

from .blender_process import inside_blender
from .clip_job import WORK, Job, Outcome, do_clip
from .progress import Progress
from .versions import code_sha256, versions

BATCH = 4
"""Clips handed to a worker at a time."""


class StudyError(Exception):
    """A study cannot be finished; the message says why and what to do."""


@dataclass(frozen=True)
class Study:
    """A finished study, ready to be written down.

    Parameters
    ----------
    library : Library
    config : StudyConfig
    body : Body
    patches : PatchSet
    outcomes : tuple of Outcome
        What became of each clip, in the library's order.
    groups : ndarray, shape (used clips,), int
        Which used clips show the same motion.
    recommendation : Recommendation
    out : Path
        Output folder.
    """

    library: Library
    config: StudyConfig
    body: Body
    patches: PatchSet
    outcomes: tuple[Outcome, ...]
    groups: np.ndarray
    recommendation: Recommendation
    out: Path

    @property
    def used(self) -> list[Outcome]:
        """Clips that take part."""
        return [outcome for outcome in self.outcomes if outcome.used]


def run_study(library: Library, config: StudyConfig, out: Path, workers: int, progress: Progress) -> Study:
    """Bake every clip, rank every patch.

    Parameters
    ----------
    library : Library
    config : StudyConfig
    out : Path
        Output folder; made where it is missing.
    workers : int
        Processes that work on clips at the same time; the outcome does not depend on it.
    progress : Progress

    Raises
    ------
    StudyError
        If no clip can be used or fewer than two activities can be told apart.
    """
    for folder in ("motions", "signals", f"{WORK}/features", f"{WORK}/clips"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    body, patches = _prepare(config, out, progress)
    outcomes = _bake(library, config, out, workers, progress)
    used = [outcome.clip for outcome in outcomes if outcome.used]
    if not used:
        raise StudyError(
            "no clip can be used:\n" + "\n".join(f"  {o.clip.file}: {o.reason}" for o in outcomes)
        )
    recommendation, groups = _rank(used, config, out, progress)
    return Study(library, config, body, patches, tuple(outcomes), groups, recommendation, out)


def write_config(config: StudyConfig, library: Library, outcomes: list[Outcome], out: Path) -> None:
    """Save every parameter, the versions and the hashes of all inputs beside the results."""
    write_json(
        out / "config.json",
        {
            "parameters": config.as_dict(),
            "versions": versions(),
            "code_sha256": code_sha256(),
            "labelled_by": library.labelled_by,
            "inputs": {outcome.clip.file: outcome.source_sha256 for outcome in outcomes},
        },
    )


def _prepare(config: StudyConfig, out: Path, progress: Progress) -> tuple[Body, PatchSet]:
    with progress.spinner("Placing patches on the body"):
        body = Body.bundled()
        patches = place_patches(body, config)
        body.save(out / WORK / "body.npz")
        patches.save(out / WORK / "patches.npz")
    return body, patches


def _bake(
    library: Library, config: StudyConfig, out: Path, workers: int, progress: Progress
) -> list[Outcome]:
    inputs = hashlib.sha256(
        b"".join((out / WORK / name).read_bytes() for name in ("body.npz", "patches.npz"))
        + repr(config.as_dict()).encode()
        + code_sha256().encode()
    ).hexdigest()
    jobs = [Job(clip, out, config, inputs) for clip in library.clips]
    n_workers = 1 if inside_blender() else min(workers, max(1, len(jobs)))
    parallel = joblib.Parallel(n_jobs=n_workers, return_as="generator", batch_size=BATCH)
    with progress.bar("Motions to signals", len(jobs)) as advance:
        outcomes = []
        for outcome in parallel(joblib.delayed(do_clip)(job) for job in jobs):
            outcomes.append(outcome)
            advance(1)
    return outcomes


def _rank(
    used: list[Clip], config: StudyConfig, out: Path, progress: Progress
) -> tuple[Recommendation, np.ndarray]:
    features, is_test, signatures = [], [], []
    for clip in used:
        with np.load(out / WORK / "features" / f"{clip.name}.npz", allow_pickle=False) as data:
            features.append(data["features"])
            is_test.append(data["is_test"])
            signatures.append(data["signature"])
    counts = [len(part) for part in is_test]
    groups = same_clips(
        [clip.name for clip in used], [clip.motion_key for clip in used], np.array(signatures)
    )
    group_names = np.array([used[np.flatnonzero(groups == group)[0]].name for group in groups])
    with progress.bar("Ranking places", 100) as advance:
        done = 0

        def told(fraction: float) -> None:
            nonlocal done
            advance(int(100 * fraction) - done)
            done = int(100 * fraction)

        try:
            recommendation = recommend(
                np.concatenate(features),
                np.repeat([clip.activity for clip in used], counts),
                np.repeat(group_names, counts),
                np.repeat([clip.subject for clip in used], counts),
                np.concatenate(is_test),
                config,
                told,
            )
        except ValueError as error:
            activities = Counter(clip.activity for clip in used)
            found = ", ".join(f"{name} ({count})" for name, count in sorted(activities.items()))
            raise StudyError(f"{error}. Clips used by activity: {found}") from error
    return recommendation, groups
