# SPDX-License-Identifier: GPL-3.0-or-later
"""One answer to "where should the sensor go?": a product that can be worn, or a region, in a sentence."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from ..body.body import Body
from ..patches.body_parts import PRODUCT_NAMED, PRODUCTS, Product, great_part, side_of
from ..patches.naming import FAR_M, nearest_patch, place, resolve
from ..patches.patches import PatchSet
from ..ranking.costs import EQUAL, Cost, cost, does_as_well
from ..ranking.expected import LIKELY, SURE
from ..ranking.stream import ExpectedF1, Stream
from ..ranking.utility import UtilityMap
from ..wording import InShort, capital, listed, plain_words
from .headline import mean_caution, per_cent, short

OTHERS = 3
"""Most other products in the sentence."""

PLURALS = {each.phrase for each in PRODUCTS.values() if not each.phrase.startswith(("a ", "an ", "the "))}
"""Products that are spoken of in the plural."""

HABIT = "belt clip"
"""The product that stands for what people wear anyway."""


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed patch with the highest expected macro F1; if equal, with the highest on these clips."""
    open_patches = np.arange(len(utility.mean)) if allowed is None else np.flatnonzero(allowed)
    order = np.lexsort((-utility.mean[open_patches], -utility.expected_mean[open_patches]))
    return int(open_patches[order[0]])


@dataclass(frozen=True, repr=False)
class PlaceScore(InShort):
    """One sensor on a product, or at a place by name, scored from the map."""

    name: str  # "watch", "left wrist"
    phrase: str  # "a watch"
    side: str  # the better side; "" if both do as well or there is only one place
    patch: int  # the patch nearest to where the sensor usually sits
    under: tuple[int, ...]  # the patches that it moves over
    expected: float  # macro F1 on other clips, cut out; a loose product's is the mean of its patches
    low: float
    high: float
    cost: Cost  # against the recommended place
    in_stream: ExpectedF1 | None = None  # the same in a stream of other clips, where that is known
    by_activity: Mapping[str, float] = field(
        default_factory=dict, compare=False
    )  # F1 of each on other clips, cut out

    def in_short(self) -> str:
        """Its F1 with the interval, and what it costs."""
        f1, costs = self.in_stream or self.cut_out, max(self.cost.expected, 0.0)
        interval = f"({short(f1.low)} to {short(f1.high)})"
        return f"{f'{self.side} {self.name}'.strip()}: F1 {short(f1.mean)} {interval}, costs {short(costs)}"

    @property
    def cut_out(self) -> ExpectedF1:
        """F1 on other clips, cut out."""
        return ExpectedF1(self.expected, self.low, self.high)


def compared(scores: Sequence[PlaceScore]) -> str:
    """What places do against the recommended one, in a sentence; "" without any."""
    as_good = [score.phrase for score in scores if score.cost.as_good]
    clauses = [f"{listed(as_good)} {'do' if _many(as_good) else 'does'} as well"] if as_good else []
    for may in (True, False):
        rest = [score for score in scores if not score.cost.as_good and score.cost.may == may]
        if rest:
            verb = "may cost" if may else "cost" if _many([rest[0].phrase]) else "costs"
            named = [f"{score.phrase} {short(score.cost.expected)}" for score in rest[1:]]
            first = f"{rest[0].phrase} {verb} {short(rest[0].cost.expected)}"
            clauses.append(", ".join([first, *named]))
    return f"{capital('; '.join(clauses))}." if clauses else ""


def _many(phrases: Sequence[str]) -> bool:
    """Whether a verb after these phrases is in the plural, as after "glasses"."""
    return len(phrases) > 1 or phrases[0] in PLURALS


