# SPDX-License-Identifier: GPL-3.0-or-later
"""What speaks against an answer: one list, in the same words in report, panel, console, Python and files."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..imu.cover import caught_sentences
from ..imu.sensor import FULL_SCALE
from ..library.labels import same_label
from ..motion.up import SAY_UP
from ..ranking.expected import HALF
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.folds import left_out_sentences
from ..ranking.utility import UtilityMap
from ..reading.clips import ITS_OWN
from ..selection.headline import by_posture, short
from ..selection.scored import best_single
from ..study.config import StudyConfig
from ..study.ranking import LabelledClip, copies_among
from ..wording import capital, count, join_words
from .sources import SOURCES, f1_alone, origin_of, source_caution

STOPS, WEAKENS, KNOW = "stops the answer", "weakens the answer", "good to know"
"""Weights of a caution, the heaviest first."""

NEARLY_ALL = 0.9
"""Share of F1 from which one thing alone tells nearly all; of five libraries posture's highest was .72."""

BY_CHANCE = 0.3
"""Least F1 above that of guesses: labels dealt by chance reach it in one of twenty libraries of 12 clips."""

POSTURES = "the place tells postures, not movements"
"""Beginning of the caution on them."""

DIFFER = "the activities may differ by it more than by movement"

ALONE = {
    "posture": POSTURES
    + ": the direction of gravity alone gives F1 {}. Whoever holds still in these postures "
    "is taken for moving",
    "duration": "a clip's duration alone gives F1 {}: " + DIFFER + ". Take clips of about one length",
    "source": "a clip's source alone gives F1 {}: " + DIFFER + ". Take all activities from the same sources",
}
"""Cautions on what tells nearly all by itself, with a gap for the two F1."""

OPEN = 2
"""Cautions beside an answer, the heaviest; the rest is folded."""

LONG_WINDOW = 1.5
"""Windows longer than so many median clips are cautioned against: in use they hold more than one activity."""

ODD = {"cut", "at_full_scale", "cloth_caught", "up_guessed", "rest_guessed"}
"""Facts of a clip that only some have."""

Facts = Mapping[str, Any]
"""What a clip's record says of it."""


class Caution(NamedTuple):
    """What a reader of an answer must know, and what it does to the answer."""

    weight: str
    text: str
    f1: Mapping[str, float] = {}  # what each thing that it says tells alone, for programs

    def sentence(self) -> str:
        """The caution as every door says it."""
        return f"{capital(self.weight)}: {self.text}."


def cautions(
    utility: UtilityMap,
    clips: Sequence[LabelledClip],
    facts: Iterable[Facts],
    config: StudyConfig,
    on_cloth: str = "",
    patch: int | None = None,
) -> list[Caution]:
    """The cautions on a ranking of clips, given with the facts of each, the heaviest first.

    `patch` is the one recommended, if it is known; `on_cloth` is the `cover_sentence`.
    """
    durations, origins, odd = [], [], []
    for clip, about in zip(clips, facts, strict=True):
        durations.append(about["duration_s"])
        origins.append(origin_of(clip, about))
        if ODD & about.keys():
            odd.append((clip.name, about))
    ranked = [origin for origin in origins if origin.activity in utility.activities]
    place = best_single(utility) if patch is None else patch
    told = f1_alone(utility, clips, origins, durations, config)
    by = join_words([f"{short(f1)} by its {what}" for what, f1 in told.items()])
    guessed = Caution(KNOW, f"guessing a clip without its movement gives F1 {by}" if by else "", dict(told))
    told |= {} if patch is None else {"posture": by_posture(utility, patch)}
    stops = source_caution(ranked)
    said = {"source"} if stops.startswith(SOURCES) else set()
    shared = subjects_sentence(clips) if config.by_subject else ""
    found = [
        window_caution(config.windows.length_s, durations),
        Caution(STOPS, stops),
        *(alone_caution(utility, what, f1, place) for what, f1 in told.items() if what not in said),
        Caution(WEAKENS, _reliability(utility)),
        Caution(WEAKENS, _few_clips(utility)),
        Caution(WEAKENS, _left_out(utility)),
        *(Caution(WEAKENS, text) for text in (shared, full_scale_sentence(odd), config.synthesis.caution)),
        *(Caution(WEAKENS, text) for text in caught_sentences(odd)),
        Caution(WEAKENS if utility.left_out else KNOW, copies_sentence(copies_among(clips, clips))),
        guessed,
        *(Caution(KNOW, text) for text in (_up(odd), _rests(odd), cut_sentence(odd), on_cloth)),
    ]
    return heaviest_first(found)


