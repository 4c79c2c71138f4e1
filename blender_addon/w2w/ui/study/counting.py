# SPDX-License-Identifier: GPL-3.0-or-later
"""The part of each activity: counted by its weight, background (trained against, in no mean) or left out."""

from collections.abc import Iterable
from typing import TypeAlias

import bpy
import numpy as np

from ...core.library.labels import same_label
from ...core.ranking.utility import UtilityMap
from ...core.ranking.weights import counting
from ...core.study.config import StudyConfig
from .declared import as_given

COUNTED, BACKGROUND, LEFT_OUT = "COUNTED", "BACKGROUND", "LEFT_OUT"
"""Parts that an activity takes."""

Group: TypeAlias = bpy.types.PropertyGroup


def ticked(study: Group) -> np.ndarray:
    """Mask of the activities that are not left out, shape (A,); all True if every one would be."""
    used = np.array([activity.part != LEFT_OUT for activity in study.activities], dtype=bool)
    return used if used.any() else np.ones(len(used), dtype=bool)


def left_out(study: Group) -> list[str]:
    """Names of the activities that are left out; [] if every one would be."""
    return [row.name for row, taken in zip(study.activities, ticked(study), strict=True) if not taken]


def shown_weights(study: Group) -> np.ndarray:
    """Weights of the activities in the heatmap, shape (A,); 1 for each not left out if none counts."""
    weights = np.where(ticked(study), _weights(study), 0.0)
    return weights if weights.any() else ticked(study).astype(np.float64)


def is_as_ranked(study: Group, utility: UtilityMap) -> bool:
    """Whether activities count as they did in the ranking, none of them left out."""
    return np.array_equal(shown_weights(study), utility.weights)


def is_reweighed(study: Group, utility: UtilityMap) -> bool:
    """Whether the weight of an activity that is not left out differs from the ranking's."""
    taken = ticked(study)
    return not np.array_equal(_weights(study)[taken], utility.weights[taken])


def counted_in(study: Group, run: StudyConfig) -> tuple[tuple[str, ...], tuple[tuple[str, float], ...]]:
    """Background activities and weights for `StudyConfig`.

    Excluded activities appear in neither; activities missing from the ranking keep the opened run's values,
    and the run's own tuples are returned if equivalent.
    """
    included = [activity for activity, is_in in zip(study.activities, ticked(study), strict=True) if is_in]
    counted = [activity for activity in included if activity.part == COUNTED]
    weights = [(activity.name, _weight(activity)) for activity in counted if _weight(activity) != 1]
    background = [activity.name for activity in included if activity.part == BACKGROUND]
    if run.background or run.weights:
        listed = {same_label(activity.name) for activity in study.activities}
        unranked = {same_label(name) for name in {clip.activity for clip in study.clips}} - listed
        background += [name for name in run.background if same_label(name) in unranked]
        weights += [(name, weight) for name, weight in run.weights if same_label(name) in unranked]
        names = sorted({row.name for row in study.activities} | {clip.activity for clip in study.clips})
        if counting(names, background, weights) == counting(names, run.background, run.weights):
            return run.background, run.weights
    return tuple(background), tuple(weights)


def list_activities(study: Group, activities: Iterable[str], run: StudyConfig) -> None:
    """List activities with their weights, or for new ones those of the opened run."""
    before = {item.name: (item.part, item.weight, item.given) for item in study.activities}
    activities = list(activities)
    counts = counting(activities, run.background, run.weights)
    study.activities.clear()
    for name in activities:
        activity = study.activities.add()
        activity.name = name
        if name in before:
            activity.part, activity.weight, activity.given = before[name]
        elif counts.get(name, 1.0):
            activity.weight, activity.given = counts.get(name, 1.0), repr(counts.get(name, 1.0))
        else:
            activity.part = BACKGROUND


def _weight(activity: Group) -> float:
    return as_given(activity.weight, float(activity.given or "nan"))


def _weights(study: Group) -> np.ndarray:
    """Weights, 0 for background, whether ticked or not."""
    return np.array([0.0 if row.part == BACKGROUND else _weight(row) for row in study.activities])
