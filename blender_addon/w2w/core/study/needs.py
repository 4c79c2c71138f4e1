# SPDX-License-Identifier: GPL-3.0-or-later
"""How cheap a sensor may be at a place: the F1 lost to a lower rate, a short range, coarser steps, noise."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, reduce
from itertools import takewhile
from math import inf
from typing import NamedTuple

import numpy as np
import scipy

from ..imu.presets import PRESETS
from ..imu.recording import ImuRecording
from ..imu.virtual import record_motion
from ..ranking.classifiers.ridge import Ridge
from ..ranking.costs import Cost, as_shown, judged, reach_of
from ..ranking.f1 import try_patches
from ..ranking.halves import Plan, maps_of
from ..ranking.utility import LEVEL
from ..ranking.weights import known_mean
from ..selection.headline import short
from ..threads import unthreaded_products
from ..windows.features import window_features
from ..windows.inputs import SomeWindows, as_blocks
from ..windows.windows import cut_windows
from ..wording import clean
from .clip_files import NO_SIGNATURE, ClipWindows, motion_file
from .config import StudyConfig
from .ranking import LabelledClip, WindowLabels
from .results import StudyResults
from .signals import measured
from .variants import ALONE, FORCE_RANGE, KNOBS, NOISE, RATE, TURN_RANGE, Variant, at_rate, own_rate, variants

PARTS = 3
"""Real parts that are named."""

LUCK = 0.001
"""Chance of guessing as many clips right up to which the clips tell something about a sensor."""

NO_PARTS = ("ideal", "phone", "watch", "paper")
"""Presets that are no part that one buys."""


LEAST_F1 = 0.75
"""F1 below which nothing is said: on worn sensors what seemed free there cost most."""

NOTHING = "These clips tell nothing about the sensor that is needed"

ON_CARD = (RATE, FORCE_RANGE, TURN_RANGE)
"""What the card says."""


class Loss(NamedTuple):
    """F1 with one thing of the part at another value, trained and tested with it."""

    knob: str
    value: float
    name: str  # the value with its unit
    f1: float
    cost: Cost  # against the study's own part

    @property
    def bound(self) -> str:
        """The value, or that it is the cheapest tried: what lies beyond is not known."""
        end = "more" if self.knob == NOISE else "less"
        return f"{self.name} or {end}" if self.value == KNOBS[self.knob].values[-1] else self.name


@dataclass(frozen=True, repr=False)
class Need:
    """What a sensor at one place needs, for the activities of a study."""

    place: str
    patch: int
    own: dict[str, float]  # the study's own value of each knob
    f1: float  # with the study's own part
    silent: str = ""  # why nothing is said
    losses: tuple[Loss, ...] = ()  # knob by knob, from dear to cheap
    together: Loss | None = None  # the cheapest values of `ON_CARD` at once
    parts: tuple[Loss, ...] = ()  # parts that do, each at its cheapest rate

    def __repr__(self) -> str:
        return f"<Need of {self.place}: {self.sentence() or 'the clips tell nothing of it'}>"

    def of(self, knob: str) -> list[Loss]:
        """The losses of a knob, from dear to cheap."""
        return [loss for loss in self.losses if loss.knob == knob]

    def cheapest(self, knob: str) -> Loss | None:
        """The cheapest value up to which none costs more than .02; None if it is the study's own."""
        good = [*takewhile(lambda loss: loss.cost.as_good, self.of(knob))]
        return good[-1] if good else None

    def sentence(self) -> str:
        """The card's line, or why there is none."""
        if not self.losses:
            return ": ".join(filter(None, [NOTHING, self.silent]))
        down_to = [
            found.bound if (found := self.cheapest(knob)) else KNOBS[knob].text(self.own[knob])
            for knob in ON_CARD
            if self.cheapest(knob) or np.isfinite(self.own.get(knob, inf))
        ]
        highs = [loss.cost.high for knob in ON_CARD if (loss := self.cheapest(knob))]
        most = f", at a cost of up to {short(max(highs))}{' each' if len(highs) > 1 else ''}" if highs else ""
        text = f"Works down to {', '.join(down_to)}{most}"
        if self.together and not self.together.cost.as_good:
            text += f" (one at a time: together they cost {_short(self.together.cost.expected)})"
        alone = [f"{loss.name} {_costs(loss.cost)}" for loss in self.of(ALONE)]
        return "; ".join([text, *([", ".join(alone)] if alone else [])])


