# SPDX-License-Identifier: GPL-3.0-or-later
"""Clips become a map, none tested on a copy of it: the panel, the command line and Python rank by this."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, Self

import numpy as np

from ..body.body import Body
from ..imu.recording import ImuRecording
from ..library.import_plan import same_files
from ..library.library import Clip
from ..motion.same_speeds import same_speeds
from ..motion.shared_stretches import shared_stretches
from ..motion.signature import WIDTH
from ..patches.patches import PatchSet
from ..ranking.classifiers.ridge import Ridge
from ..ranking.halves import CrossValidation
from ..ranking.pooling import Pooling
from ..ranking.stream import Stream
from ..ranking.utility import UtilityMap, utility_map
from ..ranking.weights import counting
from ..selection.scored import product_patches
from ..selection.set_tests import SetTests
from ..threads import Spread, unthreaded_products
from ..windows.inputs import PatchBlocks
from ..windows.stream import standing_reading
from .clip_files import ClipWindows
from .config import StudyConfig


def same_motion_groups(
    clips: Sequence[str], keys: Sequence[str] | None = None, signatures: Sequence[np.ndarray] | None = None
) -> np.ndarray:
    """Number the distinct motions among C clips, in order of appearance, shape (C,), int.

    Two clips are the same if their names or keys are equal or they share a stretch of one motion, mirrored or
    not. Sameness is transitive. An empty key or signature matches none.

    Parameters
    ----------
    signatures : sequence of ndarrays, length C, optional
        `motion_signature` of each clip.

    Raises
    ------
    ValueError
        If a signature is none of today's, as in folders of earlier versions.
    """
    joined = _Joined(len(clips))
    joined.join_equal(list(clips))
    if keys is not None:
        joined.join_equal([key or None for key in keys])
    if signatures is not None:
        read = [(_digest(row), len(row) // WIDTH) for row in signatures]
        distinct = joined.join_equal([digest for digest, _ in read])
        frames = np.array([frames for _, frames in read])[distinct]
        with unthreaded_products():  # they are small
            for alike in (shared_stretches, same_speeds):
                for first, second in alike(signatures, distinct, frames, joined.are_one):
                    joined.join(first, second)
    roots = [joined.root(clip) for clip in range(len(clips))]
    _, appearance, number = np.unique(roots, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(appearance))[number]


def _digest(signature: np.ndarray) -> bytes | None:
    """A hash of a signature, None of an empty one; a ValueError refuses one of an earlier version."""
    if len(signature) % WIDTH:
        raise ValueError("an earlier version of W2W made the signals of these clips: make them again")
    return hashlib.blake2b(signature.tobytes()).digest() if len(signature) else None


class _Joined:
    """Clips that are one motion (union-find)."""

    def __init__(self, clips: int) -> None:
        self._parent = list(range(clips))

    def root(self, clip: int) -> int:
        """The clip that stands for all that are one with this."""
        while self._parent[clip] != clip:
            self._parent[clip] = self._parent[self._parent[clip]]
            clip = self._parent[clip]
        return clip

    def are_one(self, first: int, second: int) -> bool:
        """Whether two clips are one motion."""
        return self.root(first) == self.root(second)

    def join(self, first: int, second: int) -> None:
        """Make two clips one motion."""
        self._parent[self.root(second)] = self.root(first)

    def join_equal(self, values: list) -> np.ndarray:
        """Join clips of equal values other than None; return the first clip of each value."""
        first: dict = {}
        for clip, value in enumerate(values):
            if value is not None:
                self.join(first.setdefault(value, clip), clip)
        return np.array(list(first.values()), dtype=np.int64)


RANKING_VERSION = 11
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
    read: Callable[[Sequence[int], Sequence[int]], Sequence[ImuRecording]],
    config: StudyConfig,
    worn: tuple[Body, PatchSet],
) -> Stream:
    """A stream of ranked clips, in the folds that the config asks for.

    `read` gives what some patches of those `worn` record of clips, by their numbers.
    """
    body, patches = worn
    planned = WindowLabels.of(clips, windows).protocol(config).plan(halvings=0)
    clip = np.repeat(np.arange(len(clips)), [len(found.is_test) for found in windows])[planned.used]
    numbers, first = np.unique(clip, return_index=True)
    return Stream(
        read=lambda some: read(numbers.tolist(), some),
        standing=standing_reading(body, patches, config.synthesis),
        sensor=config.sensor_model(),
        spec=config.windows,
        activity=planned.labels[first],
        fold=planned.fold[first],
        weights=planned.weights,
        seed=config.seed,
        spots=list(product_patches(patches, body)) or range(len(patches)),
    )
