# SPDX-License-Identifier: GPL-3.0-or-later
"""From clips with labels to a ranking of places: what both doors, the panel and the command line, do last."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .ranking.inputs import PlaceBlocks
from .study import Recommendation, StudyConfig, recommend, same_clips


@dataclass(frozen=True, eq=False)
class RankedClip:
    """What the ranking must know of a clip beside its windows.

    Parameters
    ----------
    name : str
        Its own.
    activity, subject : str
    is_test : ndarray of bool, shape (windows of the clip,)
        Windows that may be tested on.
    signature : ndarray, shape (K,)
        By which equal motions are known (`motion_signature`).
    motion_key : str
        Clips with an equal key show the same motion; empty where unknown.
    """

    name: str
    activity: str
    subject: str
    is_test: np.ndarray
    signature: np.ndarray
    motion_key: str = ""


def rank_clips(
    clips: Sequence[RankedClip],
    inputs: np.ndarray | PlaceBlocks,
    config: StudyConfig,
    progress: Callable[[float], None] | None = None,
    work: Path | None = None,
) -> tuple[Recommendation, np.ndarray]:
    """Find clips that show one motion, rank all places and choose.

    Parameters
    ----------
    clips : sequence of RankedClip
    inputs : ndarray or PlaceBlocks, shape (W, N, ...)
        What the classifier takes (`utility.inputs_of`), the clips' windows one after another.
    config : StudyConfig
    progress : callable, optional
        Told the fraction done.
    work : Path, optional
        Folder for what a later call can take up, as for `utility_map`.

    Returns
    -------
    recommendation : Recommendation
    groups : ndarray, shape (clips,), int
        Which clips show the same motion.

    Raises
    ------
    ValueError
        If fewer than two activities can be tested; the message says why.
    """
    groups = same_clips(
        [clip.name for clip in clips],
        [clip.motion_key for clip in clips],
        np.array([clip.signature for clip in clips]),
    )
    group_names = np.array([clips[np.argmax(groups == group)].name for group in groups])
    windows = [len(clip.is_test) for clip in clips]
    recommendation = recommend(
        inputs,
        np.repeat([clip.activity for clip in clips], windows),
        np.repeat(group_names, windows),
        np.repeat([clip.subject for clip in clips], windows),
        np.concatenate([clip.is_test for clip in clips]),
        config,
        progress,
        work,
    )
    return recommendation, groups