@dataclass(frozen=True, repr=False)
class Answer(InShort):
    """Where to wear one sensor."""

    where: str  # "a belt clip", "anywhere on the body", "left thigh front (29 by 14 cm)"
    patch: int  # the patch recommended
    expected: float  # macro F1 there on other clips, cut out
    low: float
    high: float
    in_stream: ExpectedF1 | None  # in a stream of them, if that is known
    caution: str  # in place of the interval, if there are too few clips for one
    differs: bool  # these clips show that some places are better than others
    halved: bool  # halves of the clips tell how sure that is
    chance: float  # that the place does better than an average one on other clips
    gain: float  # expected F1 above that of an average place
    over_habit: float | None  # and above that of a belt clip; None if it is one, or none is allowed
    base: PlaceScore  # the place that all costs are against
    product: str  # the product in `where`; "" if there is none
    others: tuple[PlaceScore, ...]  # the commonest product of each other great part of the body
    products: tuple[PlaceScore, ...]  # all products that fit the wishes, best first

    @property
    def cut_out(self) -> ExpectedF1:
        """F1 on other clips, cut out."""
        return ExpectedF1(self.expected, self.low, self.high)

    def in_short(self) -> str:
        """The answer in words."""
        return self.sentence()

    def sentence(self) -> str:
        """The answer in words, the same on every page and panel."""
        found = (" in a stream", self.in_stream) if self.in_stream else (" on clips cut out", self.cut_out)
        best = f"{capital(self.where)}: F1 {self._f1(*found)}."
        if not self.differs:
            return f"{best} These clips cannot show that one place is better."
        if self.chance < SURE:
            chance = f"it beats an average place with {per_cent(self.chance)}"
            best = f"{best} These clips hardly tell places apart; {chance}."
        return f"{best} {compared(self.others)}".strip()

    def _f1(self, measured: str, found: ExpectedF1) -> str:
        """An F1, what it is measured on, and its interval or why there is none."""
        interval = self.caution or f"{short(found.low)} to {short(found.high)}"
        return f"{short(found.mean)}{measured} ({interval})"

    def measured(self) -> str:
        """What the F1 is measured on, in a sentence."""
        if self.in_stream is None:
            return "Each window of a clip cut out holds that clip alone; in use, F1 is lower"
        cut_out = f"On clips cut out F1 is {self._f1('', self.cut_out)}"
        return f"In a stream, clips follow each other with standing between them. {cut_out}"

    def lead(self) -> str:
        """How far it is ahead of an average place and of what people wear anyway; "" if nothing tells."""
        if not self.halved:
            return ""
        if self.gain < 0:
            return "It is not expected to do as well as an average place on the whole body"
        where = "It" if self.differs else "The best place"
        ahead = f"{where} beats an average place on other clips by about {short(self.gain)}"
        sure = f"{ahead} ({per_cent(self.chance)} sure)"
        if self.over_habit is None:
            return sure
        if does_as_well(self.over_habit):
            return f"{sure}; a {HABIT} does as well"
        return f"{sure} and a {HABIT} by {short(self.over_habit)}"


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map whose products and places are scored under a designer's wishes."""

    utility: UtilityMap
    patches: PatchSet
    body: Body | None  # None for places by their names alone: each is a product of its own
    limits: np.ndarray | None = None  # (N,), bool: patches that the wishes leave; all by default
    stream: Stream | None = None  # the clips, if F1 in a stream of them can be found

    @cached_property
    def allowed(self) -> np.ndarray:
        """The patches that may be recommended, shape (N,), bool."""
        return np.ones(len(self.patches), bool) if self.limits is None else self.limits

    @cached_property
    def best(self) -> int:
        """The allowed patch of highest expected F1."""
        return best_single(self.utility, self.allowed)

    @cached_property
    def base(self) -> PlaceScore:
        """The recommended place, which all costs are against: the best product or a better region."""
        best = _recommended(self._on_products)
        if best and does_as_well(float(self.utility.expected_mean[self.best]) - best.expected):
            return best
        assert self.body is not None  # the best of places by name is one of them
        region, patch = _region(self, self.body)
        return self._at(region, region, "", patch, (patch,))

    @cached_property
    def products(self) -> tuple[PlaceScore, ...]:
        """Every product that has an allowed patch, best first; the recommended one before its equals."""
        listed_first = _recommended(self._on_products)
        others = (score for score in self._on_products if score is not listed_first)
        return tuple(
            replace(self._with_cost(score), in_stream=self.in_stream([score.patch], score.cut_out))
            for score in filter(None, (listed_first, *_best_first(others)))
        )

    def in_stream(self, worn: Sequence[int], cut_out: ExpectedF1) -> ExpectedF1 | None:
        """F1 in a stream of other clips, from that on clips cut out; None if nothing tells."""
        return None if self.stream is None else self.stream.expected(worn, cut_out)

    @cached_property
    def _on_products(self) -> list[PlaceScore]:
        """The same, the commonest first (of places by name the best), before their costs are known."""
        if self.body is None:
            places = enumerate(self.patches.names)
            return [*_best_first(self._at(name, name, "", n, (n,)) for n, name in places if self.allowed[n])]
        scores = (self._product(product, product.sides) for product in PRODUCTS.values())
        return [score for score in scores if score]

    def _product(self, product: Product, sides: Sequence[str], anywhere: bool = False) -> PlaceScore | None:
        """A product on the better of some sides; None if no patch is near that is allowed, or any."""
        scores, at = [], product_places(self.patches, self.body)
        for side in sides:
            patch = at.get((product.name, side))
            if patch is None or not (anywhere or self.allowed[patch]):
                continue
            words = [f"{side} {region}".strip() for region in product.wanders]
            under = [number for number, region in enumerate(self.patches.regions) if region in words]
            scores.append(self._at(product.name, product.phrase, side, patch, under or [patch]))
        if not scores:
            return None
        *worse, better = sorted(scores, key=lambda score: score.expected)
        alike = worse and does_as_well(better.expected - worse[0].expected)
        return replace(better, side="") if alike else better

    def named(self, word: str) -> PlaceScore:
        """The score of a product or place by name; ValueError for an unknown name."""
        side, rest = side_of(plain_words(word))
        product = PRODUCT_NAMED.get(rest) if self.body is not None else None
        sides = () if product is None else (side,) if side in product.sides else product.sides
        if product and (score := self._product(product, sides, anywhere=True)):
            return self._with_cost(score)
        patch = resolve(word, self.body, self.patches, lambda _: None)
        return self._with_cost(self._at(word, word, "", patch, [patch]))

    def _at(self, name: str, phrase: str, side: str, patch: int, under: Sequence[int]) -> PlaceScore:
        """A sensor that moves over the patches `under`, before its cost is known."""
        expected, low, high = (float(values[list(under)].mean()) for values in self.utility.expected)
        f1 = dict(
            zip(
                self.utility.activities,
                self.utility.expected_f1[list(under)].mean(axis=0).tolist(),
                strict=True,
            )
        )
        none = Cost(0.0, 0.0, 0.0, False)
        return PlaceScore(name, phrase, side, patch, tuple(under), expected, low, high, none, by_activity=f1)

    def _with_cost(self, score: PlaceScore) -> PlaceScore:
        return replace(score, cost=cost(self.utility, self.base.under, score.under))


