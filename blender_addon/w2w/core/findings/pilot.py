# SPDX-License-Identifier: GPL-3.0-or-later
"""A pilot: people wore a sensor at a place or two, and the level of the whole map goes by what it showed.

The order of places stays as the clips give it (docs/evidence/pilot.md).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy

from ..imu.clock import at_rate
from ..imu.recordings import Recordings
from ..library.labels import same_label
from ..patches.body_parts import PRODUCTS
from ..ranking.classifiers.ridge import Ridge
from ..ranking.f1 import window_f1
from ..ranking.halves import CrossValidation
from ..ranking.utility import ExpectedF1, UtilityMap, utility_map
from ..ranking.weights import mean_over
from ..selection.answer import find_answer
from ..selection.headline import short
from ..selection.scored import PlaceScore, ScoredMap
from ..study.choosing import scored_map
from ..study.config import StudyConfig
from ..study.ranking import WindowLabels
from ..study.results import StudyResults
from ..windows.inputs import PatchBlocks, as_blocks, cut_recordings
from ..wording import InShort, join_words, restated
from .cautions import KNOW, WEAKENS, Caution

SHARE = 0.8
"""Share of each activity's difference at the worn places that is taken over everywhere."""

ERRORS_LEFT = {2: 0.6, 3: 0.85}
"""Of so many people each is tested on a classifier of one or two others: what more people leave of 1 - F1."""

LEFT_OPEN = {1: 0.18, 2: 0.165}
"""Half of the 90 % interval at a place that was not worn, by how many were, without the people's spread."""

OF_TWO = 0.2
"""The same for two people."""

LEVEL = 0.9
"""Confidence of a pilot's intervals."""


def learned(worn: np.ndarray, people: int) -> np.ndarray:
    """F1 that was worn as more people would show it, from that of so many."""
    return 1 - (1 - worn) * ERRORS_LEFT.get(people, 1.0)


def levelled(expected: np.ndarray, difference: np.ndarray) -> np.ndarray:
    """F1 (N, A) expected everywhere, by how far it differs at the worn places (A,), worn less expected."""
    return np.clip(expected + SHARE * difference, 0, 1)


def half_width(by_person: np.ndarray, places: int, at_worn: bool = False) -> float:
    """Half of the 90 % interval of macro F1 at a place.

    `by_person` (P,): macro F1 of each person, the mean over the worn places.
    """
    people = len(by_person)
    if at_worn:
        reach = scipy.special.stdtrit(people - 1, (1 + LEVEL) / 2)
        return float(reach * by_person.std(ddof=1) / np.sqrt(people))
    return width_with(float(by_person.std(ddof=1)), people, places)


def width_with(spread: float, people: int, places: int) -> float:
    """The same where so many people whose F1 spreads so far wore so many places."""
    site = OF_TWO if people == 2 else LEFT_OPEN[min(places, max(LEFT_OPEN))]
    return float(np.hypot(site, scipy.special.ndtri((1 + LEVEL) / 2) * spread / np.sqrt(people * places)))


def by_chance(truth: np.ndarray, predicted: np.ndarray, unit: Sequence[str], n_activities: int) -> float:
    """Macro F1 that one of twenty draws of labels among the clips reaches, with these predictions.

    `truth`, `predicted` (W,) of int; `unit` (W,): clip of each window.
    """
    rng = np.random.default_rng(0)
    _, first, of = np.unique(unit, return_index=True, return_inverse=True)
    drawn = [macro_f1(rng.permutation(truth[first])[of], predicted, n_activities) for _ in range(200)]
    return float(np.quantile(drawn, 0.95))


def macro_f1(truth: np.ndarray, predicted: np.ndarray, n_activities: int) -> float:
    """Macro F1 over the activities that are shown."""
    f1 = window_f1(predicted, truth, n_activities)
    return float(f1[~np.isnan(f1)].mean())


FEWEST_PEOPLE = 2
"""People whom a pilot takes; the advice on what to record next adds as many."""


class WornPlace(NamedTuple):
    """What recordings showed at a place."""

    name: str
    under: tuple[int, ...]  # the patches that stand for it
    f1: dict[str, float]  # of each activity, as it was
    by_person: dict[str, float]  # macro F1
    chance: float  # macro F1 that labels dealt by chance may reach
    seconds: float

    @property
    def mean(self) -> float:
        """Macro F1."""
        return float(np.mean([*self.f1.values()]))


