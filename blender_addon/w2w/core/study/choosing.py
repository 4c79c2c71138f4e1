# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose sensors in a ranked study, say how far one may turn, and rank again with other weights."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Generic, TypeVar

import numpy as np
from scipy.spatial.transform import Rotation

from ..body.body import Body
from ..patches.card import DROP, FARTHEST_DEG
from ..patches.patches import PatchSet
from ..ranking.classifiers.ridge import Ridge
from ..ranking.f1 import window_f1
from ..ranking.halves import Predictions, Split, TrialPlan
from ..ranking.pooling import Pooling
from ..ranking.stream import Stream
from ..ranking.utility import UtilityMap, weighed
from ..ranking.weights import counting, mean_over, weights_of
from ..reading.helpers import helped
from ..selection.advice import Advice, advise
from ..selection.scored import PlaceScore, ScoredMap, compare
from ..selection.set_tests import SetTests
from ..threads import for_each, unthreaded_products
from ..windows.features import window_features
from .clip_files import WORK, ClipWindows, ranking_inputs
from .config import StudyConfig, plain
from .needs import Need, needs
from .ranking import LabelledClip, WindowLabels, rank_clips, same_motions, set_tests_of, stream_of
from .remade import recordings_at
from .results import HeldClips, HeldResults, SimulatedClips, StudyResults

TURNS = (5, 10, 15, 20, 30, 45, FARTHEST_DEG)
"""Rotations about the outward normal, degrees, tried in both directions."""


def may_turn(windows: np.ndarray, rate: float, planned: TrialPlan, drop: float) -> int:
    """How far a sensor may be turned about its outward normal before macro F1 falls by more than `drop`.

    A ridge is trained on the windows as they are and predicts rotated windows of clips it was not trained on.

    Parameters
    ----------
    windows : ndarray, shape (W, samples, 6)
        Specific force (m/s2) and angular velocity (rad/s) of one sensor, z outward.
    rate : float
        Samples per second.
    planned : TrialPlan
        Training and testing on these windows, all of which it uses.
    drop : float

    Returns
    -------
    int
        The largest of `TURNS` up to which F1 falls by no more, the mean of both directions; 0 if the
        smallest costs more.
    """
    f1 = _f1_of_turned(windows, rate, planned, (0, *TURNS, *(-turn for turn in TURNS)))
    enough = f1[1:].reshape(2, -1).mean(axis=0) >= f1[0] - drop - 1e-9
    return (0, *TURNS)[int(np.logical_and.accumulate(enough).sum())]


def _f1_of_turned(seen: np.ndarray, rate: float, planned: TrialPlan, turns: tuple[int, ...]) -> np.ndarray:
    """Macro F1 with the tested windows turned by each of some angles, degrees; shape (K,)."""
    whole, tested = planned.plan.splits, np.flatnonzero(planned.is_test)
    turned = seen[tested]

    def described(turn: int | None) -> np.ndarray:
        shown = seen if turn is None else _turned(turned, turn)
        return window_features(shown[None], rate)[0]  # as sensors of one window: faster

    features = np.concatenate(for_each(described, (None, *turns)))[:, None]
    labels = np.concatenate([planned.labels, np.tile(planned.labels[tested], len(turns))])
    never = np.full(len(labels) - len(seen), planned.plan.block.max() + 1)
    place = np.cumsum(planned.is_test) - 1
    splits = [
        Split(split.train, len(seen) + number * len(tested) + place[split.tested])
        for number in range(len(turns))
        for split in whole
    ]
    predicted = np.zeros(len(labels), dtype=np.int16)

    def receive(_sensor: int, predictions: Iterable[Predictions]) -> None:
        for _, rows, activities in predictions:
            predicted[rows] = activities[0]

    ridge = Ridge()
    alpha = ridge.choose_alpha(features[: len(seen)], planned.labels, planned.fold, planned.is_test)
    ridge.predict_splits(
        features, labels, np.concatenate([planned.plan.block, never]), splits, alpha, receive
    )
    by_turn = predicted[len(seen) :].reshape(len(turns), -1)
    f1 = [window_f1(row, planned.labels[tested], len(planned.activities)) for row in by_turn]
    return mean_over(np.array(f1), planned.weights)


def _turned(windows: np.ndarray, degrees: float) -> np.ndarray:
    """Windows as a sensor that is turned about its z axis would record them."""
    turn = Rotation.from_euler("z", degrees, degrees=True).as_matrix()  # times rows of readings: its inverse
    return (windows.reshape(-1, 3) @ turn).reshape(windows.shape).astype(np.float32)


