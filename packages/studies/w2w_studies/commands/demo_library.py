# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w demo-library`: W2W's own motion library, as FBX files like Mixamo's."""

import hashlib
import json
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Annotated, NamedTuple

import typer

from w2w.core.csv_tables import csv_text
from w2w.core.files import write_json, write_text
from w2w.core.findings.summary import versions
from w2w.headless.blender import needs_blender
from w2w.headless.commands.execute import refused
from w2w.headless.console import USAGE, Terminal
from w2w.headless.runs.monitor import RunMonitor
from w2w.headless.runs.own_files import ForeignFileError, check, claimed

from .. import rehab
from ..rehab.clips import RATE, generate_clip
from ..rehab.executions import WELL
from ..rehab.gestures import GESTURES

ACTIVITIES: tuple[str, ...] = tuple(GESTURES)
"""Activities of the library, each a folder of it."""

LABELS = "labels.csv"

MADE_BY = "made_by.json"
"""Beside a library that is whole: what made it."""


class Take(NamedTuple):
    """A clip to be made, and the file it goes into."""

    file: str
    activity: str
    number: int
    execution: str = WELL
    ages: tuple[float, float] | None = None


def demo_takes(clips: int) -> list[Take]:
    """Every gesture of so many people."""
    return [Take(_file(activity, n), activity, n) for activity in ACTIVITIES for n in range(clips)]


def write_demo_library(
    folder: str | Path,
    clips_per_activity: int = 12,
    seed: int = 0,
    progress: Callable[[int], None] | None = None,
) -> list[Path]:
    """Write a library of generated gestures at a desk.

    There is a folder an activity, with files named as Mixamo's
    (``shake_head/Shake Head (3).fbx``), and a ``labels.csv`` that also says who moves:
    clips of the same number are the same person. The same seed, with the same Blender,
    gives the same bytes; files of an earlier such library are replaced.

    `folder`: made if it does not exist.
    `progress`: called with 1 after every clip.
    Returns the FBX files in the order of `ACTIVITIES`.
    Raises ValueError if the number of clips is not positive or the seed is negative.
    Raises ForeignFileError if a file that W2W did not write has one of these names.
    """
    if clips_per_activity < 1:
        raise ValueError(f"a library needs at least one clip an activity, not {clips_per_activity}")
    return write_takes(Path(folder), demo_takes, clips_per_activity, seed, progress)


def write_takes(
    folder: Path,
    takes_of: Callable[[int], list[Take]],
    clips: int,
    seed: int,
    progress: Callable[[int], None] | None = None,
) -> list[Path]:
    """Write a library of generated clips and its labels.

    `folder`: made if it does not exist.
    `takes_of`: gives the takes of so many clips.
    `progress`: called with 1 after every clip.
    Raises ForeignFileError if a file that W2W did not write has one of the names.
    """
    with needs_blender():
        from ..rehab.mixamo_export import write_mixamo_fbx

    rows, paths = [], []
    with claimed(folder, [LABELS, *(take.file for take in takes_of(clips))]):
        for take in takes_of(clips):
            clip = generate_clip(take.activity, take.number, seed, RATE, take.execution, take.ages)
            path = folder / take.file
            path.parent.mkdir(parents=True, exist_ok=True)
            write_mixamo_fbx(clip, path)
            rows.append((take.file, take.activity, clip.subject))
            paths.append(path)
            if progress is not None:
                progress(1)
        write_text(folder / LABELS, csv_text([("file", "activity", "subject"), *rows]))
    return paths


def write_library_once(
    library: Path, takes_of: Callable[[int], list[Take]], clips: int, seed: int, monitor: RunMonitor
) -> None:
    """Write a library, unless an earlier run of the same code and seed finished it.

    Raises typer.Exit with the exit code, where a file that W2W did not write stands in the way.
    """
    made_by = {
        "clips": clips,
        "seed": seed,
        "code_sha256": generator_sha256(),
        "bpy": versions().get("bpy", ""),
    }
    stamp = library / MADE_BY
    with suppress(OSError, ValueError):
        if json.loads(stamp.read_text(encoding="utf-8")) == made_by:
            return
    takes = takes_of(clips)
    with refused(monitor):
        check(library, [MADE_BY, LABELS, *(take.file for take in takes)])
    stamp.unlink(missing_ok=True)
    with monitor.bar("writing the library", len(takes)) as advance:
        write_takes(library, takes_of, clips, seed, advance)
    with claimed(library, [MADE_BY]):
        write_json(stamp, made_by)


def generator_sha256() -> str:
    """Hash of the code that makes the motions."""
    files = sorted(Path(rehab.__file__).parent.glob("*.py"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest()


def demo_library(
    folder: Annotated[Path, typer.Argument(help="Where to write it.")],
    clips: Annotated[int, typer.Option(min=1, help="Clips an activity.")] = 12,
    seed: Annotated[int, typer.Option(min=0, help="The same seed gives the same library.")] = 0,
) -> None:
    """Write the built-in library of five gestures at a desk as FBX files.

    Its clips can be read by anything that reads Mixamo's. The motions of `w2w demo` were made from it.
    """
    console = Terminal()
    with RunMonitor(console).bar("writing the demo library", clips * len(ACTIVITIES)) as advance:
        try:
            paths = write_demo_library(folder, clips, seed, advance)
        except ForeignFileError as error:
            console.print(str(error), style="red")
            raise typer.Exit(USAGE) from error
    console.print(f"{len(paths)} clips and {LABELS} are in {folder}")


def _file(activity: str, number: int) -> str:
    return f"{activity}/{activity.replace('_', ' ').title()} ({number + 1}).fbx"
