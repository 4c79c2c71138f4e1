# SPDX-License-Identifier: GPL-3.0-or-later
"""One answer to "where should the sensor go?": products that can be worn, or a region, in one sentence."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from ..body.body import Body
from ..patches.body_parts import PRODUCT_NAMED, PRODUCTS, Product, great_part, segment, side_of
from ..patches.naming import FAR_M, nearest_patch, place, resolve
from ..patches.patches import PatchSet
from ..ranking.utility import UtilityMap
from ..wording import capital, plain_words
from .headline import as_good_as, mean_caution, short

NAMED = 2
"""Most products in the sentence."""

SHOWN = 0.005
"""Smallest F1 difference that two digits show."""

MOST_OF = 0.8
"""Share of a part's patches that must tie before the sentence says that the part ties."""


def best_single(utility: UtilityMap, allowed: np.ndarray | None = None) -> int:
    """The allowed patch with the highest expected macro F1; if equal, with the highest on these clips."""
    open_patches = np.arange(len(utility.mean)) if allowed is None else np.flatnonzero(allowed)
    order = np.lexsort((-utility.mean[open_patches], -utility.expected_mean[open_patches]))
    return int(open_patches[order[0]])


@dataclass(frozen=True)
class PlaceScore:
    """One sensor on a product, or at a place by name, scored from the map."""

    name: str  # "watch", "left wrist"
    phrase: str  # "a watch"
    side: str  # the better side; "" if both do as well or there is only one place
    patch: int  # the patch nearest to where the sensor usually sits
    expected: float  # macro F1 on other clips; a loose product's is the mean of the patches it moves over
    low: float
    high: float
    costs: float  # expected F1 below that of the best allowed patch
    as_good: bool  # ties with the best


@dataclass(frozen=True)
class Answer:
    """Where to wear one sensor."""

    where: str  # "a belt clip or a chest strap", "anywhere on the body", "left thigh front (9 by 14 cm)"
    patch: int  # the patch recommended
    expected: float  # macro F1 there on other clips; of two products, the lower one
    low: float
    high: float
    caution: str  # in place of the interval, if there are too few clips for one
    differs: bool  # these clips show that some places are better than others
    other: PlaceScore | None  # the commonest product that does worse
    ties: str  # a sentence on where else does as well; "" if no whole part does
    named: tuple[PlaceScore, ...]  # products in `where`
    products: tuple[PlaceScore, ...]  # all products that fit the wishes, best first

    def sentence(self) -> str:
        """The answer in words, the same on every page and panel."""
        interval = self.caution or f"{short(self.low)} to {short(self.high)}"
        best = f"{capital(self.where)}: F1 {short(self.expected)} ({interval})."
        if not self.differs:
            return f"{best} These clips cannot show that one place is better."
        if self.other and (less := self.expected - self.other.expected) >= SHOWN:
            return f"{best} {capital(self.other.phrase)} costs {short(less)}."
        return best


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map whose products and places are scored under a designer's wishes."""

    utility: UtilityMap
    patches: PatchSet
    body: Body
    limits: np.ndarray | None = None  # (N,), bool: patches that the wishes leave; all by default

    @cached_property
    def allowed(self) -> np.ndarray:
        """The patches that may be recommended, shape (N,), bool."""
        return np.ones(len(self.patches), bool) if self.limits is None else self.limits

    @cached_property
    def best(self) -> int:
        """The allowed patch of highest expected F1."""
        return best_single(self.utility, self.allowed)

    @cached_property
    def group(self) -> np.ndarray:
        """Numbers of the allowed patches as good as the best."""
        return as_good_as(self.best, self.utility, self.allowed)

    @cached_property
    def products(self) -> tuple[PlaceScore, ...]:
        """Every product that has an allowed patch, best first."""
        scores = (self.product(product, product.sides) for product in PRODUCTS.values())
        return _best_first(score for score in scores if score)

    def product(self, product: Product, sides: Sequence[str]) -> PlaceScore | None:
        """A product on the better of some sides; None if no allowed patch is near."""
        scores, at = [], product_places(self.patches, self.body)
        for side in sides:
            patch = at.get((product.name, side))
            if patch is None or not self.allowed[patch]:
                continue
            words = [f"{side} {region}".strip() for region in product.wanders]
            under = [number for number, region in enumerate(self.patches.regions) if region in words]
            scores.append(self.at(product.name, product.phrase, side, patch, under or [patch]))
        if not scores:
            return None
        better = max(scores, key=lambda score: score.expected)
        tie = len(scores) > 1 and self.utility.same(scores[0].patch, scores[1].patch)
        return replace(better, side="") if tie else better

    def named(self, word: str) -> PlaceScore:
        """The score of a product or place by name; ValueError for an unknown name."""
        side, rest = side_of(plain_words(word))
        product = PRODUCT_NAMED.get(rest)
        sides = () if product is None else (side,) if side in product.sides else product.sides
        if product and (score := self.product(product, sides)):
            return score
        patch = resolve(word, self.body, self.patches, lambda _: None)
        return self.at(word, word, "", patch, [patch])

    def at(self, name: str, phrase: str, side: str, patch: int, under: Sequence[int]) -> PlaceScore:
        """A sensor that moves over the patches `under`."""
        expected, low, high = (float(values[under].mean()) for values in self.utility.expected)
        costs = float(self.utility.expected_mean[self.best]) - expected
        as_good = bool(np.isin(under, self.group).all())
        return PlaceScore(name, phrase, side, patch, expected, low, high, costs, as_good)


