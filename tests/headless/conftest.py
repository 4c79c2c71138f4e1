# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished results folder without baking anything: drawn features, everything after them real."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from dataclasses import fields
from functools import cache, lru_cache, partial
from pathlib import Path

import numpy as np
import pytest
import typer.testing
from jinja2 import Environment, FileSystemBytecodeCache
from scipy.spatial.transform import Rotation
from typer.main import get_command

from w2w.core.body.body import N_JOINTS, Body
from w2w.core.findings.summary import write_results
from w2w.core.library.library import Clip, Library
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.halves import CrossValidation
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import utility_map
from w2w.core.selection.advice import advise
from w2w.core.selection.scored import ScoredMap
from w2w.core.selection.set_tests import SetTests
from w2w.core.study import signals
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import LabelledClip
from w2w.core.study.results import ClipResult, Study, StudyResults
from w2w.drawing import heatmap
from w2w.drawing.body import BodyPictures
from w2w.headless.runs.folder import make_folders
from w2w.headless.runs.study import write_config
from w2w.report import page

from ..command_line import cli
from ..here import CAREFULLY, clips_here, ranked_roughly


@pytest.fixture(scope="module")
def one_worker(made_once_here) -> Iterator[None]:  # noqa: ARG001
    """All clips of a module are worked on in the tests' own process: a worker takes seconds to start."""
    with clips_here():
        yield


@pytest.fixture(scope="session")
def dear(tmp_path_factory) -> dict:
    """What is dear and the same each time, made once in this process for the modules that ask for it."""
    return {
        "placed": {},
        "bodies": {},
        "shaded": lru_cache(maxsize=4)(BodyPictures),
        "templates": FileSystemBytecodeCache(str(tmp_path_factory.mktemp("templates"))),
        "commands": cache(get_command),
    }


@pytest.fixture(scope="module")
def made_once_here(dear) -> Iterator[None]:
    """A module's commands take from what is `dear`, instead of W2W's own functions.

    Patches on a body, its segments (kept by W2W for a body that is the same object) and shading, the page's
    template, the tree of commands.
    """
    placed, bodies, load = dear["placed"], dear["bodies"], Body.load

    def place(body, n, seed):
        key = (body.vertices.tobytes(), n, seed)
        if key not in placed:
            placed[key] = sample_patches(body, n, seed)
        return placed[key]

    def kept(path):
        body = load(path)
        parts = (vars(body)[field.name] for field in fields(body))
        return bodies.setdefault(tuple(np.array(part).tobytes() for part in parts), body)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(signals, "sample_patches", place)
        patch.setattr(Body, "load", staticmethod(kept))
        patch.setattr(page, "BodyPictures", dear["shaded"])
        patch.setattr(heatmap, "BodyPictures", dear["shaded"])
        patch.setattr(page, "Environment", partial(Environment, bytecode_cache=dear["templates"]))
        patch.setattr(typer.testing, "_get_command", dear["commands"])
        yield


@pytest.fixture(scope="module")
def few_orders() -> Iterator[None]:
    """A module's rankings made roughly (`here.ROUGHLY`): tests that rank with all care are the core's."""
    with ranked_roughly():
        yield


@pytest.fixture
def all_orders(monkeypatch) -> None:
    """Ranked with all care, as by a program of its own, whose results are compared."""
    for there in CAREFULLY:
        monkeypatch.setattr(*there)


QUICKLY = (
    *("--patches", "6", "--workers", "1", "--no-pictures"),
    *("--folds", "2", "--max", "1", "--window", "1"),
)
HOSTILE = '<script>alert(1)</script> & "walk"</script><!--'
ACTIVITIES = (HOSTILE, "arm_raise", "sitting")
CLIPS, WINDOWS, PLACES = 6, 4, 48


@pytest.fixture(scope="session")
def drawn(made_once, bundled_body) -> Path:
    """Two studies whose features are drawn, on the same patches."""

    def make(folder: Path) -> None:
        clips = {"arm_raise": 6, "sitting": 6, "jump": 2, "bow": 1, "kneel": 1}
        with ranked_roughly():
            _drawn(bundled_body, folder / "plain", dict.fromkeys(ACTIVITIES, CLIPS))
            _drawn(bundled_body, folder / "sparse", clips, "Smart <b>shirt</b>")

    return made_once("drawn", make)


