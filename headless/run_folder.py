# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders of a run: made before it, and rid of what earlier runs left."""

from __future__ import annotations

from pathlib import Path

from .clip_files import WORK

FOLDERS = ("motions", "signals", *(f"{WORK}/{name}" for name in ("features", "copies", "clips", "running")))
"""What a run writes clips into."""


def make_folders(out: Path) -> None:
    """Make the output folder."""
    for folder in FOLDERS:
        (out / folder).mkdir(parents=True, exist_ok=True)


def forget_running(out: Path) -> None:
    """Forget which clips a run that was killed was at."""
    for marker in (out / WORK / "running").iterdir():
        marker.unlink(missing_ok=True)


def remove_leftovers(out: Path, used: set[str]) -> None:
    """Remove what an earlier run of another library left: the folder holds this study alone."""
    for folder in (out / "motions", out / "signals", out / WORK / "features"):
        for path in folder.glob("*.npz"):
            if path.stem not in used:
                path.unlink()
    for path in (out / WORK / "copies").glob("*.npz"):
        if path.stem.rpartition(".")[0] not in used:
            path.unlink()
    for folder in (out, *(out / name for name in (*FOLDERS, "heatmaps", WORK))):
        for path in folder.glob(".*.part"):  # half a file, of a run that was killed while it wrote
            path.unlink(missing_ok=True)
