# SPDX-License-Identifier: GPL-3.0-or-later
"""Does a run's advice hold for other clips? Disjoint halves choose, and each other's raw F1 judges."""

from dataclasses import replace

import numpy as np
import scipy

from w2w.core.body.body import Body
from w2w.core.patches.patches import PatchSet
from w2w.core.ranking.classifiers.ridge import Ridge
from w2w.core.ranking.halves import deal_halves
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap, utility_map
from w2w.core.selection.scored import PlaceScore, ScoredMap
from w2w.core.study.config import StudyConfig
from w2w.core.study.ranking import WindowLabels
from w2w.core.windows.features import CHANNELS, STATISTICS
from w2w.core.windows.inputs import BLOCK_BYTES, PatchBlocks, SomeWindows, spans

FEWEST_MOTIONS = 4
"""Motions of an activity of which each half has two, to train on one and test on the other."""

GOOD, HEAVY = 0.02, 0.05
"""Loss of F1 up to which a product does as well, and beyond which a loss is heavy."""

FIGURES = (
    "expected", "delivered", "gain", "by raw F1", "rho", "ceiling", "stated", "did", "holds",
    "as well", "lose", "within", "heavy", "cost holds", "knowing: lose", "knowing: within", "knowing: heavy",
    "recommended", "belt clip", "watch", "energy", "random", "most", "worse",
)  # fmt: skip
"""For a choice: F1 expected of the chosen patch and its raw F1 on the other half; how much that is above an
average patch's, and the same of the patch of the highest raw F1; Spearman's rho of the expected map with
the other half's raw map, and the root of the raw maps'; the stated chance of beating an average patch,
whether it did, and the share of patches whose interval holds the other half's F1. Of products other than
the best: the share said to do as well, what those lose on the other half, how many of them lose at most .02
there, how many of those that lose more than .05 are told from them, and the share whose cost's interval holds
what they lose; then what would be if those were said to do as well whose raw F1 on all clips, the other half
included, is at most .02 lower; NaN on drawn libraries. Last what the recommended place, a belt clip, a watch,
the product that moves most, any product and the other half's own best patch deliver above an average patch,
and whether the recommended place is worse than a belt clip by more than .05. NaN on some patches only, which
no product may be near."""

ALWAYS = ("belt clip", "watch")
"""What people might wear whatever they do."""

FEWEST_DRAWN, MOST_DRAWN, MOTIONS_DRAWN = 3, 8, (8, 12, 20, 60)
"""Activities of a drawn library, and the most motions of each, of which one is drawn."""

SPREAD = STATISTICS.index("std") * len(CHANNELS) + CHANNELS.index("|acc|")
"""Number of the feature that tells how much a sensor is moved."""

OF_PRODUCTS = 15
"""The last of these, which are of products."""


def choices(
    inputs: PatchBlocks,
    labels: WindowLabels,
    config: StudyConfig,
    places: tuple[PatchSet, Body] | None,
    halvings: int,
    by_subject: bool,
    drawn: bool = False,
) -> np.ndarray:
    """Figures of every choice, both ways of each halving, shape (2 * halvings, figures).

    Halves share no motion, or no subject. If libraries are `drawn`, each halving is of some of the activities
    and motions; one whose halves do not test the same activities is left out. Raises ValueError if there is
    too little to halve.
    """
    names, code = np.unique(labels.activity, return_inverse=True)
    motions = [len(np.unique(labels.motion[code == number])) for number in range(len(names))]
    rows = np.flatnonzero(np.array(motions)[code] >= FEWEST_MOTIONS)
    some, config = labels.some(rows), replace(config, by_subject=by_subject)
    code = np.unique(some.activity, return_inverse=True)[1]
    if not len(rows) or code.max() == 0 or (by_subject and len(np.unique(some.subject)) < FEWEST_MOTIONS):
        raise ValueError(
            f"halves need two activities of {FEWEST_MOTIONS} motions or more each"
            + f", and {FEWEST_MOTIONS} subjects" * by_subject
        )
    found, pooling = [], Pooling.on(*places[::-1]) if places else None
    moved = _moved(inputs, rows) if places and config.classifier == Ridge.name else None

    def ranked(part: np.ndarray) -> UtilityMap:
        protocol = some.some(part).protocol(config)
        return utility_map(SomeWindows(inputs, rows[part]), protocol, config.classifier, pooling=pooling)

    everything = np.ones(len(rows), dtype=bool)
    whole = None if drawn else ranked(everything)
    rng = np.random.default_rng([config.seed, 5])
    for number in range(halvings):
        part = _drawn(some, rng) if drawn else everything
        within = code[part], (some.subject if by_subject else some.motion)[part]
        unit = (np.zeros_like(within[0]), within[1]) if by_subject else within
        *_, of_part = deal_halves(*unit, config.seed + drawn * number, 1 if drawn else number + 1)
        sides = [part.copy() for _ in range(2)]
        sides[0][part], sides[1][part] = of_part, ~of_part
        maps = [ranked(side) for side in sides]
        if maps[0].activities != maps[1].activities:
            continue
        for (here, there), side in zip((maps, maps[::-1]), sides, strict=True):
            of_products = (np.nan,) * OF_PRODUCTS
            if places:
                energy = None if moved is None else moved[side].mean(axis=0)
                of_products = _products_judged(ScoredMap(here, *places), there, whole, energy)
            found.append((*_judged(here, there), *of_products))
    return np.array(found)


