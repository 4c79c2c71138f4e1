# SPDX-License-Identifier: GPL-3.0-or-later
"""Choose sensors in a ranked study, and rank it again with other weights."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np

from ..body.body import Body
from ..patches.card import DROP
from ..patches.patches import PatchSet
from ..ranking.classifiers.ridge import Ridge
from ..ranking.pooling import Pooling
from ..ranking.stream import Stream
from ..ranking.turned import may_turn
from ..ranking.utility import UtilityMap
from ..ranking.weights import counting, weights_of
from ..selection.advice import Advice, advise
from ..selection.scored import PlaceScore, ScoredMap, compare
from ..selection.set_tests import SetTests
from ..threads import for_each
from ..windows.windows import cut_windows
from .clip_files import WORK, ClipWindows, ranking_inputs
from .config import StudyConfig, plain
from .needs import Need, needs
from .ranking import LabelledClip, WindowLabels, rank_clips, same_motions, set_tests_of, stream_of
from .results import HeldResults, StudyResults

Found = TypeVar("Found", bound=StudyResults)


def ranked_again(study: StudyResults, config: StudyConfig) -> StudyResults:
    """The study with a mean over other activities or by other weights, as a run would rank it.

    It takes `background` and `weights` of the config; if they change nothing, it is the same study.
    Signals stay as they are; with the ridge it takes seconds. ValueError if no activity counts that can be
    tested.
    """
    activities = study.utility.activities
    wanted = weights_of(activities, counting(activities, config.background, config.weights))
    parameters = {**study.parameters, "background": list(config.background), "weights": plain(config.weights)}
    study = replace(study, parameters=parameters)
    if np.array_equal(wanted, study.utility.weights):
        return study
    pooling = Pooling.on(study.body(), study.patches)
    inputs, ranked_as = study.inputs(config.classifier), study.config()
    utility = rank_clips(study.clips, study.windows, inputs, ranked_as, pooling, work=study.out / WORK)
    return replace(study, utility=utility)


def rank_files(
    clips: Sequence[LabelledClip], places: Sequence[tuple[Path, str]], patches: PatchSet, body: Body,
    config: StudyConfig, progress: Callable[[float], None],
) -> HeldResults:  # fmt: skip
    """Rank clips whose files lie in these folders under these names, and put F1 in a stream on the map."""
    windows = [ClipWindows.read(*place) for place in places]
    inputs = ranking_inputs(places, windows, config.classifier, config.windows)
    ranked = same_motions(clips, windows)
    utility = rank_clips(ranked, windows, inputs, config, Pooling.on(body, patches), progress=progress)
    found = HeldResults(Path(), utility, patches, ranked, config.as_dict(), tuple(places), body)
    return in_stream(found, stream_in(found, config))


def set_tests_in(study: StudyResults, config: StudyConfig, pooling: Pooling | None = None) -> SetTests | None:
    """Tests that sets of a study's patches are chosen and judged by; None for classifiers that are too slow.

    `pooling` is over the skin of the study's body, which takes seconds to make.
    """
    pooling = pooling or Pooling.on(study.body(), study.patches)
    return set_tests_of(
        study.inputs(config.classifier), study.labels(), config, pooling, utility=study.utility
    )


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


def choose(study: Found, config: StudyConfig, pooling: Pooling | None = None) -> tuple[Found, Advice]:
    """Put F1 in a stream on a ranked study, and choose: a step of runs, `w2w place` and the panel."""
    stream = stream_in(study, config)
    study = in_stream(study, stream)
    return study, choose_with(study, config, set_tests_in(study, config, pooling), stream, {})


def in_stream(study: Found, stream: Stream | None) -> Found:
    """The study whose map is of F1 in a stream of its clips, if there is one."""
    return replace(study, utility=stream.on_map(study.utility)) if stream else study


def choose_with(
    study: StudyResults,
    config: StudyConfig,
    tests: SetTests | None,
    stream: Stream | None,
    turned: dict[int, int],
) -> Advice:
    """Like `choose`, with tests and a stream that know what was asked of them before.

    So does `turned`: how far the sensor on each patch may be turned.
    """
    advice = advise_under(study.utility, study.patches, study.body(), config, tests, stream)
    if stream is None:
        return advice
    due = [card.patch for card in advice.cards if card.patch not in turned]
    turned.update(zip(due, _turns(study, config, due) if due else (), strict=True))
    cards = [replace(card, turn_deg=turned[card.patch]) for card in advice.cards]
    return replace(advice, cards=tuple(cards))


MOST_CLIPS = 200
"""Most clips of an activity, evenly taken, whose signals are read again: memory stays small with many."""


def _evenly(activities: Sequence[str]) -> list[int]:
    """Numbers of the clips taken of each activity, ascending."""
    clips_of: dict[str, list[int]] = {}
    for number, activity in enumerate(activities):
        clips_of.setdefault(activity, []).append(number)
    taken = ({clips[k * len(clips) // MOST_CLIPS] for k in range(MOST_CLIPS)} for clips in clips_of.values())
    return sorted(set().union(*taken))


def stream_in(study: StudyResults, config: StudyConfig) -> Stream | None:
    """The stream of a study's clips; None for other classifiers than the ridge, or with further signals."""
    if config.classifier != Ridge.name or config.further.features:
        return None
    numbers = _evenly([clip.activity for clip in study.clips])
    return stream_of(
        [study.clips[n] for n in numbers],
        [study.windows[n] for n in numbers],
        lambda clip, patches: study.recording(numbers[clip], patches),
        config,
        (study.body(), study.patches),
    )


def _turns(study: StudyResults, config: StudyConfig, patches: Sequence[int]) -> list[int]:
    """How far the sensor on each patch may be turned, degrees."""
    numbers = _evenly([clip.activity for clip in study.clips])
    labels = WindowLabels.of([study.clips[n] for n in numbers], [study.windows[n] for n in numbers])

    def cut_of(number: int) -> np.ndarray:
        return cut_windows(study.recording(number, patches), config.windows).signals

    cut = np.concatenate(for_each(cut_of, numbers))
    rate, protocol = config.synthesis.rate_hz, labels.protocol(config)
    return for_each(lambda card: may_turn(cut[:, card], rate, protocol, DROP), range(len(patches)))
