# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished results folder without baking anything: drawn features, everything after them real."""

from __future__ import annotations

import os
from collections.abc import Iterator
from concurrent.futures import BrokenExecutor
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from loky import ProcessPoolExecutor, process_executor
from scipy.spatial.transform import Rotation

from w2w.core import study
from w2w.core.body.skeleton import N_JOINTS
from w2w.core.clip_ranking import LabelledClip
from w2w.core.findings.summary import write_results
from w2w.core.motion.library import Clip, Library
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.halves import Protocol
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.results_folder import ClipResult, Study, StudyResults
from w2w.core.selection.advice import advise
from w2w.core.selection.set_tests import SetTests
from w2w.core.study import StudyConfig
from w2w.headless.runs import workers
from w2w.headless.runs.folder import make_folders
from w2w.headless.runs.guard import end_with
from w2w.headless.runs.study import write_config


class _Pool:
    """A worker process that stays; a new one where it died."""

    def __init__(self) -> None:
        self._pools = []
        self._start()

    def _start(self) -> None:
        self._pools.append(ProcessPoolExecutor(1, initializer=end_with, initargs=(os.getpid(),)))
        # it would go as soon as it had loaded Blender, which loky takes for a memory leak
        self._pools[-1].submit(setattr, process_executor, "_USE_PSUTIL", False)

    def submit(self, work, *args):
        try:
            self._pools[-1].submit(os.chdir, Path.cwd())
        except BrokenExecutor:
            self._start()
            self._pools[-1].submit(os.chdir, Path.cwd())
        return self._pools[-1].submit(work, *args)

    def shutdown(self, **_) -> None:
        for pool in self._pools:
            pool.shutdown(kill_workers=True)


@pytest.fixture(scope="module")
def one_worker() -> Iterator[None]:
    """All clips of a module are worked on by one worker process: a new one takes seconds to start."""
    pool = _Pool()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workers, "local_executor", lambda _: nullcontext(pool))
        yield
    pool.shutdown()


@pytest.fixture(scope="session", autouse=True)
def placed_once() -> Iterator[None]:
    """The same patches on the same body are placed once in this process: it takes a second or more."""
    placed = {}

    def place(body, n, seed):
        key = (body.vertices.tobytes(), n, seed)
        if key not in placed:
            placed[key] = sample_patches(body, n, seed)
        return placed[key]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "sample_patches", place)
        yield


HOSTILE = '<script>alert(1)</script> & "walk"</script><!--'
ACTIVITIES = (HOSTILE, "arm_raise", "sitting")
CLIPS, WINDOWS, PLACES = 6, 4, 48


@pytest.fixture(scope="session")
def drawn_results(bundled_body, tmp_path_factory) -> Path:
    """Results of a study whose 'arm_raise' is told best on the left arm; one label would break a page."""
    return _drawn(bundled_body, tmp_path_factory.mktemp("drawn") / "out", dict.fromkeys(ACTIVITIES, CLIPS))


@pytest.fixture(scope="session")
def sparse_results(bundled_body, tmp_path_factory) -> Path:
    """Results of a study with a title, an activity of two clips and two that cannot be ranked."""
    clips = {"arm_raise": 6, "sitting": 6, "jump": 2, "bow": 1, "kneel": 1}
    return _drawn(bundled_body, tmp_path_factory.mktemp("sparse") / "out", clips, "Smart <b>shirt</b>")


def _drawn(body, out: Path, clips_of: dict[str, int], project: str = "") -> Path:
    make_folders(out)
    config = StudyConfig(patches=PLACES, seed=3, title=project)
    patches = sample_patches(body, PLACES, seed=3)
    body.save(out / ".w2w" / "body.npz")
    patches.save(out / ".w2w" / "patches.npz")
    labels = [activity for activity, count in clips_of.items() for _ in range(count)]
    clips = tuple(
        Clip(Path(f"/{number}.fbx"), f"{activity[:4]}/{number}.fbx", f"clip_{number}", activity)
        for number, activity in enumerate(labels)
    )
    skipped = (("<img src=x onerror=alert(2)>.fbx", "empty <b>file</b>"),)
    library = Library(Path("/library"), clips, "folder names", skipped)
    activity = np.repeat([clip.activity for clip in clips], WINDOWS)
    clip = np.repeat([clip.name for clip in clips], WINDOWS)
    is_test = np.ones(len(activity), bool)
    strength = 0.1 + 0.9 * np.exp(-((body.vertices[patches.vertices, 0] - 0.5) ** 2) / 0.1)
    features = np.random.default_rng(5).normal(size=(len(activity), PLACES, 6)).astype(np.float32)
    for number, name in enumerate(clips_of):
        features[activity == name, :, number] += 3 * strength
    pooling = Pooling.on(body, patches)
    protocol = Protocol(activity, clip, None, is_test, sorted(clips_of), seed=3)
    utility = utility_map(features, protocol, pooling=pooling)
    details = {"windows": WINDOWS, "frames": 120, "duration_s": 4.0}
    ranked = tuple(LabelledClip(clip.name, clip.activity, clip.subject, clip.name) for clip in clips)
    tests = SetTests.of(features, protocol, pooling)
    drawn = Study(
        library,
        config,
        body,
        tuple(ClipResult(clip, "", details, "0" * 64) for clip in clips),
        StudyResults(out, utility, patches, ranked, config.as_dict()),
        advise(utility, patches, body, tests, config.target, max_places=5),
    )
    write_results(drawn)
    write_config(drawn)
    return out


@pytest.fixture
def motions(tmp_path) -> Path:
    """A library of eight npz motions, four of each of two activities: none needs Blender to be read."""
    library, time = tmp_path / "motions", np.arange(150) / 30
    for activity, pace in (("slow", 0.5), ("fast", 2.0)):
        (library / activity).mkdir(parents=True)
        for number in range(4):
            axes = np.random.default_rng(number).normal(size=(N_JOINTS, 3)) / 5
            angles = np.sin(2 * np.pi * pace * (1 + number / 20) * time)
            turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
            pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
            motion = Motion(turns.reshape(-1, N_JOINTS, 3, 3), pelvis, 30.0, activity, "", f"clip_{number}")
            motion.save(library / activity / f"{activity}_{number}.npz")
    return library
