# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study: its results folder, read back, and its clips."""

import json
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..body.body import Body
from ..given import ForeignFileError, inside
from ..imu.cover import covered
from ..imu.recording import ImuRecording
from ..library.library import Clip, Library
from ..motion.motion import Motion
from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from ..selection.advice import Advice
from ..threads import unthreaded_products
from ..windows.inputs import PatchBlocks, StoredArray
from ..wording import clean, restated
from .clip_files import (
    CHANGING,
    WORK,
    ClipWindows,
    Entry,
    FilesToRank,
    is_used,
    motion_file,
    ranking_inputs,
    read_clip_list,
    signals_file,
)
from .config import StudyConfig
from .ranking import LabelledClip, WindowLabels, copies_among
from .signals import simulate
from .variants import own_rate

REPORT = "report.html"

UTILITY = "utility.npz"
"""The whole ranking, with its intervals, confusions and predictions."""

DAMAGED = (KeyError, ValueError, TypeError, AttributeError, RecursionError)
"""Errors of reading what is not as a run writes it."""

MOST_ACTIONS, SHOWN = 100, 3
"""Clips up to which the Blender file holds the motions of all, and how many an activity it holds of more."""


class UnfinishedError(ValueError):
    """A results folder with files of a run that was stopped or still works; the message says what to do."""


def check_finished(out: Path, by: str = "") -> None:
    """Raise an UnfinishedError if a command has begun to change a folder's results and has not finished.

    `by` is the reader, which may finish what it has begun itself.
    """
    mark = inside(out, CHANGING)
    if mark.exists() and not (by and mark.is_file() and mark.read_text(errors="replace") == by):
        raise UnfinishedError(
            f"{clean(out)} holds an unfinished run: run the same command again to finish it, or wait if it "
            "is still running"
        )


@dataclass(frozen=True, eq=False)
class SimulatedClips:
    """The clips of a run's folder, in the order of their windows, and what its patches recorded of them."""

    out: Path
    patches: PatchSet
    clips: tuple[LabelledClip, ...]
    parameters: dict[str, Any]  # the config as plain values
    read: FilesToRank | None = field(default=None, kw_only=True)
    """The content of the clips' files, as read by the run that has just ended."""

    def config(self) -> StudyConfig:
        """The parameters of the run; ValueError if one in config.json is wrong, with what is allowed."""
        with restated(f"{self.out / 'config.json'}:", ValueError):
            return StudyConfig.from_dict(self.parameters)

    def body(self) -> Body:
        """The body of the study; ValueError if it is not there or no body."""
        try:
            return Body.load(inside(self.out, f"{WORK}/body.npz"))
        except OSError as error:
            raise ValueError(
                f"{self.out} is not the whole results folder of a run: {WORK}/body.npz cannot be read"
            ) from error

    def motion(self, clip: str) -> Motion:
        """The motion of a clip on the study's body."""
        return Motion.load(motion_file(self.out, clip))

    def recording(self, clip: int, patches: Sequence[int] | None = None) -> ImuRecording:
        """Recording of a clip, by its number, from the sensors on all patches or some.

        It is read if the run kept it, else made again from the motion: on all patches the same to the last
        bit, on some but for single samples that are one step of the sensor off.
        """
        kept = signals_file(*self.places[clip])
        if kept.exists():
            if patches is None or self._made_by[1].further.record:
                whole = ImuRecording.load(kept)
                return whole if patches is None else whole.at(patches)
            acc, gyr = (StoredArray.find(kept, name).some(patches) for name in ("acc", "gyr"))
            return self.recorded(clip, patches, acc, gyr)
        body, config = self._made_by
        with unthreaded_products():
            return simulate(body, self.patches, self.motion(self.clips[clip].name), config, chosen=patches)

    def recorded(self, clip: int, patches: Sequence[int], acc: np.ndarray, gyr: np.ndarray) -> ImuRecording:
        """What some patches read of a clip, (T, N, 3) each, as its recording under its labels."""
        sites, its = tuple(self.patches.names[patch] for patch in patches), self.clips[clip]
        return ImuRecording(acc, gyr, own_rate(self._made_by[1]), sites, its.activity, its.subject, its.name)

    @cached_property
    def _made_by(self) -> tuple[Body, StudyConfig]:
        return self.body(), self.config()

    @cached_property
    def windows(self) -> tuple[ClipWindows, ...]:
        """The windows of each clip."""
        return self.read.windows if self.read else tuple(ClipWindows.read(*place) for place in self.places)

    @cached_property
    def places(self) -> tuple[tuple[Path, str], ...]:
        """Folder of each clip's files, and their name in it."""
        return tuple((self.out, clip.name) for clip in self.clips)

    def inputs(self, classifier: str) -> PatchBlocks:
        """A classifier's inputs: all windows of all patches, served from disk."""
        if self.read and self.read.classifier == classifier:
            return self.read.inputs
        return ranking_inputs(self.places, self.windows, classifier, self.config().windows)

    def labels(self) -> WindowLabels:
        """Labels of each window."""
        return WindowLabels.of(self.clips, self.windows)


