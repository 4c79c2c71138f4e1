# SPDX-License-Identifier: GPL-3.0-or-later
"""A registered extension in an empty file, and a small library of motions made from sines."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import bpy
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import w2w as extension
from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion
from w2w.ui.jobs import preferences
from w2w.ui.study import signal_cache, state

from ..here import ranked_roughly
from ..made_run import make_run
from .made_study import N_PATCHES

bpy.ops.preferences.addon_disable(module="cycles")  # it looks through every file that is opened
MOVES = {"waving": ("right_shoulder", 1.0), "kicking": ("left_hip", 1.0), "stepping": ("right_knee", 0.8)}
"""Joint that each activity turns, and how far, radians."""


@pytest.fixture(scope="module")
def few_orders() -> Iterator[None]:
    """A module's rankings made roughly: tests that rank with all care are the core's."""
    with ranked_roughly():
        yield


@pytest.fixture(scope="package")
def registered() -> Iterator[None]:
    """The extension, registered once: as in Blender, files come and go meanwhile."""
    extension.register()
    yield
    extension.unregister()


@pytest.fixture
def blender(
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
    registered: None,  # noqa: ARG001
) -> None:
    """An empty file with the extension registered and a cache of its own."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)  # which leaves add-ons alone
    folders = {name: tmp_path_factory.mktemp(name) for name in ("signals", "bone_maps")}
    monkeypatch.setattr(preferences, "own_folder", folders.__getitem__)
    signal_cache._recordings.clear()
    monkeypatch.setattr(state, "GLANCE", -1.0)  # what changes is looked at again at once


@pytest.fixture(scope="session")
def library(made_once: Callable[..., Path]) -> Path:
    """Three motions of each of three activities, in folders by activity."""
    return made_once("library", _write_library)


def _write_library(folder: Path) -> None:
    generator = np.random.default_rng(3)
    time = np.arange(90) / 30
    for activity, (joint, amplitude) in MOVES.items():
        (folder / activity).mkdir()
        for number in range(3):
            speed, size = generator.uniform(0.7, 1.3, 2)
            angles = amplitude * size * np.sin(2 * np.pi * speed * time + generator.uniform(0, 6))
            rotations = np.tile(np.eye(3), (len(time), N_JOINTS, 1, 1))
            turns = Rotation.from_rotvec(angles[:, None] * [1.0, 0.2, 0.0]).as_matrix()
            rotations[:, JOINT_INDEX[joint]] = turns
            sway = 0.02 * np.sin(2 * np.pi * generator.uniform(0.5, 1) * time)
            pelvis = np.column_stack([sway, np.zeros_like(sway), np.full_like(sway, 0.95)])
            Motion(rotations, pelvis, 30.0).save(folder / activity / f"{activity} {number}.npz")


@pytest.fixture(scope="package")
def finished_run(shared_data: Path, made_once: Callable[..., Path]) -> Path:
    """The results folder of a run over real BVH clips and a broken one, ranked roughly."""

    def make(folder: Path) -> None:
        with ranked_roughly():
            make_run(shared_data, folder, N_PATCHES, "--no-report")

    return made_once("overnight", make) / "results"


@pytest.fixture
def summary(finished_run: Path) -> dict:
    """What the run's summary says."""
    return json.loads((finished_run / "summary.json").read_text())
