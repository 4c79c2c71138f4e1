# SPDX-License-Identifier: GPL-3.0-or-later
"""The maps of a sweep: a finished study's motions recorded and ranked again, case by case."""

import hashlib
import json
import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, cached_property
from itertools import starmap
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.body.shapes import shaped
from w2w.core.files import write_json
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, inputs_of
from w2w.core.study.clip_files import (
    WORK,
    ClipWindows,
    features_file,
    motion_file,
    ranking_inputs,
    write_features,
)
from w2w.core.study.config import plain
from w2w.core.study.ranking import LabelledClip, rank_clips
from w2w.core.study.results import StudyResults
from w2w.core.study.signals import describe, place_patches, simulate
from w2w.core.threads import unthreaded_products
from w2w.core.windows.windows import TooShortError
from w2w.headless.blender import inside_blender
from w2w.headless.runs.folder import results_made_by
from w2w.headless.runs.workers import local_executor
from w2w.headless.stopping import deaf_children

from .cases import Case


class SweepMaps:
    """Makes the maps of a sweep, and takes up those that an earlier sweep made.

    `out`: folder of the sweep.
    `n_patches`: patches compared; they are the first ones of the study's own order, which cover the body
    evenly.
    Raises ValueError if the study's classifier takes windows instead of features.
    """

    def __init__(self, study: StudyResults, out: Path, n_patches: int, workers: int) -> None:
        self.study, self.out, self.workers = study, out, workers
        config = study.config()
        if inputs_of(config.classifier) != "features":
            raise ValueError(
                f"a sweep ranks by features; the study's classifier, {config.classifier}, does not"
            )
        self.patches = study.patches
        if n_patches < len(study.patches):
            self.patches = place_patches(Body.bundled(), replace(config, patches=n_patches))
            if not np.array_equal(self.patches.vertices, study.patches.vertices[:n_patches]):
                self.patches = place_patches(study.body(), replace(config, patches=n_patches))
        (out / WORK / "features").mkdir(parents=True, exist_ok=True)
        self.patches.save(out / WORK / "patches.npz")

    @cached_property
    def pooling(self) -> Pooling:
        """Over the skin of the study's body, whatever body a case is recorded on."""
        return Pooling.on(self.study.body(), self.patches)

    def map_of(self, case: Case, told: Callable[[int], None]) -> UtilityMap:
        """The map of a case.

        `told`: given 1 after every clip.
        """
        key = self._key(case)
        stored = self.out / WORK / f"map_{key[:16]}.npz"
        if stored.exists():
            told(len(self.study.clips))
            return UtilityMap.load(stored)
        folder = self.out / WORK / key[:16]
        (folder / WORK / "features").mkdir(parents=True, exist_ok=True)
        self._body(case).save(folder / WORK / "body.npz")
        try:
            used = self._bake(case, folder, told)
            utility = self._rank(case, used, folder)
        finally:
            shutil.rmtree(folder)
        utility.save(stored)
        write_json(stored.with_suffix(".json"), plain(case))
        return utility

    def _key(self, case: Case) -> str:
        parts = [
            json.dumps(plain(case), sort_keys=True),
            (self.study.out / "config.json").read_text(encoding="utf-8"),
            str(len(self.patches)),
            results_made_by(),
        ]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()

    def _body(self, case: Case) -> Body:
        if not case.shape:
            return self.study.body()
        return shaped(Body.bundled(), **dict(case.shape))

    def _bake(self, case: Case, folder: Path, told: Callable[[int], None]) -> list[LabelledClip]:
        patches = self.out / WORK / "patches.npz"
        usual_height = self.study.body().height
        calls = [(case, clip, self.study.out, folder, patches, usual_height) for clip in self.study.clips]
        used = []
        for clip, done in zip(self.study.clips, self._in_workers(calls), strict=True):
            told(1)
            if done:
                used.append(clip)
        return used

    def _in_workers(self, calls: list[tuple]) -> Iterator[bool]:
        """What `_bake_clip` gives, call by call."""
        if self.workers == 1 and not inside_blender():
            yield from starmap(_bake_clip, calls)
            return
        with local_executor(min(self.workers, len(calls))) as executor:
            with deaf_children():
                baked = [executor.submit(_bake_clip, *call) for call in calls]
            yield from (future.result() for future in baked)

    def _rank(self, case: Case, clips: list[LabelledClip], folder: Path) -> UtilityMap:
        places = [(folder, clip.name) for clip in clips]
        found = [ClipWindows.read(*place) for place in places]
        inputs = ranking_inputs(places, found, case.config.classifier, case.config.windows)
        return rank_clips(clips, found, inputs, case.config, self.pooling)


def _bake_clip(
    case: Case, clip: LabelledClip, study: Path, folder: Path, patches: Path, usual_height: float
) -> bool:
    """Write the features of a clip under a case; False where it is too short for its windows."""
    body, placed = _load(folder / WORK / "body.npz", patches)
    motion = case.motion(Motion.load(motion_file(study, clip.name)))
    motion = replace(motion, pelvis=motion.pelvis * (body.height / usual_height))
    with unthreaded_products():
        try:
            features, is_test = describe(simulate(body, placed, motion, case.config), case.config)
        except TooShortError:
            return False
    write_features(features_file(folder, clip.name), features, is_test, np.zeros(0))
    return True


@cache
def _load(body: Path, patches: Path) -> tuple[Body, PatchSet]:
    return Body.load(body), PatchSet.load(patches)