def heaviest_first(found: Iterable[Caution]) -> list[Caution]:
    """The cautions that have a text, by weight."""
    order = (STOPS, WEAKENS, KNOW)
    return sorted((each for each in found if each.text), key=lambda each: order.index(each.weight))


def head(answer: str, found: Iterable[Caution]) -> str:
    """What stands on top: the answer, or what stops it."""
    stops = next((each.text for each in found if each.weight == STOPS), "")
    return f"No answer yet: {stops}." if stops else answer


def below(found: Sequence[Caution]) -> list[Caution]:
    """The cautions that stand below the answer: all but the one that stops it, which is said in its place."""
    stops = next((number for number, each in enumerate(found) if each.weight == STOPS), None)
    return [each for number, each in enumerate(found) if number != stops]


def window_caution(length_s: float, durations: Sequence[float]) -> Caution:
    """A caution on windows that are longer than clips, of these durations, s; without text if none is."""
    shorter = sum(duration < length_s for duration in durations)
    if not shorter:
        return Caution(KNOW, "")
    median = float(np.median(durations))
    of_clips = f"{shorter} of {count('clip', len(durations))}"
    if length_s <= LONG_WINDOW * median:
        text = f"{of_clips} {'is' if shorter == 1 else 'are'} repeated to fill a window of {length_s:g} s"
        return Caution(WEAKENS if 2 * shorter >= len(durations) else KNOW, text)
    return Caution(
        STOPS,
        f"windows of {length_s:g} s are {length_s / median:.1f} times as long as the median clip "
        f"({median:.1f} s), and {of_clips} are repeated to fill them. In use each holds more than one "
        "activity, and F1 is lower. Take windows of at most "
        f"{math.floor(10 * LONG_WINDOW * median) / 10:g} s",
    )


def alone_caution(utility: UtilityMap, what: str, alone: float, patch: int) -> Caution:
    """A caution on one of `ALONE`; without text unless its F1 is nearly all of a patch's, and no guess."""
    f1, guessed = utility.expected_mean[patch], 1 / np.count_nonzero(utility.counts)
    told = alone >= max(NEARLY_ALL * f1, guessed + BY_CHANCE)
    return Caution(
        WEAKENS, ALONE[what].format(f"{short(alone)}, the whole signal {short(f1)}") if told else ""
    )


def _reliability(utility: UtilityMap) -> str:
    if not utility.reliability < HALF:
        return ""
    repeats = "less than half of its contrast repeats on other clips"
    return f"map reliability is {short(utility.reliability)}: {repeats}"


def _few_clips(utility: UtilityMap) -> str:
    counts = utility.tested_clips()
    few = sum(clips < FEWEST_CLIPS for clips in counts)
    if not few:
        return ""
    return (
        f"{few} of {len(counts)} ranked activities {'has' if few == 1 else 'have'} fewer than {FEWEST_CLIPS} "
        f"clips (the fewest: {min(counts)}), too few for an interval: intervals of the mean are narrower "
        "than they should be"
    )


def _left_out(utility: UtilityMap) -> str:
    left = len(utility.left_out)
    if not left:
        return ""
    verb = "is" if left == 1 else "are"
    reasons = "; ".join(left_out_sentences(utility.left_out))
    return f"{left} of {count('activity', left + len(utility.activities))} {verb} not ranked: {reasons}"