def answer(scored: ScoredMap) -> Answer:
    """Recommend what can be worn among the patches as good as the best."""
    utility, allowed, products = scored.utility, scored.allowed, scored.products
    tying = [score for score in products if score.as_good]
    named: list[PlaceScore] = []
    worse, by_rarity = [score for score in products if not score.as_good], list(PRODUCTS)
    other = min(worse, key=lambda score: by_rarity.index(score.name), default=None)
    differs = utility.can_rank and not len(scored.group) == allowed.sum() > 1
    if not differs:
        where = "anywhere on the body" if allowed.all() else "anywhere that is allowed"
        patch = products[0].patch if products else scored.best
        f1 = [float(values[allowed].mean()) for values in utility.expected]
    elif tying:
        first = segment(scored.patches.regions[tying[0].patch])
        elsewhere = [score for score in tying if segment(scored.patches.regions[score.patch]) != first]
        named = [tying[0], *elsewhere][:NAMED]
        where, patch = " or ".join(score.phrase for score in named), named[0].patch
        lowest = min(named, key=lambda score: score.expected)
        f1 = [lowest.expected, lowest.low, lowest.high]
    else:
        where, patch = _region(scored)
        f1 = [float(values[patch]) for values in utility.expected]
    expected, low, high = f1
    return Answer(
        where=where, patch=patch, expected=expected, low=low, high=high, caution=mean_caution(utility),
        differs=differs, other=other, ties=ties_text(scored.group, scored.patches) if differs else "",
        named=tuple(named), products=products,
    )  # fmt: skip


def compare(scored: ScoredMap, words: Sequence[str]) -> tuple[PlaceScore, ...]:
    """Scores of products and places by name, best first; ValueError for an unknown name."""
    return _best_first(map(scored.named, words))


def _best_first(scores: Iterable[PlaceScore]) -> tuple[PlaceScore, ...]:
    return tuple(sorted(scores, key=lambda score: -score.expected))


@lru_cache(maxsize=4)
def product_places(patches: PatchSet, body: Body) -> dict[tuple[str, str], int]:
    """The patch nearest to each product, by name and side; left out are those with none within 10 cm."""
    patch_at = {}
    for product in PRODUCTS.values():
        for side in product.sides:
            patch, away_m = nearest_patch(place(product.on(side), body), body, patches)
            if away_m <= FAR_M:
                patch_at[product.name, side] = patch
    return patch_at


def product_patches(patches: PatchSet, body: Body) -> dict[int, str]:
    """The patches at which usual products sit, each with the commonest product's side and name."""
    names: dict[int, str] = {}
    for (name, side), patch in product_places(patches, body).items():
        names.setdefault(patch, f"{side} {name}".strip())
    return names


def ties_text(group: np.ndarray, patches: PatchSet) -> str:
    """A sentence on where else does as well, the largest part first; "" if no whole part does."""
    tie = np.isin(np.arange(len(patches)), group)
    names: list[str] = []
    covered = np.zeros(len(patches), bool)
    for part_of in (great_part, segment):
        parts = np.array([side_of(part_of(region))[1] for region in patches.regions])
        stems, count = np.unique(parts, return_counts=True)
        for stem in stems[np.argsort(-count, kind="stable")].tolist():
            inside = parts == stem
            if tie[inside].mean() >= MOST_OF and not covered[inside].any():
                sided = any(side_of(part_of(patches.regions[patch]))[0] for patch in np.flatnonzero(inside))
                names.append({"foot": "feet"}.get(stem, f"{stem}s") if sided else stem)
                covered |= inside
    if not names:
        return ""
    *others, last = names if len(names) <= 4 else [*names[:3], f"{len(names) - 3} other parts"]
    words = f"{', '.join(others)} or {last}" if others else last
    return f"Anywhere on {words} does as well."


def _region(scored: ScoredMap) -> tuple[str, int]:
    """The region that holds most of the best patches, with its size in words, and its middle patch."""
    patches, group = scored.patches, scored.group
    regions, above = np.array(patches.regions)[group], scored.utility.expected_mean[group]
    above = above - above.min()
    held = {name: (above[regions == name].sum(), (regions == name).sum()) for name in sorted(set(regions))}
    region = max(held, key=lambda name: held[name])
    members = group[regions == region]
    centres = scored.body.vertices[patches.vertices[members]]
    middle = int(members[np.linalg.norm(centres[:, None] - centres, axis=2).sum(axis=1).argmin()])
    skin = scored.body.vertices[np.isin(patches.labels, members)]
    axes = np.linalg.svd(skin - skin.mean(axis=0), full_matrices=False)[2]
    long, wide = 100 * np.ptp(skin @ axes[:2].T, axis=0)
    return f"{region} ({long:.0f} by {wide:.0f} cm)", middle
