# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips, their labels and windows become a map: the panel, the command line and Python rank by this."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..body.body import Body
from ..imu.recording import ImuRecording
from ..library.import_plan import same_files
from ..library.library import Clip
from ..patches.patches import PatchSet
from ..ranking.classifiers.ridge import Ridge
from ..ranking.f1 import Spread
from ..ranking.halves import CrossValidation
from ..ranking.pooling import Pooling
from ..ranking.same_motion import same_motion_groups
from ..ranking.stream import Stream
from ..ranking.utility import UtilityMap, utility_map
from ..ranking.weights import counting
from ..selection.scored import product_patches
from ..selection.set_tests import SetTests
from ..threads import for_each
from ..windows.inputs import PatchBlocks
from ..windows.stream import standing_reading
from .clip_files import ClipWindows
from .config import StudyConfig

RANKING_VERSION = 8
"""Version of maps, choices and what is told of them: raise it with a change that gives others."""


@dataclass(frozen=True)
class LabelledClip:
    """A clip by its labels, independent of its signals; its name is also that of its files.

    Clips with an equal `motion_key` show the same motion; it is "" if unknown. The ranking gives each
    the name of the first clip that shows its motion: its own if there is no other.
    """

    name: str
    activity: str
    subject: str = ""
    motion_key: str = ""


@dataclass(frozen=True, eq=False)
class WindowLabels:
    """Labels of each window, shape (W,), and whether it is a test window.

    `motion` is the first clip that shows the same motion: windows of one motion are never split.
    """

    activity: np.ndarray
    motion: np.ndarray
    subject: np.ndarray
    is_test: np.ndarray

    @classmethod
    def of(cls, clips: Sequence[LabelledClip], windows: Sequence[ClipWindows]) -> Self:
        """Labels of the windows of ranked clips, one clip after another."""
        counts = [len(of_clip.is_test) for of_clip in windows]
        activity, motion, subject = (
            np.repeat([getattr(clip, name) for clip in clips], counts)
            for name in ("activity", "motion_key", "subject")
        )
        return cls(activity, motion, subject, np.concatenate([of_clip.is_test for of_clip in windows]))

    def some(self, rows: np.ndarray) -> Self:
        """The labels of a subset of windows, by index or mask."""
        return replace(self, **{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    def protocol(self, config: StudyConfig) -> CrossValidation:
        """The protocol that the config asks for."""
        activities = sorted(set(self.activity.tolist()))
        counts = counting(activities, config.background, config.weights)
        subject = self.subject if config.by_subject else None
        return CrossValidation(
            activity=self.activity, clip=self.motion, subject=subject, is_test=self.is_test,
            activities=activities, folds=config.folds, seed=config.seed, counts=counts,
        )  # fmt: skip


def same_motions(
    clips: Sequence[Clip | LabelledClip],
    windows: Sequence[ClipWindows],
    signatures: Sequence[np.ndarray] | None = None,
) -> tuple[LabelledClip, ...]:
    """The clips, each with the first that shows the same motion; `signatures` if `windows` lack them."""
    names, keys = [clip.name for clip in clips], [clip.motion_key for clip in clips]
    groups = same_motion_groups(names, keys, signatures or [of_clip.signature for of_clip in windows])
    return _by_motion(clips, groups)


def known_motions(clips: Sequence[Clip]) -> tuple[LabelledClip, ...]:
    """Like `same_motions`, by what is known before the files are read: equal keys and equal files."""
    first = same_files([clip.path for clip in clips])
    name_of = {(clip.path, clip.animation): clip.name for clip in clips}
    parts = [(first.get(clip.path, clip.path), clip.animation) for clip in clips]
    names = [name_of.get(part, clip.name) for part, clip in zip(parts, clips, strict=True)]
    return _by_motion(clips, same_motion_groups(names, [clip.motion_key for clip in clips]))


def _by_motion(clips: Sequence[Clip | LabelledClip], groups: np.ndarray) -> tuple[LabelledClip, ...]:
    """The clips, each with the first of its group."""
    first = np.unique(groups, return_index=True)[1]
    return tuple(
        LabelledClip(clip.name, clip.activity, clip.subject, clips[int(first[group])].name)
        for clip, group in zip(clips, groups, strict=True)
    )


def copies_among(
    clips: Sequence[Clip | LabelledClip], ranked: Sequence[LabelledClip]
) -> list[tuple[str, str]]:
    """Clips that show the motion of an earlier one, each with that one: by file if they have one."""
    called = {clip.name: getattr(clip, "file", clip.name) for clip in clips}
    return [(called[clip.name], called[clip.motion_key]) for clip in ranked if clip.motion_key != clip.name]


def rank_clips(
    clips: Sequence[LabelledClip],
    windows: Sequence[ClipWindows],
    inputs: np.ndarray | PatchBlocks,
    config: StudyConfig,
    pooling: Pooling,
    *,
    classifier: Any = None,
    progress: Callable[[float], None] | None = None,
    work: Path | None = None,
    spread: Spread | None = None,
) -> UtilityMap:
    """Rank every patch by the windows of clips that `same_motions` gave, as the config asks for it.

    `inputs` (W, N, ...) are the windows of one clip after another. A `classifier` replaces the config's; the
    others are as for `utility_map`.
    """
    protocol = WindowLabels.of(clips, windows).protocol(config)
    model = config.classifier if classifier is None else classifier
    return utility_map(inputs, protocol, model, progress=progress, work=work, pooling=pooling, spread=spread)


def set_tests_of(
    inputs: np.ndarray | PatchBlocks,
    labels: WindowLabels,
    config: StudyConfig,
    pooling: Pooling,
    classifier: Any = None,
    utility: UtilityMap | None = None,
) -> SetTests | None:
    """Tests that sets of patches are chosen and judged by; None for all but the ridge, which alone is fast.

    `utility`, the map of the same inputs, labels and config, spares ranking halves of the clips again.
    """
    if (config.classifier if classifier is None else classifier) != Ridge.name:
        return None
    return SetTests.of(inputs, labels.protocol(config), pooling, utility=utility)


def stream_of(
    clips: Sequence[LabelledClip],
    windows: Sequence[ClipWindows],
    read: Callable[[int, Sequence[int]], ImuRecording],
    config: StudyConfig,
    worn: tuple[Body, PatchSet],
) -> Stream:
    """A stream of ranked clips, in the folds that the config asks for.

    `read` gives what some patches of those `worn` record of a clip, by its number.
    """
    body, patches = worn
    planned = WindowLabels.of(clips, windows).protocol(config).plan(halvings=0)
    clip = np.repeat(np.arange(len(clips)), [len(found.is_test) for found in windows])[planned.used]
    numbers, first = np.unique(clip, return_index=True)
    return Stream(
        read=lambda some: for_each(lambda number: read(number, some), numbers.tolist()),
        standing=standing_reading(body, patches, config.synthesis),
        sensor=config.sensor_model(),
        spec=config.windows,
        activity=planned.labels[first],
        fold=planned.fold[first],
        weights=planned.weights,
        seed=config.seed,
        spots=list(product_patches(patches, body)) or range(len(patches)),
    )
