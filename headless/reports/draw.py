# SPDX-License-Identifier: GPL-3.0-or-later
"""Have Blender draw what a finished study looks like, in a worker process that may die of it.

Blender aborts the whole process where it cannot render: no result may be lost with it.
"""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from w2w.core.findings.finished_study import Study
from w2w.core.selection.subsets import Subset
from w2w.scene.output import output_to

from ..blender import forget_scripts_path
from ..needs_blender import NoBlenderError, missing_library
from ..runs.monitor import RunMonitor
from ..runs.own_files import claim, remove_claimed
from ..runs.picture_names import HEATMAPS, picture_files
from ..runs.workers import run_alone
from .pictures import BLEND, write_blend, write_pictures

POLL_S = 0.2
MAX_SAID = 300
"""Characters of Blender's last words that are shown."""


def draw_study(study: Study, monitor: RunMonitor) -> dict[str, str]:
    """Draw `heatmaps/*.png` and save `study.blend` in the folder of a study that is written down.

    Returns
    -------
    dict of str to str
        What could not be made, and why.
    """
    return draw_folder(study.results.out, study.advice.subset, study.results.utility.activities, monitor)


def draw_folder(out: Path, subset: Subset, activities: Sequence[str], monitor: RunMonitor) -> dict[str, str]:
    """As `draw_study`, for a results folder that holds all that is drawn but the set."""
    folder = out / HEATMAPS
    folder.mkdir(exist_ok=True)
    remove_claimed(out, HEATMAPS)
    files = picture_files(activities)
    claim(out, [f"{HEATMAPS}/{file}" for file in files])
    failed = {}
    pictures = [folder / file for file in files]
    with monitor.bar("drawing", len(files), "Drawing heatmaps") as advance, _counted(pictures, advance):
        failed[HEATMAPS] = draw_alone(write_pictures, out, subset)
    with monitor.step("drawing", f"Saving {BLEND}"):
        failed[BLEND] = draw_alone(write_blend, out, subset)
    if failed[BLEND]:
        (out / BLEND).unlink(missing_ok=True)  # one of an earlier run shows other results
    return {name: why for name, why in failed.items() if why}


def draw_alone(work: Callable[[Path, Subset], None], out: Path, subset: Subset) -> str:
    """Let Blender draw something in a worker process; says why where it could not, else is empty."""
    with tempfile.TemporaryDirectory(prefix="w2w_draw_") as folder:
        said = Path(folder) / "blender.txt"
        why = run_alone(_draw, work, out, subset, said)
        if why is not None:
            return why
        text = said.read_text(errors="replace") if said.exists() else ""
        last = " ".join(text.partition("Fatal Python error")[0].split())  # then come Python's own
        return missing_library(last) or f"Blender crashed; its last words: {last[-MAX_SAID:] or 'none'}"


def _draw(work: Callable[[Path, Subset], None], out: Path, subset: Subset, said: Path) -> str:
    """In the worker: do it, with what Blender prints kept for the case that the process dies."""
    forget_scripts_path()
    with output_to(said):
        try:
            work(out, subset)
        except (NoBlenderError, ValueError, OSError) as error:
            return str(error)
        except Exception as error:  # a fault of ours costs the picture, not the run
            return f"W2W failed on it, please report this: {type(error).__name__}: {error}"
    return ""


@contextmanager
def _counted(files: Sequence[Path], advance: Callable[[int], None]) -> Iterator[None]:
    """Move a bar by the files that another process has written."""
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