@dataclass(frozen=True, eq=False, repr=False)
class Pilot(InShort):
    """F1 as a pilot's people would show it, at every patch, beside what was expected without."""

    utility: UtilityMap
    worn: tuple[WornPlace, ...]
    place: PlaceScore  # what the answer recommends, with F1 without the pilot
    expected_f1: np.ndarray  # (N, A)
    cautions: tuple[Caution, ...]
    skipped: tuple[tuple[str, str], ...] = ()

    @cached_property
    def people(self) -> tuple[str, ...]:
        """Who wore the sensors."""
        return tuple(sorted(set().union(*(one.by_person for one in self.worn))))

    @cached_property
    def by_person(self) -> np.ndarray:
        """Macro F1 of each, (P,), the mean over the places that they wore."""
        of = [[one.by_person[who] for one in self.worn if who in one.by_person] for who in self.people]
        return np.array([np.mean(f1) for f1 in of])

    def f1(self, place: PlaceScore | None = None) -> ExpectedF1:
        """Macro F1 at a place, with its 90 % interval; by default where the answer recommends."""
        under = list((place or self.place).under)
        mean = float(mean_over(self.expected_f1[under], self.utility.weights).mean())
        half = half_width(self.by_person, len(self.worn), self._was_worn(under))
        return ExpectedF1(mean, max(mean - half, 0.0), min(mean + half, 1.0))

    def _was_worn(self, under: Sequence[int]) -> bool:
        return any(set(under) & set(one.under) for one in self.worn)

    @property
    def where(self) -> str:
        """The recommended place in words."""
        return f"the {f'{self.place.side} {self.place.name}'.strip()}"

    def sentence(self) -> str:
        """What the pilot says of the recommended place: the same on every page and panel."""
        f1, minutes = self.f1(), max(round(sum(one.seconds for one in self.worn) / 60), 1)
        who = f"{join_words([one.name for one in self.worn])}, {len(self.people)} people, {minutes} min"
        return (
            f"With your pilot ({who}): F1 {short(f1.mean)} ({short(f1.low)} to {short(f1.high)}) at "
            f"{self.where}; without: {short(self.place.expected)}."
        )

    in_short = sentence

    def next(self) -> str:
        """What to record next, with what it would leave open."""
        people, own = len(self.people), self._was_worn(self.place.under)
        now, there = (half_width(self.by_person, len(self.worn), at) for at in (own, True))
        more = half_width(np.resize(self.by_person, people + FEWEST_PEOPLE), len(self.worn), own)
        minutes = max(round(FEWEST_PEOPLE / people * sum(one.seconds for one in self.worn) / 60), 1)
        said = f"Two more people (about {minutes} min) leave ± {short(min(more, now))} of ± {short(now)}."
        if own or there >= now:
            return said
        return f"The same people with a sensor at {self.where} too leave about ± {short(there)}. {said}"

    def content(self) -> dict[str, Any]:
        """It as plain values, for `summary.json`."""
        f1 = self.f1()
        return {
            "sentence": self.sentence(),
            "next": self.next(),
            "patch": self.place.patch,
            "expected_f1": round(f1.mean, 4),
            "expected_f1_interval": [round(f1.low, 4), round(f1.high, 4)],
            "without": round(self.place.expected, 4),
            "people": len(self.people),
            "cautions": [caution._asdict() for caution in self.cautions],
            "skipped": [list(each) for each in self.skipped],
            "worn": [
                {
                    "place": one.name,
                    "minutes": round(one.seconds / 60, 1),
                    "f1": round(one.mean, 4),
                    "f1_of": {name: round(f1, 4) for name, f1 in one.f1.items()},
                }
                for one in self.worn
            ],
        }


class RankedMap(NamedTuple):
    """What a pilot is held against."""

    scored: ScoredMap
    config: StudyConfig
    inputs: PatchBlocks | np.ndarray
    labels: WindowLabels


def of_folder(study: StudyResults, recordings: Path, at: str) -> Pilot:
    """A pilot by a folder of recordings, worn `at` a place if they do not say it; as for `pilot`."""
    config, utility = study.config(), study.utility
    read = Recordings.read(recordings, None, at, utility.activities, config.synthesis.rate_hz)
    scored = scored_map(utility, study.patches, study.body(), config)
    if not at:
        how = f"say where it was worn, as by --at watch ({', '.join(PRODUCTS)} or a part of the body):"
        with restated(how, ValueError):
            _ = [scored.named(name) for name in read.places]
    return pilot(RankedMap(scored, config, study.inputs(config.classifier), study.labels()), read)


def pilot(ranked: RankedMap, recordings: Recordings) -> Pilot:
    """Move a map's level to what people's recordings at a place or two show.

    Raises ValueError if W2W has no such place, or fewer than two people or activities can be tested.
    """
    utility, config = ranked.scored.utility, ranked.config
    if ranked.scored.body is None or config.classifier != Ridge.name or config.further.features:
        raise ValueError("a pilot needs simulated signals ranked by 'ridge', without further ones")
    same = Recordings([at_rate(one, config.synthesis.rate_hz) for one in recordings])
    at = {name: ranked.scored.named(name).under for name in recordings.places}
    left = next((f"left out {file}: {why}; of the rest:" for file, why in recordings.skipped), "")
    with restated(left, ValueError):
        shown = [_worn(same.at(name), name, under, ranked) for name, under in at.items()]
    chance = any(one.mean <= one.chance for one in shown)
    differences = [_difference(ranked, one, chance) for one in shown]
    moved = np.mean(differences, axis=0)
    # what shows nothing is taken whole: the level is then that of chance
    levels = levelled(utility.expected_f1, moved / SHARE if chance else moved)
    for one, difference in zip(shown, differences, strict=True):
        under = list(one.under)
        levels[under] = np.clip(utility.expected_f1[under] + difference, 0, 1)
    return Pilot(
        utility, tuple(shown), find_answer(ranked.scored).base, levels,
        tuple(_cautions(utility, recordings, shown, chance)), recordings.skipped,
    )  # fmt: skip