def _costs(cost: Cost) -> str:
    """What is lost, with its interval."""
    verb = "may cost" if cost.may else "costs"
    return f"{verb} {_short(cost.expected)} ({short(cost.low)} to {short(cost.high)})"


def _short(cost: float) -> str:
    return short(float(as_shown(cost))) if as_shown(cost) > 0 else "nothing"


def needs(
    study: StudyResults, patches: Sequence[int], places: Sequence[str], numbers: Sequence[int]
) -> list[Need]:
    """What sensors on some patches, under their names, need by the clips of some numbers.

    A ridge is trained and tested again with each value, in the study's folds and halves. Each motion is
    read once. ValueError if signals cannot be made again from motions.
    """
    config = study.config()
    if not config.on_skin or config.further.features or config.classifier != Ridge.name:
        raise ValueError(
            "what a sensor needs is found by the ridge, from accelerometer and gyroscope on the skin: "
            "not on cloth, with further sensors or another classifier"
        )
    for clip in study.clips:
        if not motion_file(study.out, clip.name).exists():
            raise ValueError(
                f"{clip.name} has no motion in {clean(study.out)} to make its signals from again"
            )
    usual = at_rate(config, own_rate(config))
    body, clips = study.body(), [study.clips[number] for number in numbers]
    shown = study.utility.expected_mean[list(patches)].tolist()
    with unthreaded_products():
        motions = (measured(study.motion(clip.name), config) for clip in clips)
        ideal = (record_motion(body, study.patches, one, usual.synthesis, chosen=patches) for one in motions)
        seen = [
            one.labelled(one.sites, clip.activity, clip.subject, clip.name)
            for one, clip in zip(ideal, clips, strict=True)
        ]
        return [
            at.completed(at.need(place))
            for column, (patch, place, f1) in enumerate(zip(patches, places, shown, strict=True))
            for at in [Place(clips, [one.at([column]) for one in seen], int(patch), usual, f1)]
        ]


class _Tried(NamedTuple):
    """Macro F1 of one sensor in the trials of a plan."""

    trials: np.ndarray  # (trials,)
    plan: Plan
    by_luck: float  # chance that guesses as frequent as the predictions name as many clips right

    @property
    def f1(self) -> float:
        """The mean over whole cross-validations."""
        return float(self.trials[: 1 + len(self.plan.repeats)].mean())

    def errors(self, other: _Tried) -> np.ndarray:
        """Errors of the difference against as many other clips, as halves show them, shape (pairs,)."""
        pairs = maps_of(self.trials - other.trials, self.plan)
        return np.array([first - second for first, second in pairs]) * np.sqrt(2 / self.plan.shrink)