Found = TypeVar("Found", bound=StudyResults)


def ranked_again(study: Found, config: StudyConfig) -> Found:
    """The study with a mean over other activities or by other weights, as a run would rank it.

    It takes `background` and `weights` of the config; if they change nothing, it is the same study.
    Nothing is trained again, but where the map has no trials: few clips, or other classifiers. ValueError if
    no activity counts that can be tested.
    """
    parameters = {**study.parameters, "background": list(config.background), "weights": plain(config.weights)}
    study = replace(study, parameters=parameters)
    if _counts_by(study.utility, config):
        return study
    asked, pooling = study.config(), Pooling.on(study.body(), study.patches)
    utility = weighed(study.utility, study.labels().protocol(asked), pooling)
    if utility is None:
        inputs = study.inputs(config.classifier)
        utility = rank_clips(study.clips, study.windows, inputs, asked, pooling, work=study.out / WORK)
    return replace(study, utility=utility)


def _counts_by(utility: UtilityMap, config: StudyConfig) -> bool:
    """Whether a map's weights are those that a config asks for."""
    wanted = counting(utility.activities, config.background, config.weights)
    return np.array_equal(weights_of(utility.activities, wanted), utility.weights)


def rank_files(
    clips: Sequence[LabelledClip], places: Sequence[tuple[Path, str]], patches: PatchSet, body: Body,
    config: StudyConfig, progress: Callable[[float], None], utility: UtilityMap | None = None,
) -> Choices[HeldResults]:  # fmt: skip
    """Rank clips whose files lie in these folders under these names; `utility`, their map, saves training."""
    windows = [ClipWindows.read(*place) for place in places]
    ranked, stream = same_motions(clips, windows), None
    held = Path(), patches, ranked, config.as_dict()
    if utility is not None and not _counts_by(utility, config):
        protocol = WindowLabels.of(ranked, windows).protocol(config)
        utility = weighed(utility, protocol, Pooling.on(body, patches))
    if utility is None:
        beside = ThreadPoolExecutor(1)  # which is not waited for where the job is ended early
        with helped() as spread, unthreaded_products():
            tried = beside.submit(tried_stream, HeldClips(*held, tuple(places), body), config)
            inputs = ranking_inputs(places, windows, config.classifier, config.windows)
            pooling = Pooling.on(body, patches)
            utility = rank_clips(ranked, windows, inputs, config, pooling, progress=progress, spread=spread)
            stream = tried.result()
    return Choices(HeldResults(*held, utility, tuple(places), body), config, stream)


def tried_stream(clips: SimulatedClips, config: StudyConfig) -> Stream | None:
    """The stream of clips, as `stream_in`, with F1 of each spot found."""
    stream = stream_in(clips, config)
    _ = stream and stream.by_moving
    return stream


def set_tests_in(study: StudyResults, config: StudyConfig) -> SetTests | None:
    """Tests that sets of patches are chosen and judged by; None for classifiers that are too slow."""
    inputs, pooling = study.inputs(config.classifier), Pooling.on(study.body(), study.patches)
    return set_tests_of(inputs, study.labels(), config, pooling, utility=study.utility)


def advise_under(
    utility: UtilityMap,
    patches: PatchSet,
    body: Body | None,
    config: StudyConfig,
    tests: SetTests | None,
    stream: Stream | None = None,
) -> Advice:
    """Choose the best spot and the patches to wear together, with `tests` from `set_tests_in`.

    The F1 promised to a set is that in a `stream`, if there is one.

    The config is the run's, or has another target and other constraints; ValueError if they cannot be met.
    """
    return advise(
        scored_map(utility, patches, body, config), tests, target=config.target,
        every_activity=config.every_activity, max_places=config.max_places, constraints=config.constraints,
        stream=stream,
    )  # fmt: skip


def scored_map(utility: UtilityMap, patches: PatchSet, body: Body | None, config: StudyConfig) -> ScoredMap:
    """The map with its products, under the config's constraints; ValueError if they cannot be met."""
    allowed = config.constraints.terms(patches).allowed
    return ScoredMap(utility, patches, body, allowed, config.habit)


def compare_places(study: StudyResults, words: Sequence[str]) -> tuple[PlaceScore, ...]:
    """One sensor on products and at places by name, best first; ValueError for an unknown name."""
    return compare(scored_map(study.utility, study.patches, study.body(), study.config()), words)


