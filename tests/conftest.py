# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures every test may use: the real data, the bundled body, a small skeleton motion."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import sys
from collections.abc import Callable
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # beside other workers a second thread only waits, busily

import numpy as np
import pytest
from filelock import FileLock
from hypothesis import settings
from scipy.spatial.transform import Rotation

from w2w.core.body.body import N_JOINTS, Body
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet, sample_patches

from .bits import comparing
from .made_motions import MadeClip, make_clips, write_files

settings.register_profile("everywhere", deadline=None)  # a busy machine is no failure
settings.register_profile("ci", deadline=None, derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "everywhere")

_ended: list[int] = []

gc.disable()  # until tests are collected


def pytest_collection_finish() -> None:
    """Spare each garbage collection from now on what has been imported and collected."""
    gc.collect()
    gc.freeze()
    gc.enable()


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Spare `-m bits` the import of modules that compare none."""
    if config.option.markexpr.startswith("bits") and collection_path.suffix == ".py":
        return not comparing(collection_path) or None
    return None


def pytest_itemcollected(item: pytest.Item) -> None:
    """Mark the tests that compare bits."""
    if getattr(item, "originalname", "") in comparing(item.path):
        item.add_marker("bits")


def pytest_sessionfinish(exitstatus: int) -> None:
    """Note with which status the tests end."""
    _ended.append(int(exitstatus))


@atexit.register  # early, so called late
def _leave() -> None:
    """End here where Blender is loaded: its own exit may wait for ever for a thread of its sounds."""
    if _ended and "bpy" in sys.modules:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(_ended[0])


SHARED_DATA = Path(os.environ.get("W2W_SHARED_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of real motions, recordings and bodies; tests that need it skip without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the real data folder ../shared/data is not here")
    return SHARED_DATA


@pytest.fixture(scope="session")
def shared_cases() -> Path:
    """Folder of small inputs that once went wrong; tests that need it skip without it."""
    if not (cases := SHARED_DATA.parent / "cases").is_dir():
        pytest.skip("the folder of odd inputs ../shared/cases is not here")
    return cases


@pytest.fixture(scope="session")
def made_once(tmp_path_factory) -> Callable[[str, Callable[[Path], object]], Path]:
    """Makes a folder once for all workers of pytest-xdist, by its name; tests only read it."""
    base = tmp_path_factory.getbasetemp()
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def folder_of(name: str, make: Callable[[Path], object]) -> Path:
        folder, finished = shared / name, shared / f"{name}.finished"
        with FileLock(shared / f"{name}.lock"):
            if not finished.exists():
                shutil.rmtree(folder, ignore_errors=True)  # of a worker that failed
                folder.mkdir()
                make(folder)
                finished.touch()
        return folder

    return folder_of


@pytest.fixture(scope="session")
def bundled_body() -> Body:
    """The body that comes with W2W."""
    return Body.bundled()


@pytest.fixture(scope="session")
def all_patches(made_once, bundled_body) -> PatchSet:
    """The bundled body's 512 patches, as many as the paper has."""

    def make(folder: Path) -> None:
        sample_patches(bundled_body, seed=0).save(folder / "patches.npz")

    return PatchSet.load(made_once("patches", make) / "patches.npz")


@pytest.fixture(scope="session")
def door(made_once, tmp_path_factory) -> Path:
    """A copy of a folder with MY_CLIPS, labels.csv and RESULTS, as the documents have them."""
    from .made_door import make_door  # the command line, which the environments of other programs lack

    return shutil.copytree(made_once("door", make_door), tmp_path_factory.mktemp("door") / "door")


@pytest.fixture(scope="session")
def made_files(made_once) -> tuple[Path, dict[str, MadeClip]]:
    """FBX and BVH files of known motion, as many kinds of rig hold them; what is in each."""
    pytest.importorskip("bpy")
    return made_once("made", write_files), make_clips()


@pytest.fixture
def waving() -> Motion:
    """Two seconds at 30 Hz in which every joint turns smoothly and the pelvis travels."""
    time = np.arange(60) / 30
    generator = np.random.default_rng(7)
    axes = generator.normal(size=(N_JOINTS, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    angles = 0.4 * np.sin(2 * np.pi * time[:, None] * generator.uniform(0.3, 1, N_JOINTS))
    rotations = Rotation.from_rotvec((angles[..., None] * axes).reshape(-1, 3)).as_matrix()
    pelvis = np.stack([time, 0.2 * np.sin(time), 1 + 0.1 * np.cos(3 * time)], axis=1)
    return Motion(rotations.reshape(60, N_JOINTS, 3, 3), pelvis, 30.0, "waving", "one", "clip")


@pytest.fixture
def torch():
    """PyTorch on one thread, where it is installed."""
    torch = pytest.importorskip("torch")
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield torch
    torch.set_num_threads(threads)
