# SPDX-License-Identifier: GPL-3.0-or-later
"""The scores that a study shows: of which activities, expected or on these clips, and in which heatmap."""

from __future__ import annotations

import bpy
import numpy as np

from ..core.colours import score_range, span_note
from ..core.ranking.utility import UtilityMap

EXPECTED, ON_THESE = "EXPECTED", "ON_THESE"
"""Values of the study's `scores`."""

MEAN_VIEW = "MEAN"
"""Value of the study's `view` that shows the mean."""

NOTHING = "NOTHING"
"""Value of the study's `minus` where no difference is shown."""


def ticked(study: bpy.types.PropertyGroup) -> np.ndarray:
    """Which activities count, shape (A,), bool; all where none is ticked."""
    used = np.array([activity.use for activity in study.activities], dtype=bool)
    return used if used.any() else np.ones(len(used), dtype=bool)


def left_out(study: bpy.types.PropertyGroup) -> list[str]:
    """Names of the activities that do not count; none where none is ticked."""
    return [
        activity.name for activity, counts in zip(study.activities, ticked(study), strict=True) if not counts
    ]


def expected_mean(study: bpy.types.PropertyGroup, utility: UtilityMap) -> np.ndarray:
    """Expected F1 over the activities that count, shape (N,)."""
    counting = ticked(study)
    return utility.expected_mean if counting.all() else utility.expected_f1[:, counting].mean(axis=1)


def activity_scores(study: bpy.types.PropertyGroup, utility: UtilityMap) -> np.ndarray:
    """Scores of the heatmaps of the activities, shape (N, A): expected, or on these clips."""
    return utility.expected_f1 if study.scores == EXPECTED else utility.f1


def mean_scores(study: bpy.types.PropertyGroup, utility: UtilityMap) -> np.ndarray:
    """Scores of the heatmap of the mean over the activities that count, shape (N,)."""
    if study.scores == EXPECTED:
        return expected_mean(study, utility)
    return utility.f1[:, ticked(study)].mean(axis=1)


def shown_scores(study: bpy.types.PropertyGroup, utility: UtilityMap) -> np.ndarray:
    """Scores of the heatmap that is shown, less those of the other where two are compared, shape (N,)."""
    scores, minus = _scores_of(study, utility, view_index(study)), minus_index(study)
    return scores if minus < 0 else scores - _scores_of(study, utility, minus)


def _scores_of(study: bpy.types.PropertyGroup, utility: UtilityMap, index: int) -> np.ndarray:
    """Scores of a heatmap by its number."""
    return mean_scores(study, utility) if index == 0 else activity_scores(study, utility)[:, index - 1]


def view_index(study: bpy.types.PropertyGroup) -> int:
    """Number of the heatmap that is shown: 0 is the mean, then the activities."""
    return max(_index(study, study.view), 0)


def minus_index(study: bpy.types.PropertyGroup) -> int:
    """Number of the heatmap that is taken off the one shown; -1 is none."""
    return _index(study, study.minus)


def _index(study: bpy.types.PropertyGroup, view: str) -> int:
    if view in ("", NOTHING):
        return -1
    index = 0 if view == MEAN_VIEW else int(view[1:])
    return index if index <= len(study.activities) else -1


def colour_range(
    study: bpy.types.PropertyGroup, scores: np.ndarray, utility: UtilityMap
) -> tuple[float, float]:
    """F1 at the two ends of the colours."""
    if study.fix_range:
        return min(study.range_low, study.range_high), max(study.range_low, study.range_high)
    return score_range(scores, utility.colour_span)


def range_note(study: bpy.types.PropertyGroup, scores: np.ndarray, utility: UtilityMap) -> str:
    """What the colour bar says where its colours span more than the scores; else empty."""
    return "" if study.fix_range else span_note(scores, *colour_range(study, scores, utility))