def find_needs(study: StudyResults, words: Sequence[str] = ()) -> list[Need]:
    """What a sensor needs on products and at places by name, or at each that is recommended.

    ValueError for an unknown name, or if signals cannot be made again.
    """
    scores = compare_places(study, words)
    named = {score.patch: f"{score.side} {score.name}".strip() for score in scores}
    if not words:
        named = {card["patch"]: card["sensor"] for card in study.cards}
    numbers = _evenly([clip.activity for clip in study.clips])
    return needs(study, list(named), list(named.values()), numbers)


class Choices(Generic[Found]):
    """Choices in a ranked study, whose map gets F1 in a stream; a further one takes a fifth of the time."""

    def __init__(self, study: Found, config: StudyConfig, stream: Stream | None = None) -> None:
        self.stream = stream or stream_in(study, config)
        self.study = replace(study, utility=self.stream.on_map(study.utility)) if self.stream else study
        self._config, self._turned = config, dict[int, int]()
        self._weighed: dict[object, Choices[Found]] = {}  # by other weights: the last ones

    @cached_property
    def tests(self) -> SetTests | None:
        """Tests of sets: they and the stream remember what was asked of them."""
        return set_tests_in(self.study, self._config)

    def weighed(self, config: StudyConfig) -> Choices[Found]:
        """Choices by the config's weights; what does not depend on these is not found again."""
        key = config.background, config.weights
        if key not in self._weighed:
            study = ranked_again(self.study, config)
            weights = study.utility.weights
            if study.utility is self.study.utility:
                return self
            found = Choices(study, config, self.stream and self.stream.weighed(weights))
            found.tests = self.tests and self.tests.weighed(weights)
            self._weighed = {key: found}
        return self._weighed[key]

    def under(self, config: StudyConfig) -> Advice:
        """Choose by a config that differs from the ranking's in wishes; ValueError if they cannot be met."""
        study, stream, turned = self.study, self.stream, self._turned
        advice = advise_under(study.utility, study.patches, study.body(), config, self.tests, stream)
        if stream is None:
            return advice
        due = [card.patch for card in advice.cards if card.patch not in turned]
        turned.update(zip(due, _turns(study, config, stream, due) if due else (), strict=True))
        cards = [replace(card, turn_deg=turned[card.patch]) for card in advice.cards]
        return replace(advice, cards=tuple(cards))


MOST_CLIPS, FEWEST_OF_EACH = 1000, 20
"""Clips whose signals are read again at most, evenly taken; of each of many activities so many all the same.

What F1 loses in a stream is told to .15 / sqrt(clips), one standard error, by draws from 630 real clips;
with 17 an activity it was as with all, 21, and with 10 it was a quarter less.
"""


def _evenly(activities: Sequence[str]) -> list[int]:
    """Numbers of the clips taken, equally many of each activity as far as it has them, ascending."""
    clips_of: dict[str, list[int]] = {}
    for number, activity in enumerate(activities):
        clips_of.setdefault(activity, []).append(number)
    counts = np.array([len(clips) for clips in clips_of.values()])
    most = FEWEST_OF_EACH
    while most < counts.max() and np.minimum(counts, most + 1).sum() <= MOST_CLIPS:
        most += 1
    taken = ({clips[k * len(clips) // most] for k in range(most)} for clips in clips_of.values())
    return sorted(set().union(*taken))


def stream_in(study: SimulatedClips, config: StudyConfig) -> Stream | None:
    """The stream of a study's clips; None for other classifiers than the ridge, or with further signals."""
    if config.classifier != Ridge.name or config.further.features:
        return None
    numbers = _evenly([clip.activity for clip in study.clips])
    return stream_of(
        [study.clips[n] for n in numbers],
        [study.windows[n] for n in numbers],
        lambda clips, patches: recordings_at(study, [numbers[clip] for clip in clips], patches),
        config,
        (study.body(), study.patches),
    )


def _turns(study: StudyResults, config: StudyConfig, stream: Stream, patches: Sequence[int]) -> list[int]:
    """How far the sensor on each patch may be turned, degrees."""
    numbers = _evenly([clip.activity for clip in study.clips])
    labels = WindowLabels.of([study.clips[n] for n in numbers], [study.windows[n] for n in numbers])
    rate, planned = config.synthesis.rate_hz, labels.protocol(config).plan(halvings=0)
    return [may_turn(stream.windows_at(patch), rate, planned, DROP) for patch in patches]
