# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw a finished study in worker processes: Blender, which saves its file, may crash."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from w2w.scene.output import output_to

from ..blender import NoBlenderError, forget_scripts_path
from ..runs.folder import HEATMAPS, picture_files
from ..runs.monitor import RunMonitor
from ..runs.own_files import claimed, remove_written
from ..runs.workers import run_side_by_side
from ..system_libraries import missing_library
from .pictures import BLEND, write_blend, write_pictures

POLL_S = 0.2
MAX_SAID = 300
"""Characters of Blender's last words that are shown."""

Draw = Callable[[Path], None]
"""Draws something of a results folder."""


def draw_folder(out: Path, activities: Sequence[str], monitor: RunMonitor) -> dict[str, str]:
    """Draw `heatmaps/*.png` and save `study.blend` in a folder of results; what failed, and why."""
    folder = out / HEATMAPS
    folder.mkdir(exist_ok=True)
    remove_written(out, lambda name: name.startswith(f"{HEATMAPS}/"))
    files = picture_files(activities)
    pictures = [folder / file for file in files]
    works = {HEATMAPS: write_pictures, BLEND: write_blend}
    title = f"Drawing heatmaps, saving {BLEND}"
    with (
        claimed(out, [f"{HEATMAPS}/{file}" for file in files]),
        monitor.bar("drawing", len(files), title) as advance,
        _counted(pictures, advance),
    ):
        failed = dict(zip(works, draw_side_by_side(list(works.values()), out), strict=True))
    if failed[BLEND]:
        (out / BLEND).unlink(missing_ok=True)  # one of an earlier run shows other results
    return {name: why for name, why in failed.items() if why}


def draw_alone(work: Draw, out: Path) -> str:
    """Draw in a worker process; why it failed, else empty."""
    return draw_side_by_side([work], out)[0]


def draw_side_by_side(works: Sequence[Draw], out: Path) -> list[str]:
    """As `draw_alone`, several at once, each in a worker process of its own."""
    with tempfile.TemporaryDirectory(prefix="w2w_draw_") as folder:
        said = [Path(folder) / f"blender_{number}.txt" for number in range(len(works))]
        calls = [partial(_draw, work, out, file) for work, file in zip(works, said, strict=True)]
        found = run_side_by_side(calls)
        return [_crash(file) if why is None else why for why, file in zip(found, said, strict=True)]


def _crash(said: Path) -> str:
    """Why Blender crashed, by what it printed."""
    text = said.read_text(errors="replace") if said.exists() else ""
    last = " ".join(text.partition("Fatal Python error")[0].split())  # then come Python's own
    return missing_library(last) or f"Blender crashed; its last words: {last[-MAX_SAID:] or 'none'}"


def _draw(work: Draw, out: Path, said: Path) -> str:
    """Draw, in the worker; what Blender prints is kept in case the process dies."""
    forget_scripts_path()
    with output_to(said):
        try:
            work(out)
        except (NoBlenderError, ValueError, OSError) as error:
            return str(error)
        except Exception as error:  # a fault of ours costs the picture, not the run
            return f"W2W failed on it, please report this: {type(error).__name__}: {error}"
    return ""


@contextmanager
def _counted(files: Sequence[Path], advance: Callable[[int], None]) -> Iterator[None]:
    """Move a progress bar by the files that another process has written."""
    done, over = 0, threading.Event()

    def count() -> None:
        nonlocal done
        while not over.wait(POLL_S):
            found = sum(file.exists() for file in files)
            advance(found - done)
            done = found

    counter = threading.Thread(target=count)
    counter.start()
    try:
        yield
    finally:
        over.set()
        counter.join()