def _drawn(labels: WindowLabels, rng: np.random.Generator) -> np.ndarray:
    """Windows of some activities and some motions of each, shape (W,), bool."""
    names = np.unique(labels.activity)
    most = min(MOST_DRAWN, len(names))
    some = rng.choice(names, rng.integers(min(FEWEST_DRAWN, most), most + 1), replace=False)
    count, part = rng.choice(MOTIONS_DRAWN), np.zeros(len(labels.activity), dtype=bool)
    for name in some:
        here = labels.activity == name
        part |= here & np.isin(labels.motion, rng.permutation(np.unique(labels.motion[here]))[:count])
    return part


def _moved(inputs: PatchBlocks, rows: np.ndarray) -> np.ndarray:
    """How much each sensor is moved in some windows, shape (W, N)."""
    parts = [inputs.patches(span)[rows, :, SPREAD] for span in spans(inputs, BLOCK_BYTES)]
    return np.exp(np.concatenate(parts, axis=1))


def _judged(here: UtilityMap, there: UtilityMap) -> tuple[float, ...]:
    """The first of `FIGURES`: of the patch that one half chooses."""
    best, average = int(here.expected_mean.argmax()), there.mean.mean()
    delivered = there.mean[best]
    return (
        here.expected_mean[best],
        delivered,
        delivered - average,
        there.mean[here.mean.argmax()] - average,
        _rho(here.expected_mean, there.mean),
        np.sqrt(max(_rho(here.mean, there.mean), 0.0)),
        here.beats_average,
        float(delivered > average),
        ((here.expected_low <= there.mean) & (there.mean <= here.expected_high)).mean(),
    )


def _products_judged(
    here: ScoredMap, there: UtilityMap, whole: UtilityMap | None, energy: np.ndarray | None
) -> tuple[float, ...]:
    """The rest of `FIGURES`: of what one half says of products, and of what all clips would say.

    `energy` (N,) is how much each patch is moved, if that is known.
    """
    if here.patches.labels.max() >= len(here.patches):
        return (np.nan,) * OF_PRODUCTS
    others = [score for score in here.products if score.under != here.base.under]
    loses = np.array([_lost(there, here.base, score) for score in others])
    as_good = np.array([score.cost.as_good for score in others])
    held = [score.cost.low <= lose <= score.cost.high for score, lose in zip(others, loses, strict=True)]
    knowing: tuple[np.ndarray, ...] = (np.array([]),) * 3
    if whole is not None:
        knowing = _worded(loses, np.array([_lost(whole, here.base, score) for score in others]) <= GOOD)
    parts = [*_worded(loses, as_good), held, *knowing]
    worn = {score.name: score for score in here.products}
    at = [here.base, *(worn.get(name) for name in ALWAYS)]
    at.append(None if energy is None else max(worn.values(), key=lambda score: energy[score.patch]))
    gains = [np.nan if score is None else _delivered(there, score) for score in at]
    anyone = np.mean([_delivered(there, score) for score in worn.values()])
    above = np.array([*gains, anyone, there.mean.max()]) - there.mean.mean()
    worse = np.nan if at[1] is None else float(gains[0] < gains[1] - HEAVY)
    return (as_good.mean(), *(np.mean(part) if len(part) else np.nan for part in parts), *above, worse)


def _delivered(there: UtilityMap, score: PlaceScore) -> float:
    """The raw F1 of a product on other clips, over all patches that it moves over."""
    return float(there.mean[list(score.under)].mean())


def _lost(there: UtilityMap, base: PlaceScore, score: PlaceScore) -> float:
    return _delivered(there, base) - _delivered(there, score)


def _worded(loses: np.ndarray, as_good: np.ndarray) -> tuple[np.ndarray, ...]:
    """What products lose that are said to do as well, whether by little, and who of heavy losers is not."""
    return loses[as_good], loses[as_good] <= GOOD, ~as_good[loses > HEAVY]


def _rho(one: np.ndarray, other: np.ndarray) -> float:
    return float(scipy.stats.spearmanr(one, other)[0]) if np.ptp(one) > 0 and np.ptp(other) > 0 else np.nan
