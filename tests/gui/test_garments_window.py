# SPDX-License-Identifier: GPL-3.0-or-later
"""Garments in a real Blender window: clicked on and off, undone, and sensors baked on a T-shirt's cloth.

Needs what `test_window.py` needs; skips where one is missing.
"""

from __future__ import annotations

import shutil
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from w2w.core.body.body import JOINT_INDEX, N_JOINTS
from w2w.core.motion.motion import Motion

from .sandbox import RESULTS, inside, newest_zip, run_in_window

OUT = RESULTS / "garments"
FRAMES, RATE = 24, 30.0

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def report() -> dict[str, Any]:
    """What the window showed."""
    newest_zip()  # skips before a motion is made where the window cannot be tried
    shutil.rmtree(OUT, ignore_errors=True)
    (OUT / "clips" / "raising").mkdir(parents=True)
    move_arm().save(OUT / "clips" / "raising" / "raise.npz")
    return run_in_window("wear_garments.py", OUT, {"W2W_CLIPS": inside(OUT / "clips")})


def move_arm() -> Motion:
    """An arm lowered and raised in under a second: cloth takes minutes for every second."""
    angles = 0.9 * np.sin(np.linspace(0, np.pi, FRAMES))
    rotations = np.tile(np.eye(3), (FRAMES, N_JOINTS, 1, 1))
    rotations[:, JOINT_INDEX["right_shoulder"]] = Rotation.from_rotvec(
        angles[:, None] * [0.0, 1.0, 0.0]
    ).as_matrix()
    return Motion(rotations, np.tile([0.0, 0.0, 0.95], (FRAMES, 1)), RATE)


def test_a_click_puts_a_garment_on(report: dict[str, Any]) -> None:
    assert report["both"] == ["T-Shirt", "Trousers"]
    assert report["modifiers"] == ["ARMATURE", "CLOTH"]
    assert report["lies_on_body"]


def test_a_click_takes_one_off_and_undo_brings_it_back(report: dict[str, Any]) -> None:
    both, without = ["T-Shirt", "Trousers"], ["Trousers"]
    assert report["off_undo_redo_undo"] == [without, both, without, both]
    assert report["after_taking_off"] == ["T-Shirt"]
    assert report["in_the_scene"] == ["Body", "T-Shirt"]


def test_a_mesh_of_ones_own_is_worn_and_stays_when_it_is_taken_off(report: dict[str, Any]) -> None:
    assert report["with_bag"] == ["T-Shirt", "Bag"]
    assert report["without_bag"] == [["T-Shirt"], True]


def test_patches_under_the_shirt_are_baked_on_it(report: dict[str, Any]) -> None:
    ((is_baked, path),) = report["baked"]
    assert is_baked, path
    assert path.endswith("sensors are on T-Shirt")
    assert report["messages"][-1].startswith("Baked 1 clip on 64 spots")
