# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps and Blender file of a finished study, made in worker processes: Blender may crash as it saves."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ...core.colours import Scale
from ...core.files import folder_beside
from ...core.reading.guard import output_to
from ...core.selection.headline import doubted, mean_title
from ...core.selection.scored import best_single
from ...core.study.results import StudyResults
from ...core.wording import capital, count
from ..blender import NoBlenderError, needs_blender
from ..runs.folder import HEATMAPS, MEAN, SUBSET, picture_files, picture_names
from ..runs.monitor import RunMonitor
from ..runs.own_files import move_in, remove_written
from ..runs.workers import run_side_by_side
from ..system_libraries import missing_library

if TYPE_CHECKING:
    import numpy as np

    from ...drawing.body import BodyPictures  # Pillow is slow to import

BLEND = "study.blend"

EXPECTED = "Expected F1"
"""Quantity that the colours of every heatmap show."""

MAX_LISTED = 12
"""Sensors that fit next to the picture; the summary lists all."""

MAX_SAID = 300
"""Characters of Blender's last words that are shown."""


def draw_folder(out: Path, activities: Sequence[str], monitor: RunMonitor) -> dict[str, str]:
    """Draw `heatmaps/*.png` and save `study.blend` in a folder of results; what failed, and why."""
    files = picture_files(activities)
    title = f"Drawing heatmaps, saving {BLEND}"
    with folder_beside(out / HEATMAPS) as temporary:
        (new := Path(temporary, HEATMAPS)).mkdir()
        works = {
            HEATMAPS: partial(write_pictures, to=new.parent), BLEND: partial(write_blend, to=new.parent),
        }  # fmt: skip
        pictures = [new / file for file in files]
        with monitor.bar("drawing", len(files), title) as advance, _counted(pictures, advance):
            failed = dict(zip(works, draw_side_by_side(list(works.values()), out), strict=True))
        drawn = {*move_in(out, new.parent)}
    # those of an earlier run show other results
    remove_written(out, lambda name: name not in drawn and name.startswith((f"{HEATMAPS}/", BLEND)))
    return {name: why for name, why in failed.items() if why}


def draw_side_by_side(works: Sequence[Callable[[Path], None]], out: Path) -> list[str]:
    """Draw, each in a worker process of its own; returns why each failed, or ""."""
    with tempfile.TemporaryDirectory(prefix="w2w_draw_") as folder:
        printed = [Path(folder) / f"blender_{number}.txt" for number in range(len(works))]
        calls = [partial(_draw, work, out, file) for work, file in zip(works, printed, strict=True)]
        reasons = run_side_by_side(calls)
        return [_crash(file) if why is None else why for why, file in zip(reasons, printed, strict=True)]


def _crash(printed: Path) -> str:
    """The reason of a crash of Blender, from its output."""
    text = printed.read_text(errors="replace") if printed.exists() else ""
    last = " ".join(text.partition("Fatal Python error")[0].split())  # then come Python's own
    return missing_library(last) or f"Blender crashed; its last words: {last[-MAX_SAID:] or 'none'}"


def _draw(work: Callable[[Path], None], out: Path, printed: Path) -> str:
    """Draw, in the worker; what Blender prints is written to a file in case the process dies."""
    with output_to(printed):
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
    over = threading.Event()

    def count() -> None:
        done = 0
        while not over.wait(0.2):
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


def write_pictures(out: Path, to: Path) -> None:
    """Draw `heatmaps/*.png` of a finished study, one for each activity, the mean and the set, in a folder."""
    from ...drawing.body import BodyPictures, size_for
    from ...drawing.heatmap import VIEW_PIXELS, heatmap_figure  # matplotlib is slow to import

    study = StudyResults.load(out, by=None)
    utility = study.utility
    titles = [name.replace("_", " ").capitalize() for name in utility.activities]
    best = [int(scores.argmax()) for scores in utility.expected_f1.T]
    maps = [*zip(picture_names(utility.activities), titles, utility.expected_f1.T, best, strict=True)]
    allowed = study.config().constraints.terms(study.patches).allowed
    maps.append((MEAN, mean_title(utility), utility.expected_mean, best_single(utility, allowed)))
    body = study.body()
    shaded = BodyPictures(body, size_for(body, VIEW_PIXELS - 3))  # soft edges may take three more
    with ThreadPoolExecutor(1) as pages:  # the next body is coloured while the last one's page is made
        drawn = []
        for name, title, scores, spot in maps:
            scale = Scale.of(scores, title=EXPECTED)
            views = shaded.coloured(scale.colours(study.patches, scores))
            best_spot = f"Best spot: {study.patches.names[spot]} ({scores[spot]:.2f} on other clips)"
            subtitle = doubted(utility, best_spot)
            path = to / HEATMAPS / f"{name}.png"
            drawn.append(pages.submit(heatmap_figure, path, views, title, scale, subtitle))
        for page in drawn:
            page.result()
    _draw_worn(study, to, shaded, views, scale)  # on the last map, the mean


def write_blend(out: Path, to: Path) -> None:
    """Save a finished study's `study.blend`, body, actions, empties, heatmaps, what the panel shows."""
    with needs_blender():
        from ...scene.files.study_file import write_study

    study = StudyResults.load(out, by=None)
    motions = (study.motion(clip.name) for clip in study.clips_in_blend)
    write_study(to / BLEND, study, motions, marked_set(study).order)


class MarkedSet(NamedTuple):
    """The set that a picture marks, with the expected F1 of its first sensor, its first two, and so on."""

    order: list[int]
    scores: list[float]
    target: float | None
    sentence: str


def marked_set(study: StudyResults) -> MarkedSet:
    """The set to wear together in the summary, or the best spot if there is none."""
    worn = study.summary["worn_together"]
    if worn is None:
        answer = study.summary["answer"]
        f1 = answer["expected_f1"]
        return MarkedSet([answer["patch"]], [f1], None, answer["sentence"])
    order = [sensor["patch"] for sensor in worn["places"]]
    scores = [sensor["expected_f1_so_far"] for sensor in worn["places"]]
    return MarkedSet(order, scores, worn["target"], capital(worn["sentence"]))


def _draw_worn(
    study: StudyResults, to: Path, shaded: BodyPictures, views: list[np.ndarray], scale: Scale
) -> None:
    from ...drawing.heatmap import subset_figure  # matplotlib is slow to import
    from ...drawing.page import SensorList

    shown, body = marked_set(study), shaded.body
    order = shown.order[:MAX_LISTED]
    by_patch = {card["patch"]: card for card in study.cards}
    cards = [by_patch[patch] for patch in order]
    triangles = study.patches.triangles[order]
    places, normals = (values[triangles].mean(axis=1) for values in (body.vertices, body.vertex_normals))
    subtitle = shown.sentence
    if len(order) < len(shown.order):
        subtitle += f" (the first {len(order)} of {len(shown.order)} patches shown)"
    names, words = ([card[part] for card in cards] for part in ("sensor", "in_words"))
    sensors = SensorList(names, shown.scores[: len(order)], words, shown.target)
    title, markers = f"Where to wear {count('sensor', len(shown.order))}", shaded.locate(places, normals)
    subset_figure(to / HEATMAPS / f"{SUBSET}.png", views, title, scale, markers, sensors, subtitle)