def subjects_sentence(clips: Sequence[LabelledClip]) -> str:
    """A sentence on the subjects whose clips show the motion of another subject's clip; "" without any."""
    subjects: dict[str, set[str]] = {}
    for clip in clips:
        subjects.setdefault(clip.motion_key, set()).add(same_label(clip.subject))
    shared = [clip for clip in clips if len(subjects[clip.motion_key]) > 1]
    if not shared:
        return ""
    subjects_in_words = join_words(sorted({clip.subject for clip in shared}))
    return (
        f"{len(shared)} clips of {subjects_in_words} show the same motion as another subject's clip: "
        "each motion is tested with the first of its subjects, and never trained on then"
    )


LACKS = "no sensor was worn at"
"""Beginning of the reason to skip a clip of worn sensors that lacks one."""


def worn_cautions(
    clips: Sequence[LabelledClip], skipped: Sequence[tuple[str, str]], by_subject: bool
) -> list[Caution]:
    """The cautions on clips of worn sensors and on those skipped, each with the reason."""
    lacking = [f"{clip} ({why})" for clip, why in skipped if why.startswith(LACKS)]
    verb = "lacks" if len(lacking) == 1 else "lack"
    left = (
        f"{count('clip', len(lacking))} {verb} a sensor and take no part, as all places are compared on the "
    )
    people = {same_label(clip.subject) for clip in clips}
    same = "people who are tested are trained on, too: leave one subject out for F1 on other people"
    return [
        *([Caution(WEAKENS, f"{left}same clips: {join_words(lacking)}")] if lacking else []),
        *([Caution(KNOW, same)] if not by_subject and len(people) > 1 and "" not in people else []),
    ]


def full_scale_sentence(clips: Iterable[tuple[str, Facts]]) -> str:
    """A caution on clips, given with their records, that read the sensor's full scale too often; else ""."""
    shares = {name: record["at_full_scale"] for name, record in clips if "at_full_scale" in record}
    if not shares:
        return ""
    most = max(shares, key=lambda name: shares[name])
    return (
        f"{count('clip', len(shares))} read the sensor's full scale in more than "
        f"{100 * FULL_SCALE:g} % of the samples (the most: {most}, {100 * shares[most]:.0f} %): look at the "
        "motion, or take a sensor of a wider range"
    )


def copies_sentence(copies: Sequence[tuple[str, str]]) -> str:
    """A sentence on the clips that are copies, each with the first that shows its motion; "" without any."""
    if not copies:
        return ""
    copied = "1 clip counts as a copy" if len(copies) == 1 else f"{len(copies)} clips count as copies"
    return (
        f"{copied} of another, by motion_key or by how the body moves, and no clip is tested on its copies: "
        + join_words([f"{name} (of {first})" for name, first in copies])
    )


def _up(clips: Sequence[tuple[str, Facts]]) -> str:
    axes = [record["up_guessed"] for _, record in clips if "up_guessed" in record]
    if not axes:
        return ""
    return (
        f"{' or '.join(sorted(set(axes)))} is taken as up in {count('clip', len(axes))}, by how people stand "
        f"in them, or where none stands as is usual: if that is wrong, {SAY_UP}"
    )


def _rests(clips: Sequence[tuple[str, Facts]]) -> str:
    """A sentence on the clips whose rest pose is a guess; "" without any."""
    origins = Counter(record["rest_guessed"] for _, record in clips if "rest_guessed" in record)
    if not origins:
        return ""
    alone = origins[ITS_OWN]
    what = f"the rest pose of {count('clip', origins.total())} is a guess, one for each skeleton"
    own = f", but for {alone} by the clip's own motion" if alone else ""
    return f"{what}{own}: arms and legs may be turned about their length, alike in all clips of a skeleton"


def cut_sentence(clips: Iterable[tuple[str, Facts]]) -> str:
    """A sentence on the clips, given with their records, that lost frames at their ends; "" without any."""
    cut = [f"{name} ({record['cut']})" for name, record in clips if "cut" in record]
    return f"{count('clip', len(cut))} cut at the ends: {join_words(cut)}" if cut else ""