@dataclass(frozen=True, eq=False)
class StudyResults(SimulatedClips):
    """The content of a run's folder: its clips and their ranking."""

    utility: UtilityMap

    @classmethod
    def load(cls, out: Path, *, by: str | None = "") -> Self:
        """Read a results folder; ValueError if `out` is not that of a finished run.

        `by` is as in `check_finished`; None does without, for the command that has just written the folder.
        """
        if by is not None:
            check_finished(out, by)
        try:
            summary = json.loads(inside(out, "summary.json").read_text(encoding="utf-8"))
            config = json.loads(inside(out, "config.json").read_text(encoding="utf-8"))
            config["parameters"].keys()
            utility = UtilityMap.load(inside(out, UTILITY))
            patches = PatchSet.load(inside(out, f"{WORK}/patches.npz"))
            clips = _clips(filter(is_used, read_clip_list(out)))
            with restated("its summary.json is not as a run writes it:", DAMAGED):
                _check_summary(summary, len(patches))
        except FileNotFoundError as error:
            raise ValueError(
                f"{out} is not the results folder of a finished run: {Path(error.filename).name} is missing"
            ) from error
        except ForeignFileError:
            raise
        except (OSError, *DAMAGED) as error:
            raise ValueError(f"{out} cannot be read as a results folder: {error}") from error
        if len(patches) != len(utility.mean):
            raise ValueError(f"{out} holds a ranking of other patches than its own: run the study again")
        return cls(out, patches, clips, config["parameters"], utility)

    def check_fits(self, body: str, n_vertices: int) -> None:
        """Refuse, by a ValueError, a run whose parts do not belong together on a body of so many vertices."""
        patches, utility = self.patches, self.utility
        if len(patches.labels) != n_vertices or patches.triangles.max() >= n_vertices:
            raise ValueError(f"the spots are of another body than '{body}'")
        if utility.f1.shape != (len(patches), len(utility.activities)):
            raise ValueError(f"the ranking is of other spots than those of '{body}'")
        with restated("the parameters of the run cannot be understood:", ValueError):
            StudyConfig.from_dict(self.parameters)

    @cached_property
    def summary(self) -> dict[str, Any]:
        """Content of `summary.json`."""
        return json.loads(inside(self.out, "summary.json").read_text(encoding="utf-8"))

    @property
    def cards(self) -> list[dict[str, Any]]:
        """Where each recommended sensor goes, from `summary.json`."""
        return self.summary["cards"]

    @property
    def clips_in_blend(self) -> list[LabelledClip]:
        """The clips whose motions `study.blend` holds: all, or of many the first of each activity."""
        seen: Counter[str] = Counter()
        kept = []
        for clip in self.clips:
            seen[clip.activity] += 1
            if len(self.clips) <= MOST_ACTIONS or seen[clip.activity] <= SHOWN:
                kept.append(clip)
        return kept

    @cached_property
    def entries(self) -> tuple[Entry, ...]:
        """The folder's list of clips: entries of `clips`, then of those skipped."""
        return tuple(read_clip_list(self.out))


