# SPDX-License-Identifier: GPL-3.0-or-later
"""Heatmaps and Blender file of a finished study, made in worker processes: Blender may crash as it saves."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from ...core.body.body import Body
from ...core.colours import Scale
from ...core.files import folder_beside
from ...core.given import inside
from ...core.motion.motion import Motion
from ...core.reading.guard import output_to
from ...core.selection.headline import doubted, mean_title
from ...core.selection.scored import best_single
from ...core.study.clip_files import WORK, motion_file
from ...core.study.results import StudyResults
from ...core.wording import capital, count
from ..blender import NoBlenderError, needs_blender
from ..runs.folder import HEATMAPS, MEAN, SUBSET, picture_files, picture_names
from ..runs.monitor import RunMonitor
from ..runs.own_files import move_in, remove_written
from ..runs.workers import Workers, local_executor, outcome, run_alone
from ..stopping import deaf_children
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


@dataclass
class Drawing:
    """Pictures of a results folder and its `study.blend`, each made by a worker process of its own.

    Maps may be begun before there is a choice.
    """

    out: Path
    folder: Path
    workers: Mapping[str, Workers]
    begun: list[tuple[str, Future[str]]] = field(default_factory=list)

    def get_ready(self) -> None:
        """Let a worker start and shade the body before there is a map."""
        self._submit(HEATMAPS, partial(shaded, self.out))

    def begin(self, study: StudyResults) -> None:
        """Draw a study's maps, and get ready to save the file, while this process goes on."""
        self._submit(HEATMAPS, partial(write_maps, replace(study, read=None), self.folder / "new"))
        self._submit(
            BLEND, partial(ready_to_save, self.out, tuple(clip.name for clip in study.clips_in_blend))
        )

    def save(self) -> None:
        """Draw what is missing and save `study.blend`, once results are written, in the same way."""
        if not self.begun:
            self.begin(StudyResults.load(self.out, by=None))
        self._submit(HEATMAPS, partial(write_worn, self.out, self.folder / "new"))
        self._submit(BLEND, partial(write_blend, self.out, self.folder / "new"))

    def finish(self, activities: Sequence[str], monitor: RunMonitor) -> dict[str, str]:
        """Wait for what was begun and give it its names; what failed, and why."""
        new, title = self.folder / "new", f"Drawing heatmaps, saving {BLEND}"
        files = [new / HEATMAPS / file for file in picture_files(activities)]
        with monitor.bar("drawing", len(files), title) as advance, _counted(files, advance):
            whys = [(what, _reason(outcome(of), self._printed(what))) for what, of in self.begun]
        drawn = {*move_in(self.out, new)}
        # those of an earlier run show other results
        remove_written(self.out, lambda name: name not in drawn and name.startswith((f"{HEATMAPS}/", BLEND)))
        return {what: why for what, why in reversed(whys) if why}

    def _submit(self, what: str, work: Callable[[], object]) -> None:
        with deaf_children(), suppress(BrokenExecutor):  # what killed the worker says why
            self.begun.append((what, self.workers[what].submit(_draw, work, self._printed(what))))

    def _printed(self, what: str) -> Path:
        return self.folder / f"{what}.txt"


@contextmanager
def drawing(out: Path) -> Iterator[Drawing]:
    """A place and workers for the pictures of a results folder, until the block ends."""
    with folder_beside(out / HEATMAPS) as folder, local_executor(1) as maps, local_executor(1) as blend:
        Path(folder, "new", HEATMAPS).mkdir(parents=True)
        yield Drawing(out, Path(folder), {HEATMAPS: maps, BLEND: blend})


def draw_alone(work: Callable[[], None]) -> str:
    """Draw in a worker process of its own; returns why it failed, or ""."""
    with tempfile.TemporaryDirectory(prefix="w2w_draw_") as folder:
        return _reason(run_alone(_draw, work, printed := Path(folder, "printed.txt")), printed)