@dataclass(frozen=True, eq=False)
class Place:
    """One patch: the true signals of all clips there, and the study with its own part."""

    clips: Sequence[LabelledClip]
    seen: Sequence[ImuRecording]
    patch: int
    usual: StudyConfig
    f1: float  # the one that is shown of the place: costs are taken off it

    @cached_property
    def _usual(self) -> _Tried:
        return self._tried(self.usual)

    def need(self, place: str, knobs: Collection[str] = tuple(KNOBS)) -> Need:
        """Try all that is cheaper than the study's own part, unless the clips look like guessing."""
        own = {name: KNOBS[name].own(self.usual) for name in knobs}
        need = Need(place, self.patch, own, self.f1)
        if self._usual.by_luck > LUCK:
            return replace(need, silent="guesses would name as many right")
        if as_shown(need.f1) < LEAST_F1:
            return replace(need, silent=f"F1 is {short(need.f1)}, below {short(LEAST_F1)}")
        cheaper = [
            variant
            for name in knobs
            for variant in variants(self.usual, name)
            if name == ALONE or KNOBS[name].dearer(own[name], variant.value)
        ]
        return replace(need, losses=self._losses(cheaper))

    def completed(self, need: Need) -> Need:
        """The need with what its cheapest values cost together, and the parts that do at the lowest rates."""
        if not need.losses:
            return need
        found = [loss for name in ON_CARD if (loss := need.cheapest(name))]
        least = reduce(lambda config, loss: KNOBS[loss.knob].altered(config, loss.value), found, self.usual)
        together = self._losses([Variant(RATE, own_rate(least), least)])[0]
        lowest = need.cheapest(RATE)
        rates = [loss.value for loss in need.of(RATE) if lowest and loss.value >= lowest.value]
        parts: list[Loss] = []
        for rate in reversed([need.own[RATE], *rates]):
            left = sorted({*PRESETS} - {*NO_PARTS} - {part.name for part in parts})
            configs = [at_rate(replace(self.usual, sensor=name), rate) for name in left]
            tried = self._losses([Variant(RATE, rate, config) for config in configs])
            named = [loss._replace(name=name) for name, loss in zip(left, tried, strict=True)]
            parts += sorted(
                (loss for loss in named if loss.cost.as_good), key=lambda loss: loss.cost.expected
            )
            if len(parts) >= PARTS:
                break
        return replace(need, together=together, parts=tuple(parts[:PARTS]))

    def _losses(self, others: Sequence[Variant]) -> tuple[Loss, ...]:
        usual = self._usual
        tried = [self._tried(variant.config) for variant in others]
        errors, losses = np.array([usual.errors(one) for one in tried]), []
        for variant, one, of_pair in zip(others, tried, errors, strict=True):
            reach = reach_of(of_pair, np.square(errors).mean(), LEVEL) if errors.size else 1.0
            cost = judged(usual.f1 - one.f1, reach)
            left = float(np.clip(self.f1 - cost.expected, 0, 1))
            losses.append(Loss(variant.knob, variant.value, variant.name, left, cost))
        return tuple(losses)

    def _tried(self, config: StudyConfig) -> _Tried:
        """Train and test with a config's part and windows."""
        part = config.sensor_model()
        cut = [cut_windows(part.apply(one, config.seed, [self.patch]), config.windows) for one in self.seen]
        signals = np.concatenate([windows.signals[:, 0] for windows in cut])
        features = window_features(signals[None], own_rate(config))[0]  # as sensors of one window: faster
        labels = WindowLabels.of(self.clips, [ClipWindows(one.is_test, NO_SIGNATURE) for one in cut])
        planned, ridge = labels.protocol(config).plan(), Ridge()
        source = SomeWindows(as_blocks(features[:, None]), planned.used)
        alpha = ridge.choose_alpha(source, planned.labels, planned.fold, planned.is_test)
        tried = try_patches(ridge, source, planned, alpha, (0, 1))
        truth, predicted = planned.labels[planned.is_test], tried.predictions
        n, weights = len(planned.activities), planned.weights
        clip = labels.motion[planned.used[planned.is_test]]
        shares = [np.bincount(of, minlength=n) / len(truth) for of in (truth, predicted[:, 0])]
        of_clip = np.unique(clip, return_inverse=True)[1]
        right = np.bincount(of_clip, predicted[:, 0] == truth) / np.bincount(of_clip)
        luck = scipy.special.bdtrc(np.floor(right.sum()) - 1, len(right), shares[0] @ shares[1])
        by_trial = known_mean(tried.f1[:, :, 0], weights)
        return _Tried(by_trial, planned.plan, float(luck))