@pytest.fixture(scope="session")
def drawn_results(drawn, tmp_path_factory) -> Path:
    """Results of a study whose 'arm_raise' is told best on the left arm; one label would break a page."""
    return shutil.copytree(drawn / "plain", tmp_path_factory.mktemp("drawn") / "out")


@pytest.fixture(scope="session")
def sparse_results(drawn, tmp_path_factory) -> Path:
    """Results of a study with a title, an activity of two clips and two that cannot be ranked."""
    return shutil.copytree(drawn / "sparse", tmp_path_factory.mktemp("sparse") / "out")


def _drawn(body, out: Path, clips_of: dict[str, int], project: str = "") -> Path:
    make_folders(out)
    config = StudyConfig(patches=PLACES, seed=3, title=project)
    patches = signals.sample_patches(body, PLACES, seed=3)
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
    protocol = CrossValidation(activity, clip, None, is_test, sorted(clips_of), seed=3)
    utility = utility_map(features, protocol, pooling=pooling)
    details = {"windows": WINDOWS, "frames": 120, "duration_s": 4.0}
    ranked = tuple(LabelledClip(clip.name, clip.activity, clip.subject, clip.name) for clip in clips)
    tests = SetTests.of(features, protocol, pooling)
    drawn = Study(
        library,
        config,
        body,
        tuple(ClipResult(clip, "", details, "0" * 64) for clip in clips),
        StudyResults(out, patches, ranked, config.as_dict(), utility),
        advise(ScoredMap(utility, patches, body), tests, config.target, max_places=3),
    )
    write_results(drawn)
    write_config(drawn)
    return out


@pytest.fixture
def motions(made_once, tmp_path) -> Path:
    """A library of eight npz motions, four of each of two activities: none needs Blender to be read."""
    made = made_once(
        "motions", lambda folder: write_motions(folder / "motions", {"slow": 0.5, "fast": 2.0}, 4)
    )
    return shutil.copytree(made / "motions", tmp_path / "motions")


@pytest.fixture(scope="session")
def quick_run(made_once) -> Path:
    """A folder with eight motions in `library` and their results, ranked by `QUICKLY`, in `out`."""

    def make(folder: Path) -> None:
        write_motions(folder / "library", {"slow": 0.5, "fast": 2.0}, 4)
        with clips_here(), ranked_roughly():
            code, said = cli("run", folder / "library", "--out", folder / "out", *QUICKLY)
        assert code == 0, said

    return made_once("quick run", make)


PACES = {"slow": 0.5, "steady": 1.0, "fast": 2.0}
"""Activities of a small run, each at its pace, in hertz."""


def run_paces(patches: int, folder: Path) -> None:
    """A run of four clips an activity, in `folder` / "out"."""
    write_motions(folder / "library", PACES, 4)
    options = ("--patches", patches, "--no-pictures", "--workers", 1, "--max", 1)
    code, output = cli("run", folder / "library", "--out", folder / "out", *options)
    assert code == 0, output


def write_motions(library: Path, paces: dict[str, float], clips: int) -> None:
    """Motions of 5 s that swing all joints, at each activity's pace (in hertz) and each clip's own way."""
    time = np.arange(150) / 30
    for activity, pace in paces.items():
        (library / activity).mkdir(parents=True)
        for number in range(clips):
            axes = np.random.default_rng(number).normal(size=(N_JOINTS, 3)) / 5
            angles = np.sin(2 * np.pi * pace * (1 + number / 20) * time)
            turns = Rotation.from_rotvec((angles[:, None, None] * axes).reshape(-1, 3)).as_matrix()
            pelvis = np.stack([time / 5, 0 * time, np.ones_like(time)], axis=1)
            motion = Motion(turns.reshape(-1, N_JOINTS, 3, 3), pelvis, 30.0, activity, "", f"clip_{number}")
            motion.save(library / activity / f"{activity}_{number}.npz")