def _difference(ranked: RankedMap, one: WornPlace, chance: bool) -> np.ndarray:
    """Worn less expected F1 of each activity at a place, (A,); of those not shown the mean."""
    utility = ranked.scored.utility
    lost = np.zeros(len(utility.activities)) if utility.lost is None else utility.lost
    expected = utility.expected_f1[list(one.under)].mean(axis=0) + lost + _easier(ranked, one)
    columns = [utility.activities.index(name) for name in one.f1]
    f1 = np.array([*one.f1.values()])
    own = (f1 if chance else learned(f1, len(one.by_person))) - expected[columns]
    found = np.full(len(utility.activities), own.mean())
    found[columns] = own
    return found


def _worn(recordings: Recordings, name: str, under: tuple[int, ...], ranked: RankedMap) -> WornPlace:
    """F1 at a place, one person left out at a time."""
    config, known = ranked.config, {same_label(one): one for one in ranked.scored.utility.activities}
    some = [one for one in recordings if same_label(one.activity) in known]
    if people := {one.subject for one in some} - {""}:
        some = [one for one in some if one.subject]
    if len(people) < FEWEST_PEOPLE:
        named = join_words(sorted(people)) or "nobody"
        raise ValueError(
            f"a pilot takes two people at least; the recordings at {name} name {named} in activities of the "
            f"study ({join_words(list(ranked.scored.utility.activities))}): say who in labels.csv, "
            "or by folders"
        )
    if not all(one.gyr.any() for one in some):
        some = [replace(one, gyr=np.zeros_like(one.gyr)) for one in some]
    cut = cut_recordings(some, config.windows)
    used = [some[number] for number in cut.used]
    if not used:
        raise ValueError(f"no recording at {name} gives a window: {next(iter(cut.skipped.values()))}")
    labels = [(known[same_label(one.activity)], one.clip, one.subject) for one in used]
    activity, clip, subject = np.repeat(np.array(labels).T, [len(mask) for mask in cut.is_test], axis=1)
    inputs, is_test = np.concatenate(cut.inputs), np.concatenate(cut.is_test)
    names = ranked.scored.utility.activities
    protocol = CrossValidation(activity, clip, subject, is_test, names, seed=config.seed)
    found, n = utility_map(inputs, protocol, halvings=0), len(names)
    predicted, tested = found.predictions[:, 0], np.isin(clip, found.clip)
    by_person = {
        who: macro_f1(found.truth[rows := np.isin(found.clip, clip[subject == who])], predicted[rows], n)
        for who in dict.fromkeys(subject[tested].tolist())
    }
    return WornPlace(
        name, under, dict(zip(found.activities, found.f1[0].tolist(), strict=True)), by_person,
        by_chance(found.truth, predicted, found.clip.tolist(), n),
        sum(one.n_samples / one.rate for one in used),
    )  # fmt: skip


def _easier(ranked: RankedMap, worn: WornPlace) -> np.ndarray:
    """How much higher the map's F1 at a patch is among the pilot's activities alone, (A,)."""
    utility, names = ranked.scored.utility, [*worn.f1]
    gained = np.zeros(len(utility.activities))
    if len(names) == len(utility.activities):
        return gained
    protocol = replace(ranked.labels.protocol(ranked.config), activities=names, counts=None)
    alone = utility_map(as_blocks(ranked.inputs).patches([*worn.under]), protocol, halvings=0)
    for column, name in enumerate(alone.activities):
        row = utility.activities.index(name)
        gained[row] = (alone.f1[:, column] - utility.f1[list(worn.under), row]).mean()
    return gained


def _cautions(
    utility: UtilityMap, recordings: Recordings, shown: Sequence[WornPlace], chance: bool
) -> list[Caution]:
    found, worst = [], min(shown, key=lambda one: one.mean - one.chance)
    if chance:
        f1 = f"F1 {short(worst.mean)}, by chance up to {short(worst.chance)}"
        text = f"what the recordings at {worst.name} show is no better than chance ({f1})"
        found.append(Caution(WEAKENS, f"{text}: look at their labels, and whether the sensor sat there"))
    if missing := sorted(set(utility.activities) - set().union(*(one.f1 for one in shown))):
        found.append(
            Caution(KNOW, f"nothing was recorded of {join_words(missing)}: they move as the others do")
        )
    if not all(one.gyr.any() for one in recordings):
        found.append(Caution(KNOW, "not all recordings have angular velocity: acceleration alone is taken"))
    return found
