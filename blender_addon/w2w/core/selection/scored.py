# SPDX-License-Identifier: GPL-3.0-or-later
"""Products, places by name and regions, scored from a map under a designer's wishes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np

from ..body.body import Body
from ..patches.body_parts import HABIT, PRODUCT_NAMED, PRODUCTS, Product, product_called, side_of
from ..patches.naming import FAR_M, nearest_patch, place, resolve
from ..patches.patches import PatchSet
from ..ranking.costs import EQUAL, KEPT, Cost, as_shown, cost_of, is_as_good
from ..ranking.utility import ExpectedF1, UtilityMap
from ..wording import InShort, capital, plain_words
from .headline import short


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
    side: str  # the better side; "" if both are as good or there is only one place
    patch: int  # the patch nearest to where the sensor usually sits
    under: tuple[int, ...]  # the patches that it moves over
    expected: float  # macro F1 on other clips; a loose product's is the mean of its patches
    low: float
    high: float
    cost: Cost  # against the recommended place
    by_activity: Mapping[str, float] = field(default_factory=dict, compare=False)  # F1 of each

    def in_short(self) -> str:
        """Its F1 with the interval, and what it costs."""
        mean, low, high = map(short, self.f1)
        where = f"{self.side} {self.name}".strip()
        return f"{where}: F1 {mean} ({low} to {high}), costs {short(self.cost.expected)}"

    @property
    def f1(self) -> ExpectedF1:
        """F1 on other clips, and its interval."""
        return ExpectedF1(self.expected, self.low, self.high)


@dataclass(frozen=True, eq=False)
class ScoredMap:
    """A map whose products and places are scored under a designer's wishes."""

    utility: UtilityMap
    patches: PatchSet
    body: Body | None  # None for places by their names alone: each is a product of its own
    limits: np.ndarray | None = None  # (N,), bool: patches that the wishes leave; all by default
    habit: str = HABIT  # the product that people wear anyway

    @cached_property
    def allowed(self) -> np.ndarray:
        """The patches that may be recommended, shape (N,), bool."""
        return np.ones(len(self.patches), bool) if self.limits is None else self.limits

    @cached_property
    def best(self) -> int:
        """The allowed patch of highest expected F1."""
        return best_single(self.utility, self.allowed)

    @cached_property
    def kept(self) -> PlaceScore | None:
        """What people wear anyway; None if it may not be worn here."""
        name = self.habit if self.body is None else product_called(self.habit).name
        return next((score for score in self._on_products if score.name == name), None)

    @cached_property
    def base(self) -> PlaceScore:
        """The recommended place, which all costs are against.

        It is the best product or a better region, or the habit if that is hardly worse.
        """
        found, habit = self._chosen, self.kept
        if habit is None:
            return found
        return habit if as_shown(cost_of(self.utility, found.under, habit.under).expected) <= KEPT else found

    @property
    def _chosen(self) -> PlaceScore:
        """The best product, or a region if it is better."""
        best = _commonest(self._on_products)
        if best and is_as_good(float(self.utility.expected_mean[self.best]) - best.expected):
            return best
        assert self.body is not None  # the best of places by name is one of them
        region, patch = _region(self, self.body)
        return self._at(region, region, "", patch, (patch,))

    @cached_property
    def products(self) -> tuple[PlaceScore, ...]:
        """Every product that has an allowed patch, best first; the recommended one before all."""
        others = _best_first(self._on_products)
        return tuple(
            self._with_cost(score) for score in sorted(others, key=lambda score: score.name != self.base.name)
        )

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
        alike = worse and is_as_good(better.expected - worse[0].expected)
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
        of_each = self.utility.expected_f1[list(under)].mean(axis=0).tolist()
        f1 = dict(zip(self.utility.activities, of_each, strict=True))
        none = Cost(0.0, 0.0, 0.0)
        return PlaceScore(name, phrase, side, patch, tuple(under), expected, low, high, none, by_activity=f1)

    def _with_cost(self, score: PlaceScore) -> PlaceScore:
        return replace(score, cost=cost_of(self.utility, self.base.under, score.under))


def compare(scored: ScoredMap, words: Sequence[str]) -> tuple[PlaceScore, ...]:
    """Scores of products and places by name, best first; ValueError for an unknown name."""
    return _best_first(map(scored.named, words))


def compare_known(scored: ScoredMap, words: Sequence[str]) -> tuple[tuple[PlaceScore, ...], list[str]]:
    """Like `compare`, but for unknown names, of each of which a sentence says what is known."""
    known, unknown = [], []
    for word in words:
        try:
            known.append(scored.named(word))
        except ValueError as error:
            unknown.append(f"{capital(error)}.")
    return _best_first(known), unknown


def _best_first(scores: Iterable[PlaceScore]) -> tuple[PlaceScore, ...]:
    return tuple(sorted(scores, key=lambda score: -score.expected))


def _commonest(commonest_first: Sequence[PlaceScore]) -> PlaceScore | None:
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
    group = np.flatnonzero(scored.allowed & is_as_good(expected[scored.best] - expected))
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
