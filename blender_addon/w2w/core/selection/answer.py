# SPDX-License-Identifier: GPL-3.0-or-later
"""One answer to "where should the sensor go?": a product that can be worn, or a region, in a sentence."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..patches.body_parts import PRODUCTS, great_part, side_of
from ..ranking.costs import MOMENT, Cost, as_shown, gain
from ..ranking.f1 import FEWEST_CLIPS
from ..ranking.utility import ExpectedF1, UtilityMap
from ..wording import InShort, capital, join_words
from .headline import by_posture, mean_caution, moments, short, tenths
from .scored import PlaceScore, ScoredMap

OTHERS = 3
"""Most other products in the sentence."""

ALIKE = 0.05
"""Most that any product may cost, by its interval, where places are said to be alike."""

NUMBERS = "One", "Two", "Three", "Four"

HALF_OF_IT = "count on half of that lead"
"""What leads that were said delivered on other clips was nearer to half of them (docs/evidence/habit.md)."""

NO_PRODUCT = "no usual product sits"


def comparison(scores: Sequence[PlaceScore]) -> str:
    """What places do against the recommended one, in a sentence; "" without any."""
    clauses = [good] if (good := as_good_as_it(scores)) else []
    for may in (True, False):
        rest = [score for score in scores if not score.cost.as_good and score.cost.may == may]
        if rest:
            verb = "may cost" if may else "costs"
            named = [f"{score.phrase} {short(score.cost.expected)}" for score in rest[1:]]
            first = f"{rest[0].phrase} {verb} {short(rest[0].cost.expected)}"
            clauses.append(", ".join([first, *named]))
    return f"{capital('; '.join(clauses))}." if clauses else ""


def as_good_as_it(scores: Sequence[PlaceScore]) -> str:
    """Which places are as good as the recommended one; "" if none is."""
    as_good = [score.phrase for score in scores if score.cost.as_good]
    return f"{join_words(as_good)} {'are' if len(as_good) > 1 else 'is'} as good" if as_good else ""


@dataclass(frozen=True, repr=False)
class Answer(InShort):
    """Where to wear one sensor."""

    where: str  # "a belt clip", "anywhere on the body", "a sensor on the left thigh front (29 by 14 cm)"
    patch: int  # the patch recommended
    in_stream: bool  # whether F1 is in a stream of clips; else each window holds one alone
    caution: str  # in place of the interval, if there are too few clips for one
    differs: bool  # some places may be better than others; else all are shown to do alike
    habit: PlaceScore | None  # what people wear anyway; None if it may not be worn here
    gain: Cost | None  # what can be counted on over the habit; None without one
    more: str  # what would tell most, if the clips are few
    base: PlaceScore  # the place that all costs are against
    posture: float  # F1 by the direction of gravity alone; NaN if it is not known
    product: str  # the product in `where`; "" if there is none
    others: tuple[PlaceScore, ...]  # the commonest product of each other great part of the body
    products: tuple[PlaceScore, ...]  # all products that fit the wishes, best first

    @property
    def f1(self) -> ExpectedF1:
        """F1 at the patch on other clips."""
        return self.base.f1

    @property
    def keeps(self) -> bool:
        """Whether the answer is what people wear anyway."""
        return self.habit is not None and self.habit.under == self.base.under

    def in_short(self) -> str:
        """The answer in words."""
        return self.sentence()

    def sentence(self) -> str:
        """What to wear, how good it is and what else would do: the same on every page and panel."""
        tells = f"It will tell {moments(self.f1, interval=not self.caution)}"
        if not self.differs:
            return f"Wear it {self.where}: all places do alike. {tells}."
        known = "; ".join(filter(None, [tells, as_good_as_it(self.others)]))
        return " ".join(filter(None, [self._wear(), "" if self.gain_shown else f"{known}.", self.more]))

    @property
    def gain_shown(self) -> bool:
        """Whether it is shown to do better than the habit, by enough clips."""
        said = not self.keeps and not self.more and self.gain
        return bool(said and as_shown(said.expected) >= MOMENT and said.low > 0)

    def _wear(self) -> str:
        """What to wear, against the habit."""
        if self.habit is None or self.gain is None:
            return f"Wear {self.where}."
        habit, start = self.habit.phrase, f"Start with {self.where}" if self.more else ""
        if self.keeps:
            named = f"the {habit.split(' ', 1)[1]}" if habit.startswith(("a ", "an ")) else habit
            return f"{start or f'Keep {named}'}: nothing tried is shown to do better here."
        if start:
            return f"{start}: it may do better than {habit}."
        if not self.gain_shown:
            return f"{capital(self.where)} may do better than {habit}; these clips cannot show by how much."
        there = tenths(self.habit.expected)
        right = f"it tells {moments(self.f1, interval=False)}, where {habit} tells {there}"
        return f"Wear {self.where}: {right}."

    def detail(self) -> str:
        """F1 with its interval, what can be counted on over the habit, and what others cost."""
        f1 = self.f1
        said = [f"F1 {short(f1.mean)} ({self.caution or f'{short(f1.low)} to {short(f1.high)}'})."]
        others = [score for score in self.others if self.gain_shown or not score.cost.as_good]
        if self.habit and self.gain and not self.keeps:
            others = [score for score in others if score.name != self.habit.name]
            if self.gain_shown:
                said.append(f"{capital(self.habit.phrase)}: {short(self.habit.expected)}; {HALF_OF_IT}.")
            else:
                others = [self.habit, *others]
        return " ".join(filter(None, [*said, comparison(others)]))

    def measured(self) -> str:
        """What the F1 is measured on, in a sentence."""
        if not self.in_stream:
            return "Each window holds one clip alone; in use, F1 is lower"
        text = "F1 is measured on clips played one after another, with standing in between"
        if np.isnan(self.posture):
            return text
        return f"{text}; posture alone (the direction of gravity) gives {short(self.posture)}"


def find_answer(scored: ScoredMap) -> Answer:
    """Recommend the best product, or the best region if no product is as good, or the habit."""
    utility, allowed, base, habit = scored.utility, scored.allowed, scored.base, scored.kept
    products = scored.products
    is_product = base.name in {score.name for score in products}
    differs = utility.few or any(score.cost.high > ALIKE or not score.cost.as_good for score in products)
    where = base.phrase if scored.body and is_product else f"a sensor at {base.phrase}"
    if not is_product:
        region = base.phrase if base.phrase.startswith("a spot") else f"the {base.phrase}"
        where = f"a sensor on {region}, where {NO_PRODUCT}"
    if not differs:
        everywhere = "anywhere on the body" if scored.body is not None else "at any of these places"
        where = everywhere if allowed.all() else "anywhere that is allowed"
    if habit:
        habit = next(score for score in products if score.name == habit.name)
    return Answer(
        where=where, patch=base.patch, in_stream=utility.lost is not None, caution=mean_caution(utility),
        differs=differs, habit=habit,
        gain=gain(utility, base.under, habit.under) if habit else None,
        more=_more(utility) if utility.few else "", base=base,
        posture=by_posture(utility, base.patch),
        product=base.name if is_product and differs else "",
        others=_others(scored) if differs else (), products=products,
    )  # fmt: skip


def _more(utility: UtilityMap) -> str:
    """Which clips would tell most, in a sentence: of the activity with the fewest."""
    if utility.by_subject:
        return "More people would tell most."
    counts = utility.tested_clips()
    lowest = utility.expected_f1.max(axis=0)
    fewest = min(range(len(counts)), key=lambda activity: (counts[activity], lowest[activity]))
    missing = max(FEWEST_CLIPS - counts[fewest], 1)
    clips = f"{NUMBERS[missing - 1]} more clip{'s' if missing > 1 else ''}"
    return f"{clips} of {utility.activities[fewest].replace('_', ' ')} would tell most."


def _others(scored: ScoredMap) -> tuple[PlaceScore, ...]:
    """The commonest product of each other great part of the body, the cheapest first."""

    def part(score: PlaceScore) -> str:
        return side_of(great_part(scored.patches.regions[score.patch]))[1] or "torso"

    if scored.body is None:
        return tuple(score for score in scored.products if score.under != scored.base.under)[:OTHERS]
    by_rarity, of_part = list(PRODUCTS), {part(scored.base): scored.base}
    for score in sorted(scored.products, key=lambda score: by_rarity.index(score.name)):
        of_part.setdefault(part(score), score)
    others = [score for score in of_part.values() if score is not scored.base]
    return tuple(sorted(others, key=lambda score: -score.expected))[:OTHERS]
