# SPDX-License-Identifier: GPL-3.0-or-later
"""A check that a ranking separates activities, not the sources of their clips or the people.

Simulated sensors recognise the recording system of a clip (docs/truth.md): an activity that only one system
shows is recognised by the system.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..files import DIGITS
from ..ranking.utility import UtilityMap, utility_map
from ..study.clip_files import NO_SIGNATURE, ClipWindows
from ..study.config import StudyConfig
from ..study.ranking import LabelledClip, WindowLabels
from ..wording import NAMED, join_words

ALONE = 0.8
"""Share of an activity's clips above which it is practically from one source alone."""

SOURCES = "the ranking may tell the sources of the clips"
"""Beginning of the caution on them."""

STRANGERS = 0.2
"""Two activities whose shares by source overlap by less than this have no source in common."""

MOST_SOURCES = 50
"""Sources that are told apart, those with most clips: others have too few to learn from."""


class Origin(NamedTuple):
    """Where a clip is from, as far as is known."""

    activity: str
    source: str  # from the labels, else ""
    system: str  # the skeleton and the frame rate of its file
    folder: str  # the first folder of its path inside the library; "" if in none
    subject: str  # "" if unknown


def system_of(skeleton: str, rate: float) -> str:
    """The recording system of a clip, as far as its file shows it."""
    return f"{skeleton or 'unnamed'} skeletons at {round(rate)} frames/s"


def origin_of(clip: LabelledClip, facts: Mapping[str, Any]) -> Origin:
    """Where a clip is from, by its labels and its record."""
    folder = facts.get("file", "").rpartition("/")[0].partition("/")[0]
    system = system_of(facts.get("skeleton", ""), facts.get("frame_rate", 0.0))
    return Origin(clip.activity, facts.get("source", ""), system, folder, clip.subject)


def source_caution(clips: Sequence[Origin]) -> str:
    """A caution if sources, or else people, of the ranked clips coincide with activities; else ""."""
    activities = [clip.activity for clip in clips]
    for groups in _ways(clips):
        if source_of := confined(activities, groups):
            return (
                f"{SOURCES} apart, not the activities: {_sources(source_of)}; take all activities from the "
                "same sources, or compare within each"
            )
    people = [clip.subject for clip in clips]
    person_of = confined(activities, people) if all(people) else {}
    if person_of and 2 * len(person_of) >= len(set(activities)):
        return (
            f"the ranking may tell people apart, not the activities: {_sources(person_of)}; have several "
            "people show every activity"
        )
    return ""


def confined(activities: Sequence[str], groups: Sequence[str]) -> dict[str, str]:
    """The activities that practically one group alone shows, with it, if half of the others are elsewhere.

    `activities` and `groups` are those of each clip.
    """
    names, row = np.unique(np.asarray(activities), return_inverse=True)
    kinds, column = np.unique(np.asarray(groups), return_inverse=True)
    if len(names) < 2 or len(kinds) < 2:
        return {}
    share = np.zeros((len(names), len(kinds)))
    np.add.at(share, (row, column), 1.0)
    share /= share.sum(axis=1, keepdims=True)
    overlap = np.minimum(share[:, None], share[None]).sum(axis=2)
    strangers = (overlap < STRANGERS).sum(axis=1)
    apart = (share.max(axis=1) >= ALONE) & (2 * strangers >= len(names) - 1)
    return {str(names[a]): str(kinds[share[a].argmax()]) for a in np.flatnonzero(apart)}


def _ways(clips: Sequence[Origin]) -> list[list[str]]:
    """Groupings of the clips by source: that of the labels, else by system and by folder."""
    if all(clip.source for clip in clips):
        return [[clip.source for clip in clips]]
    folders = [clip.folder for clip in clips]
    several = {folder: {clip.activity for clip in clips if clip.folder == folder} for folder in set(folders)}
    ways = [[clip.source or clip.system for clip in clips]]
    if all(folders) and all(len(shows) > 1 for shows in several.values()):
        ways.append(folders)  # a folder of one activity is named for it, not for a source
    return ways


def _sources(source_of: dict[str, str]) -> str:
    """The activities that each source shows alone, in words; the sources with most of them first."""
    counts = Counter(source_of.values()).most_common()
    parts = []
    for number, (source, count) in enumerate(counts[:NAMED]):
        activities = [activity for activity, name in source_of.items() if name == source]
        verb = " comes" if count == 1 else " come"
        parts.append(f"{join_words(activities)}{verb if number == 0 else ''} from {source} alone")
    more = len(counts) - NAMED
    return ", ".join(parts) + (f", and others from {more} more" if more > 0 else "")


def f1_alone(
    utility: UtilityMap,
    clips: Sequence[LabelledClip],
    origins: Sequence[Origin],
    durations: Sequence[float],
    config: StudyConfig,
) -> dict[str, float]:
    """Macro F1 by the duration of a clip alone, s, and by its source alone, in folds like a ranking's.

    What is the same in all clips is left out.
    """
    sources = [origin.source or origin.system for origin in origins]
    known = [source for source, _ in Counter(sources).most_common(MOST_SOURCES)]
    features = np.zeros((len(clips), 2, len(known)), dtype=np.float32)
    features[:, 0, 0] = np.log(np.maximum(durations, 1e-3))
    features[:, 1] = np.array(sources)[:, None] == known
    some = [number for number, clip in enumerate(clips) if clip.activity in utility.activities]
    whole = [ClipWindows(np.ones(1, dtype=bool), NO_SIGNATURE)] * len(some)
    labels, features = WindowLabels.of([clips[number] for number in some], whole), features[some]
    f1 = utility_map(features, labels.protocol(config), resamples=1, halvings=0).mean.tolist()
    differs = np.ptp(features, axis=0).any(axis=1)
    return {what: round(f1[row], DIGITS) for row, what in enumerate(("duration", "source")) if differs[row]}
