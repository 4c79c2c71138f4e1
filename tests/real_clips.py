# SPDX-License-Identifier: GPL-3.0-or-later
"""Libraries of Mixamo's real clips: activities by folder, or by a csv."""

import csv
import shutil
from collections.abc import Mapping
from pathlib import Path

FOUR = {
    "Conqster__TheBarMan/Walking.fbx": "walking",
    "M3-org__CharacterStudio/StrutWalking.fbx": "walking",
    "lmf-git__godotphysxanimatios-ragdoll-obstaclecollisions/Run.fbx": "running",
    "kirbycope__godot-4.3-sandbox-3d/Running_InPlace.fbx": "running",
}
"""File and activity of two clips of each of two activities."""


def in_folders(shared_data: Path, folder: Path) -> Path:
    """Write the four clips to folders that label them; returns the library."""
    for file, activity in FOUR.items():
        (folder / activity).mkdir(parents=True, exist_ok=True)
        shutil.copy(shared_data / "mixamo" / file, folder / activity)
    return folder


def under_csv(shared_data: Path, folder: Path, clips: Mapping[str, str] = FOUR) -> Path:
    """Write clips as they lie, and a labels.csv; returns the library."""
    for file in clips:
        (folder / file).parent.mkdir(exist_ok=True)
        shutil.copy(shared_data / "mixamo" / file, folder / file)
    with (folder / "labels.csv").open("w", newline="") as stream:
        csv.writer(stream).writerows([("file", "activity"), *clips.items()])
    return folder
