# SPDX-License-Identifier: GPL-3.0-or-later
"""The folders of a run: made before it, and rid of what earlier runs left."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from blender_addon.w2w.core.files import UNFINISHED
from blender_addon.w2w.core.library import Library

from .clip_files import WORK
from .own_files import claim, files_of_record, json_content, note, remove_own
from .picture_names import HEATMAPS, picture_files

FOLDERS = ("motions", "signals", *(f"{WORK}/{name}" for name in ("features", "copies", "clips", "running")))
"""What a run writes clips into."""

TABLES = ("config.json", "utility.npz", "utility.csv", "summary.json")


def make_folders(out: Path) -> None:
    """Make the output folder."""
    for folder in FOLDERS:
        (out / folder).mkdir(parents=True, exist_ok=True)


@contextmanager
def own_results(out: Path, library: Library, more: Sequence[str], pictures: bool) -> Iterator[None]:
    """Claim the names that a run writes under, and note at its end what it wrote.

    Parameters
    ----------
    out : Path
    library : Library
    more : sequence of str
        What it writes beside the tables.
    pictures : bool
        Whether it draws heatmaps; their names are claimed when they are drawn.

    Raises
    ------
    ForeignFileError
        If a file that W2W did not write stands at one of them.
    """
    clips = [name for clip in library.clips for name in _not_recorded(out, clip.name)]
    drawn = [f"{HEATMAPS}/{file}" for file in picture_files(list(library.activities)) if pictures]
    claim(out, [*TABLES, *more], [*drawn, *clips])
    try:
        yield
    finally:
        with suppress(OSError):  # a full disk: what is claimed stays ours
            note(out)


def forget_running(out: Path) -> None:
    """Forget which clips a run that was killed was at."""
    for marker in (out / WORK / "running").iterdir():
        marker.unlink(missing_ok=True)


def remove_leftovers(out: Path, used: set[str]) -> None:
    """Remove what an earlier run of another library left: the folder holds this study alone.

    Of motions and signals only what a record of ours names and nobody has changed since; the
    work folder is all ours.
    """
    for record in (out / WORK / "clips").glob("*.json"):
        files = {} if record.stem in used else files_of_record(record)
        if files:
            remove_own(out, files)
            record.unlink()
    for path in (out / WORK / "features").glob("*.npz"):
        if path.stem not in used:
            path.unlink()
    for path in (out / WORK / "copies").glob("*.npz"):
        if path.stem.rpartition(".")[0] not in used:
            path.unlink()
    remove_unfinished(out)


def remove_unfinished(out: Path) -> None:
    """Remove half-written files of a run that was killed while it wrote."""
    for folder in (out, *(out / name for name in (*FOLDERS, HEATMAPS, WORK))):
        for path in folder.glob(f".*{UNFINISHED}"):
            if path.is_dir():
                shutil.rmtree(path)
            else:
                path.unlink(missing_ok=True)


def _not_recorded(out: Path, clip: str) -> list[str]:
    """Where a clip's motion and recording go, unless its record says that we wrote there."""
    record = out / WORK / "clips" / f"{clip}.json"
    if record.exists() and json_content(record) is None:
        return []  # damaged, but ours
    recorded = files_of_record(record)
    names = (f"motions/{clip}.npz", f"signals/{clip}.npz")
    return [name for name in names if name not in recorded]