def answer(scored: ScoredMap) -> Answer:
    """Recommend the best product, or the best region if no product does as well."""
    utility, allowed, base = scored.utility, scored.allowed, scored.base
    products = {score.name: score for score in scored.products}
    is_product = base.name in products
    where, expected, low, high = base.phrase, base.expected, base.low, base.high
    chance = utility.chance(base.expected)
    differs = (chance if allowed.all() else utility.beats_average) >= LIKELY
    if not differs:
        everywhere = "anywhere on the body" if scored.body is not None else "any of these places"
        where = everywhere if allowed.all() else "anywhere that is allowed"
        expected, low, high = (float(values[allowed].mean()) for values in utility.expected)
    elif not is_product:
        where = f"{base.phrase}, no usual product there"
    habit = products.get(HABIT) if base.name != HABIT else None
    return Answer(
        where=where, patch=base.patch, expected=expected, low=low, high=high, caution=mean_caution(utility),
        in_stream=scored.in_stream([base.patch], ExpectedF1(expected, low, high)),
        differs=differs, halved=utility.halved, chance=chance,
        gain=base.expected - float(utility.expected_mean.mean()),
        over_habit=habit.cost.expected if habit else None,
        base=base, product=base.name if is_product and differs else "",
        others=_others(scored) if differs else (), products=scored.products,
    )  # fmt: skip


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
    return _best_first(others)[:OTHERS]


def compare(scored: ScoredMap, words: Sequence[str]) -> tuple[PlaceScore, ...]:
    """Scores of products and places by name, best first; ValueError for an unknown name."""
    return _best_first(map(scored.named, words))


def _best_first(scores: Iterable[PlaceScore]) -> tuple[PlaceScore, ...]:
    return tuple(sorted(scores, key=lambda score: -score.expected))


def _recommended(commonest_first: Sequence[PlaceScore]) -> PlaceScore | None:
    """The best product, or the commonest of its equals: else the seed of the folds would decide."""
    most = max((score.expected for score in commonest_first), default=0.0)
    return next((score for score in commonest_first if most - score.expected <= EQUAL), None)


@lru_cache(maxsize=4)
def product_places(patches: PatchSet, body: Body | None) -> dict[tuple[str, str], int]:
    """The patch nearest to each product, by name and side; left out are those with none within 10 cm."""
    patch_at: dict[tuple[str, str], int] = {}
    if body is None:
        return patch_at
    for product in PRODUCTS.values():
        for side in product.sides:
            patch, away_m = nearest_patch(place(product.on(side), body), body, patches)
            if away_m <= FAR_M:
                patch_at[product.name, side] = patch
    return patch_at


def product_patches(patches: PatchSet, body: Body | None) -> dict[int, str]:
    """The patches at which usual products sit, each with the commonest product's side and name."""
    names: dict[int, str] = {}
    for (name, side), patch in product_places(patches, body).items():
        names.setdefault(patch, f"{side} {name}".strip())
    return names


def _region(scored: ScoredMap, body: Body) -> tuple[str, int]:
    """Where most of the best patches are, in words, and the middle one; all of a region or a spot on it."""
    patches, expected = scored.patches, scored.utility.expected_mean
    group = np.flatnonzero(scored.allowed & does_as_well(expected[scored.best] - expected))
    regions_of = np.array(patches.regions)
    regions, above = regions_of[group], expected[group]
    above = above - above.min()
    held = {name: (above[regions == name].sum(), (regions == name).sum()) for name in sorted(set(regions))}
    region = max(held, key=lambda name: held[name])
    members = group[regions == region]
    centres = body.vertices[patches.vertices[members]]
    middle = int(members[np.linalg.norm(centres[:, None] - centres, axis=2).sum(axis=1).argmin()])
    skin = body.vertices[np.isin(patches.labels, members)]
    axes = np.linalg.svd(skin - skin.mean(axis=0), full_matrices=False)[2]
    long, wide = 100 * np.ptp(skin @ axes[:2].T, axis=0)
    size, whole = f"{long:.0f} by {wide:.0f} cm", len(members) == (regions_of == region).sum()
    return (f"{region} ({size})" if whole else f"a spot of {size} on the {region}"), middle
