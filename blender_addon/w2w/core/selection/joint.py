# SPDX-License-Identifier: GPL-3.0-or-later
"""Sets chosen by the classifier that will be worn, and what such a set would reach on other clips."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from scipy.stats import norm
from threadpoolctl import threadpool_limits

from ..ranking.classifiers.ridge import Ridge
from ..ranking.expected import UNPROVEN
from ..ranking.halves import Plan, Trial
from ..ranking.inputs import PlaceBlocks, SomeWindows, as_blocks, spans
from ..ranking.joint_scores import JointScores, Training
from ..ranking.map_scores import class_auc, rank_score, window_f1
from ..ranking.planned import Planned, planned
from ..ranking.pooling import Pooling
from .subsets import ROUNDING, Terms, fewest

MOST_WINDOWS = 1000
"""Windows that a choice rests on, evenly drawn where there are more: time grows with their square."""

LARGEST_SET = 6
"""Sensors up to which sets are grown."""

FIRST_SETS = 3
"""Sensors up to which they are grown at first; more where more is wanted and may help."""

SET_HALVINGS = 2
"""Ways in which the clips are halved: each half chooses sets of its own, which takes most of the time."""

OF_HALVES = 128
"""Candidates that a half chooses among: the first of the patches, which lie as far apart as may be."""

RANDOM_SETS = 16
"""Sets drawn at random, whose mean F1 is the level above which a chosen set gains."""

Grow = Callable[["Tests", "Terms", int], tuple[int, ...]]
"""Chooses up to so many patches from the tests of a trial, in order."""


class Tests:
    """The tests of one trial: what a choice may look at, and what it is worth.

    Parameters
    ----------
    scores : JointScores
    labels : ndarray of int, shape (V,)
        Of the windows tested.
    trial : Trial
    n_activities : int
    pooling : Pooling
    """

    def __init__(
        self, scores: JointScores, labels: np.ndarray, trial: Trial, n_activities: int, pooling: Pooling
    ) -> None:
        self._scores, self._labels, self._trial = scores, labels, trial
        self._n_activities, self._pooling = n_activities, pooling
        self.grown: tuple[Terms | None, bool, tuple[int, ...]] = (None, False, ())

    @cached_property
    def alone(self) -> tuple[np.ndarray, np.ndarray]:
        """Rank score and F1 of each patch alone, shape (A, N) each."""
        maps = []
        for _, scores in self._scores.each_added((), range(self._scores.n_patches)):
            named = window_f1(scores.argmax(axis=1), self._labels, self._n_activities)
            maps.append((rank_score(scores, self._labels, self._trial.weight), named))
        compared, f1 = np.array(maps).transpose(1, 2, 0)
        return compared, f1

    @cached_property
    def single(self) -> np.ndarray:
        """What each patch alone is compared by, pooled over the skin, shape (N,)."""
        shown = self.alone[0][self._trial.testable]
        return self._pooling.apply(shown, self._pooling.learn([], len(shown))).mean(axis=0)

    def added(self, worn: Sequence[int], candidates: np.ndarray, worst: bool) -> np.ndarray:
        """Area under the ROC curve with each candidate added: the mean over activities, or the least."""
        shown = self._trial.testable
        areas = [
            class_auc(scores, self._labels, self._trial.weight)[shown]
            for _, scores in self._scores.each_added(worn, candidates.tolist())
        ]
        return np.min(areas, axis=1) if worst else np.mean(areas, axis=1)

    def f1_of_first(self, order: Sequence[int]) -> np.ndarray:
        """F1 by the first patch, the first two, and so on, shape (K, A); NaN where not tested."""
        found = [
            window_f1(scores.argmax(axis=1), self._labels, self._n_activities)
            for scores in self._scores.each_first(order)
        ]
        return np.where(self._trial.testable, found, np.nan)


@dataclass(frozen=True, eq=False)
class SetTests:
    """All that sets of patches are chosen and judged by.

    Attributes
    ----------
    whole : Tests
        On all clips.
    pairs : tuple of two Tests
        Of disjoint halves of them, or of single subjects.
    plan : Plan
    activities : tuple of str
    seed : int
    """

    whole: Tests
    pairs: tuple[tuple[Tests, Tests], ...]
    plan: Plan
    activities: tuple[str, ...]
    seed: int

    @classmethod
    def of(
        cls,
        inputs: np.ndarray | PlaceBlocks,
        activity: np.ndarray,
        clip: np.ndarray,
        subject: np.ndarray | None,
        is_test: np.ndarray,
        activities: Sequence[str],
        pooling: Pooling,
        folds: int = 5,
        seed: int = 0,
        workers: int = 2,
    ) -> SetTests:
        """Prepare the tests of a library, for features as `Ridge` takes them.

        Parameters and errors are those of `utility_map`.
        """
        activity, clip, is_test = np.asarray(activity), np.asarray(clip), np.asarray(is_test, dtype=bool)
        rows = _evenly(activity, clip, is_test, MOST_WINDOWS)
        subject = None if subject is None else np.asarray(subject)[rows]
        labels = (activity[rows], clip[rows], subject, is_test[rows])
        work = planned(*labels, activities, folds, seed, SET_HALVINGS)
        source = SomeWindows(as_blocks(inputs), rows[work.used])
        model = Ridge(workers=workers)
        ridge = float(np.median(model.choose_alphas(source, work.labels, work.fold, work.is_test)))
        features = _held(source)

        def tests(trial: Trial) -> Tests:
            scores = JointScores(features, work.labels, _trainings(work, trial), ridge, workers)
            return Tests(scores, work.labels[scores.windows], trial, len(work.activities), pooling)

        made = {trial: tests(trial) for trial in work.plan.trials}
        pairs = tuple((made[a], made[b]) for a, b in work.plan.pairs)
        return cls(made[work.plan.whole], pairs, work.plan, work.activities, seed)


def _trainings(work: Planned, trial: Trial) -> list[Training]:
    splits = [work.plan.splits[number] for number in trial.splits]
    return [Training(np.flatnonzero(np.isin(work.plan.block, split.train)), split.tested) for split in splits]


def _held(source: PlaceBlocks) -> np.ndarray:
    """Features (N, W, D) about their means, read once."""
    n_windows, n_patches, width = source.shape
    held = np.empty((n_patches, n_windows, width), dtype=np.float32)
    for first, last in spans(source):
        held[first:last] = source.places(first, last).swapaxes(0, 1)
        held[first:last] -= held[first:last].mean(axis=1, keepdims=True)
    return held


def _evenly(activity: np.ndarray, clip: np.ndarray, is_test: np.ndarray, most: int) -> np.ndarray:
    """At most so many windows, evenly over activities and clips, those that may be tested first."""
    if len(activity) <= most:
        return np.arange(len(activity))
    rows = np.flatnonzero(is_test) if is_test.sum() >= most else np.arange(len(activity))
    rows = rows[np.lexsort((rows, clip[rows], activity[rows]))]
    return np.sort(rows[np.linspace(0, len(rows) - 1, most).astype(int)])


def grow(
    tests: Tests,
    terms: Terms,
    size: int,
    first: np.ndarray | None = None,
    worst: bool = False,
    among: int | None = None,
    start: Sequence[int] = (),
) -> tuple[int, ...]:
    """Add the patch by which the classifier on all of them tells the activities apart best.

    Parameters
    ----------
    tests : Tests
    terms : Terms
        What may and must be chosen, and what it costs.
    size : int
    first : ndarray, shape (N,), optional
        What the first patch is chosen by; `tests.single` by default.
    worst : bool
        Whether the activity told apart worst decides, not the mean.
    among : int, optional
        How many candidates are looked at; all by default.
    start : sequence of int
        Chosen already.

    Returns
    -------
    tuple of int
        In order of choice.
    """
    order = list(start)
    with threadpool_limits(1):
        area = float(tests.added(order[:-1], np.array(order[-1:]), worst)[0]) if len(order) > 1 else 0.0
        while len(order) < min(size, terms.max_size):
            missing = [options for options in terms.required if not np.isin(order, options).any()]
            candidates = missing[0] if missing else np.setdiff1d(np.flatnonzero(terms.allowed), order)
            candidates = candidates[:among]
            if not len(candidates):
                break
            if order:
                value = tests.added(order, candidates, worst)
            else:
                value = (tests.single if first is None else first)[candidates]
            best = int(((value - area) / terms.cost[candidates]).argmax())
            area = float(value[best]) if order else 0.0
            order.append(int(candidates[best]))
    return tuple(order)


@dataclass(frozen=True, eq=False)
class Promise:
    """What sets chosen in one way would reach on other clips, by their size.

    Attributes
    ----------
    f1 : ndarray, shape (K, A)
    mean, low, high : ndarray, shape (K,)
        Macro F1, and its interval.
    raw : ndarray, shape (K, A)
        F1 on the clips that chose the set.
    """

    f1: np.ndarray
    mean: np.ndarray
    low: np.ndarray
    high: np.ndarray
    raw: np.ndarray


def promise(
    tests: SetTests,
    terms: Terms,
    order: Sequence[int],
    choose: Grow,
    alone: tuple[float, float, float],
    level: float = 0.95,
) -> Promise:
    """What the first patch of a set, the first two, and so on would reach on other clips.

    One half of the clips chooses a set in the same way, the other tells its F1 and that of sets
    drawn at random; what the choice gains over those, on average over halves and both ways, is added to
    what random sets reach on all clips. A patch worn can be ignored, so the promise never falls.

    Parameters
    ----------
    tests : SetTests
    terms : Terms
    order : sequence of int
    choose : callable
        Chooses a set from the tests of a half.
    alone : tuple of three floats
        Expected macro F1 of the first patch alone and its interval, as its map gives them.
    level : float
        Confidence of the interval.
    """
    size = len(order)
    with threadpool_limits(1):
        drawn = random_sets(terms, size, tests.seed)
        among = dict.fromkeys([tests.whole, *(one for pair in tests.pairs for one in pair)])
        level_of = {one: _level(one, drawn) for one in among}
        raw = tests.whole.f1_of_first(order)
        gains = [
            _gain(choose(here, terms, size), there, level_of[there])
            for pair in tests.pairs
            for here, there in (pair, pair[::-1])
        ]
    shown = np.maximum(np.isfinite(gains).sum(axis=0), 1)  # an activity may have too few clips for halves
    believed = 1.0 if tests.plan.disjoint else UNPROVEN  # folds share the subjects they train on
    f1 = level_of[tests.whole] + believed * np.nansum(gains, axis=0) / shown
    mean = np.maximum.accumulate(np.clip([alone[0], *f1[1:].mean(axis=1)], 0, 1))
    f1 = np.maximum.accumulate(np.clip(f1 + (mean - f1.mean(axis=1))[:, None], 0, 1))
    apart = [_mean(level_of[one]) - _mean(level_of[other]) for one, other in tests.pairs]
    if gains:
        variance = np.mean(np.square(apart), axis=0) / tests.plan.shrink
        variance = variance + np.var([_mean(one) for one in gains], axis=0) / 2
    else:
        variance = np.ones(size)
    reach = norm.ppf((1 + level) / 2) * np.sqrt(variance)
    low, high = np.clip(mean - reach, 0, 1), np.clip(mean + reach, 0, 1)
    low[0], high[0] = alone[1:]
    return Promise(f1, mean, low, high, raw)


def _gain(order: Sequence[int], there: Tests, level: np.ndarray) -> np.ndarray:
    """What a set chosen elsewhere has over random sets, by its size; a shorter one stays as it is."""
    delivered = there.f1_of_first(order)
    more = len(level) - len(delivered)
    return np.concatenate([delivered, np.repeat(delivered[-1:], more, axis=0)]) - level


def chosen_by_halves(half: Tests, terms: Terms, size: int, worst: bool = False) -> tuple[int, ...]:
    """Choose as `grow` does, among fewer candidates; goes on from what was chosen under the same terms."""
    terms_before, worst_before, before = half.grown
    start = before if terms_before is terms and worst_before == worst else ()
    if len(start) < size:
        half.grown = terms, worst, grow(half, terms, size, worst=worst, among=OF_HALVES, start=start)
    return half.grown[2][:size]


def random_sets(terms: Terms, size: int, seed: int) -> list[list[int]]:
    """Orders drawn from what is allowed, the required ones first."""
    rng = np.random.default_rng([seed, 4])
    sets = []
    for _ in range(RANDOM_SETS):
        order: list[int] = []
        for options in terms.required[:size]:
            if not np.isin(order, options).any():
                order.append(int(rng.choice(options)))
        rest = rng.permutation(np.setdiff1d(np.flatnonzero(terms.allowed), order))
        sets.append([*order, *rest.tolist()][:size])
    return sets


def _level(tests: Tests, drawn: Sequence[Sequence[int]]) -> np.ndarray:
    return np.mean([tests.f1_of_first(order) for order in drawn], axis=0)


def _mean(f1: np.ndarray) -> np.ndarray:
    return np.nanmean(f1, axis=-1)


@dataclass(frozen=True, eq=False)
class JointSet:
    """A set of patches chosen to be worn together.

    Attributes
    ----------
    order : tuple of int
        In order of choice, as many as are recommended.
    promise : Promise
        Of the first, the first two, and so on.
    activities : tuple of str
    target : float
        Expected macro F1 to reach.
    every_activity : float
        Expected F1 that no activity may fall short of; 0 for none.
    reached : bool
    cost : float
    """

    order: tuple[int, ...]
    promise: Promise
    activities: tuple[str, ...]
    target: float
    every_activity: float
    reached: bool
    cost: float

    def sentence(self) -> str:
        """Say in words what the set would reach on other clips."""
        made, count = self.promise, len(self.order)
        sensors = "1 sensor reaches" if count == 1 else f"{count} sensors worn together reach"
        text = (
            f"{sensors} an expected F1 of {made.mean[-1]:.3f} on other clips "
            f"(95 % interval {made.low[-1]:.2f} to {made.high[-1]:.2f}; target {self.target:g}"
        )
        if self.every_activity:
            worst = int(made.f1[-1].argmin())
            text += (
                f", {self.every_activity:g} for every activity, of which {self.activities[worst]} has the "
                f"lowest, {made.f1[-1, worst]:.3f}"
            )
        return text + (")" if self.reached else "); no more sensors are allowed, or more add nothing")


def choose_together(
    tests: SetTests,
    expected: Sequence[np.ndarray],
    terms: Terms,
    target: float = 0.9,
    every_activity: float = 0.0,
) -> JointSet:
    """The smallest set whose promise reaches the target, or the one beyond which it rises no more.

    Parameters
    ----------
    tests : SetTests
    expected : three ndarrays, shape (N,)
        Expected macro F1 of each patch alone, by which the first is chosen, and its interval.
    terms : Terms
    target : float
    every_activity : float

    Returns
    -------
    JointSet
    """
    worst, order = every_activity > 0, ()
    choose = partial(chosen_by_halves, worst=worst)
    for size in sorted({min(most, terms.max_size) for most in (FIRST_SETS, LARGEST_SET)}):
        order = grow(tests.whole, terms, size, expected[0], worst, start=order)
        made = promise(tests, terms, order, choose, tuple(float(values[order[0]]) for values in expected))
        least = fewest(order, terms.required)
        good = (made.mean >= target - ROUNDING) & (made.f1.min(axis=1) >= every_activity - ROUNDING)
        good[: least - 1] = False
        if good.any() or (len(order) > least and made.mean[-1] <= made.mean[-2]):
            break
    enough = int(good.argmax()) + 1 if good.any() else max(least, int(made.mean.argmax()) + 1)
    order = order[:enough]
    return JointSet(
        order,
        Promise(*(values[:enough] for values in vars(made).values())),
        tests.activities,
        target,
        every_activity,
        bool(good.any()),
        float(terms.cost[list(order)].sum()),
    )