@dataclass(frozen=True, eq=False)
class HeldClips(SimulatedClips):
    """Clips of a study in memory; their files may lie in several folders."""

    stored: tuple[tuple[Path, str], ...]
    shown: Body

    @property
    def places(self) -> tuple[tuple[Path, str], ...]:
        """Folder of each clip's files, and their name in it."""
        return self.stored

    def body(self) -> Body:
        """The body of the study."""
        return self.shown


@dataclass(frozen=True)
class HeldResults(HeldClips, StudyResults):
    """A finished study in memory."""

    def renamed(self, names: Sequence[str]) -> Self:
        """The same with other names of the clips."""
        name_of = dict(zip((clip.name for clip in self.clips), names, strict=True))
        pairs = zip(self.clips, names, strict=True)
        clips = (replace(clip, name=name, motion_key=name_of[clip.motion_key]) for clip, name in pairs)
        return replace(self, clips=tuple(clips))


def stored_recording(out: Path, clip: str) -> ImuRecording:
    """Recording of a clip from a run's folder, or one laid out like it."""
    kept = signals_file(out, clip)
    if kept.exists():
        return ImuRecording.load(kept)
    study = StudyResults.load(out)
    return study.recording([one.name for one in study.clips].index(clip))


def _check_summary(summary: Mapping[str, Any], n_patches: int) -> None:
    """Refuse a summary, by a ValueError, unless all sensors in it have names and patches of the study."""
    sensors = [summary["answer"], summary["best_single_patch"]]
    sensors += (summary["worn_together"] or {"places": []})["places"]
    sensors += [card | {"name": card["sensor"]} for card in summary["cards"]]
    for patch in (*(sensor["patch"] for sensor in sensors), *chain(*covered(summary).values())):
        if not isinstance(patch, int) or not 0 <= patch < n_patches:
            raise ValueError(f"there is no patch {str(patch)[:20]}")
    if not all(isinstance(sensor["name"], str) for sensor in sensors):
        raise ValueError("a sensor's name is no text")
    if "pilot" in summary and not {"sentence", "next", "patch", "cautions"} <= summary["pilot"].keys():
        raise ValueError("its pilot is not whole")


def _clips(used: Iterable[Entry]) -> tuple[LabelledClip, ...]:
    name_of: dict[str, str] = {}
    clips = []
    for entry in used:
        name = name_of[entry["file"]] = entry["clip"]
        first = name_of[entry["same_motion_as"]] if "same_motion_as" in entry else name
        clips.append(LabelledClip(name, sys.intern(entry["activity"]), sys.intern(entry["subject"]), first))
    return tuple(clips)


@dataclass(frozen=True, slots=True)
class ClipResult:
    """A clip, used or skipped."""

    clip: Clip
    reason: str  # why it was skipped; "" if it is used
    details: dict[str, Any]  # of a used clip: take, frames, rate, duration, windows, skeleton
    source_sha256: str  # of the clip's file

    @property
    def used(self) -> bool:
        """Whether the clip takes part in the ranking."""
        return not self.reason

    def small(self) -> Self:
        """The result with words that many clips share held once."""
        details = {
            sys.intern(name): sys.intern(value) if isinstance(value, str) else value
            for name, value in self.details.items()
        }
        return replace(self, reason=sys.intern(self.reason), details=details)


@dataclass(frozen=True)
class Study:
    """A finished study, ready to be written down."""

    library: Library
    config: StudyConfig
    body: Body
    clips: tuple[ClipResult, ...]  # all of them, in the library's order
    results: StudyResults  # the ranking, as it is read again from its folder
    advice: Advice  # the choice under the config's constraints
    needs: Sequence[dict[str, Any]] = ()  # how cheap its sensors may be, if that was found (`need_content`)
    pilot: dict[str, Any] | None = None  # what people's recordings said, likewise (`Pilot.content`)

    @property
    def used(self) -> list[ClipResult]:
        """Clips that take part."""
        return [result for result in self.clips if result.used]

    @property
    def copies(self) -> list[tuple[str, str]]:
        """Files that show the motion of another, each with the first that shows it."""
        return copies_among([result.clip for result in self.used], self.results.clips)
