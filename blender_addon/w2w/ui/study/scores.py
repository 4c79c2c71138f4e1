# SPDX-License-Identifier: GPL-3.0-or-later
"""The scores that a study shows: for which activities, expected or on these clips, and in which heatmap."""

import numpy as np

from ...core.colours import Scale
from ...core.findings import in_words
from ...core.ranking.utility import UtilityMap
from ...core.ranking.weights import mean_over
from ..jobs.jobs import is_there
from .counting import Group, is_as_ranked, shown_weights
from .lists import answer_of
from .state import utility_of

EXPECTED, ON_THESE = "EXPECTED", "ON_THESE"
"""Values of the study's `scores`."""

MEAN_VIEW = "MEAN"
"""Value of the study's `view` that shows the mean."""

NOTHING = "NOTHING"
"""Value of the study's `minus` if no difference is shown."""


def view_items(study: Group) -> list[tuple[str, str, str, int]]:
    """The mean and each activity, for a menu of heatmaps."""
    mean = (MEAN_VIEW, "Mean of Activities", "Mean over the activities that count", 0)
    names = enumerate((activity.name for activity in study.activities), start=1)
    return [mean, *((f"A{number}", name, f"F1 for telling '{name}' apart", number) for number, name in names)]


def expected_mean(study: Group, utility: UtilityMap) -> np.ndarray:
    """Expected F1 over the activities that count, shape (N,)."""
    return mean_scores(study, utility, EXPECTED)


def activity_scores(study: Group, utility: UtilityMap, kind: str = "") -> np.ndarray:
    """Scores of the heatmaps of the activities, shape (N, A): expected, or on these clips."""
    return utility.expected_f1 if (kind or study.scores) == EXPECTED else utility.f1


def mean_scores(study: Group, utility: UtilityMap, kind: str = "") -> np.ndarray:
    """Scores of the heatmap of the mean over the activities that count, shape (N,)."""
    if not is_as_ranked(study, utility):
        return mean_over(activity_scores(study, utility, kind), shown_weights(study))
    return utility.expected_mean if (kind or study.scores) == EXPECTED else utility.mean


def patch_lines(study: Group, utility: UtilityMap, patch: int) -> tuple[str, ...]:
    """A patch's scores in words."""
    expected, raw = expected_mean(study, utility), mean_scores(study, utility, ON_THESE)
    base = answer_of(study).get("costs_are_against", ())
    return in_words.patch_lines(patch, utility, expected, raw, base, is_as_ranked(study, utility))


def shown_scores(study: Group, utility: UtilityMap) -> np.ndarray:
    """Scores of the heatmap that is shown, minus another's if two are compared, shape (N,)."""
    scores, minus = _scores_of(study, utility, view_index(study)), minus_index(study)
    return scores if minus < 0 else scores - _scores_of(study, utility, minus)


def beside_of(study: Group) -> Group | None:
    """The study of the second map, or None without one."""
    if study.beside is None or not is_there(study.beside):
        return None
    other = study.beside_body
    return other.w2w if other is not None and is_there(other) and utility_of(other.w2w) is not None else study


def beside_scores(study: Group) -> np.ndarray | None:
    """Scores of the second map, of the kind shown, one per patch of its body; None without one."""
    other = beside_of(study)
    if other is None or (utility := utility_of(other)) is None:
        return None
    return _scores_of(other, utility, max(view_of(other, study.beside_view), 0), study.scores)


def _scores_of(study: Group, utility: UtilityMap, index: int, kind: str = "") -> np.ndarray:
    """Scores of a heatmap by its number."""
    if index == 0:
        return mean_scores(study, utility, kind)
    return activity_scores(study, utility, kind)[:, index - 1]


def view_index(study: Group) -> int:
    """Number of the heatmap that is shown: 0 is the mean, then the activities."""
    return max(view_of(study, study.view), 0)


def minus_index(study: Group) -> int:
    """Number of the heatmap that is subtracted from the one shown, or -1."""
    return view_of(study, study.minus)


def view_of(study: Group, view: str) -> int:
    """Number of the heatmap that a view names, or -1."""
    if view in ("", NOTHING):
        return -1
    index = 0 if view == MEAN_VIEW else int(view[1:])
    return index if index <= len(study.activities) else -1


def scale_of(study: Group, utility: UtilityMap) -> Scale:
    """The colours of the map that is shown, which the second one shares."""
    title = "Expected F1" if study.scores == EXPECTED else "F1 on these clips"
    if study.fix_range:
        low, high = sorted((study.range_low, study.range_high))
        return Scale(low, high, title, colour_map=study.colour_map)
    scores, beside = shown_scores(study, utility), beside_scores(study)
    return own_scale(study, scores if beside is None else np.concatenate([scores, beside]), title)


def own_scale(study: Group, scores: np.ndarray, title: str = "") -> Scale:
    """The colours of scores by their own range; none where they hardly differ."""
    return Scale.of_places(scores, title, study.colour_map, answer_of(study).get("places_differ", True))