def _reason(why: str | None, printed: Path) -> str:
    """Why a picture failed, or ""; the reason of a crash of Blender, which is None, from its output."""
    if why is not None:
        return why
    text = printed.read_text(errors="replace") if printed.exists() else ""
    last = " ".join(text.partition("Fatal Python error")[0].split())  # then come Python's own
    return missing_library(last) or f"Blender crashed; its last words: {last[-MAX_SAID:] or 'none'}"


def _draw(work: Callable[[], object], printed: Path) -> str:
    """Draw, in the worker; what Blender prints is written to a file in case the process dies."""
    with output_to(printed):
        try:
            work()
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


def write_maps(study: StudyResults, to: Path) -> None:
    """Draw `heatmaps/*.png` of a ranked study in a folder, one for each activity, and the mean."""
    from ...drawing.heatmap import heatmap_figure  # matplotlib is slow to import

    utility = study.utility
    titles = [name.replace("_", " ").capitalize() for name in utility.activities]
    best = [int(scores.argmax()) for scores in utility.expected_f1.T]
    maps = [*zip(picture_names(utility.activities), titles, utility.expected_f1.T, best, strict=True)]
    allowed = study.config().constraints.terms(study.patches).allowed
    maps.append((MEAN, mean_title(utility), utility.expected_mean, best_single(utility, allowed)))
    with ThreadPoolExecutor(1) as pages:  # the next body is coloured while the last one's page is made
        drawn = []
        for name, title, scores, spot in maps:
            scale, views = _coloured(study, scores)
            best_spot = f"Best spot: {study.patches.names[spot]} ({scores[spot]:.2f} on other clips)"
            subtitle = doubted(utility, best_spot)
            path = to / HEATMAPS / f"{name}.png"
            drawn.append(pages.submit(heatmap_figure, path, views, title, scale, subtitle))
        for page in drawn:
            page.result()


def _coloured(study: StudyResults, scores: np.ndarray) -> tuple[Scale, list[np.ndarray]]:
    scale = Scale.of(scores, title=EXPECTED)
    return scale, shaded(study.out).coloured(scale.colours(study.patches, scores))


@lru_cache(maxsize=1)  # once a worker and study
def shaded(out: Path) -> BodyPictures:
    """The body of a results folder, as all of its pictures show it."""
    from ...drawing.body import BodyPictures, size_for
    from ...drawing.heatmap import VIEW_PIXELS

    body = Body.load(inside(out, f"{WORK}/body.npz"))
    return BodyPictures(body, size_for(body, VIEW_PIXELS - 3))  # soft edges may take three more


@lru_cache(maxsize=1)  # once a worker and study
def ready_to_save(out: Path, clips: tuple[str, ...]) -> tuple[Motion, ...]:
    """The motions of clips for `study.blend`, and imported what saves it: both take longer than saving."""
    with needs_blender():
        from ...scene.files import study_file  # noqa: F401
    return tuple(Motion.load(motion_file(out, clip)) for clip in clips)


def write_blend(out: Path, to: Path) -> None:
    """Save a finished study's `study.blend`, body, actions, empties, heatmaps, what the panel shows."""
    with needs_blender():
        from ...scene.files.study_file import write_study

    study = StudyResults.load(out, by=None)
    motions = ready_to_save(out, tuple(clip.name for clip in study.clips_in_blend))
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


def write_worn(out: Path, to: Path) -> None:
    """Draw the picture of a finished study's set, on its mean, in a folder."""
    from ...drawing.heatmap import subset_figure  # matplotlib is slow to import
    from ...drawing.page import SensorList

    study = StudyResults.load(out, by=None)
    scale, views = _coloured(study, study.utility.expected_mean)
    shown, pictures = marked_set(study), shaded(out)
    body = pictures.body
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
    title, markers = f"Where to wear {count('sensor', len(shown.order))}", pictures.locate(places, normals)
    subset_figure(to / HEATMAPS / f"{SUBSET}.png", views, title, scale, markers, sensors, subtitle)
