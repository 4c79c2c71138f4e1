# SPDX-License-Identifier: GPL-3.0-or-later
"""How cheap worn and simulated sensors may be: what is compared was fixed before anything was computed.

docs/evidence/needs.md says why.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording
from w2w.core.imu.sensor import SensorModel, Triad
from w2w.core.imu.synthesis import Synthesis
from w2w.core.ranking.costs import as_shown, is_as_good
from w2w.core.study.config import StudyConfig
from w2w.core.study.needs import LEAST_F1
from w2w.core.study.variants import (
    ACCELEROMETER,
    ALONE,
    BITS,
    FORCE_RANGE,
    KNOBS,
    RATE,
    Variant,
    at_rate,
    variants,
    with_model,
)
from w2w.core.windows.windows import WindowSpec

from .site_scores import SiteScores, site_scores
from .site_windows import SiteWindows, Use, site_windows

VALUES: Mapping[str, tuple[float, ...]] = {
    RATE: (15, 10, 6, 4, 3),
    FORCE_RANGE: (8, 4, 2),
    BITS: (8, 6, 4),
    ALONE: (ACCELEROMETER,),
}
"""Values tried, from dear to cheap."""

COUNTED = (RATE, FORCE_RANGE, BITS)
"""Parameters of more than one step, at which the cheapest value may lie elsewhere."""

WITHIN, APART = 0.8, 0.03
"""Bars: least share of sites and parameters within one step, and most mean difference of the losses."""


class Curves(NamedTuple):
    """One set's losses of macro F1 on both sides, by variant and site."""

    name: str
    sites: tuple[str, ...]
    activities: tuple[str, ...]
    tried: tuple[Variant, ...]
    f1: np.ndarray  # (2, S): with the part as it is, worn and simulated
    loss: np.ndarray  # (2, V, S)
    low: np.ndarray  # (2, V, S): 95 % intervals over people and performers
    high: np.ndarray

    def rows(self, knob: str) -> list[int]:
        """Numbers of a knob's variants, from dear to cheap."""
        return [number for number, variant in enumerate(self.tried) if variant.knob == knob]

    def steps(self, knob: str) -> np.ndarray:
        """How many steps down the cheapest value is, shape (2, S); 0 where nothing cheaper does."""
        return np.logical_and.accumulate(is_as_good(self.loss[:, self.rows(knob)]), axis=1).sum(axis=1)


@dataclass(frozen=True, eq=False)
class Side:
    """One side of a set: recordings, and how a value changes them."""

    recordings: Sequence[ImuRecording]
    usual: StudyConfig
    site_of: np.ndarray | None

    @cached_property
    def _unrounded(self) -> list[ImuRecording]:
        """What the usual part reads before range and resolution: most values change these alone."""
        part = _divided(self.usual.sensor_model())[0]
        return [part.apply(one, self.usual.seed) for one in self.recordings]

    def windows(self, config: StudyConfig, use: Use) -> SiteWindows:
        """Windows of what a config's part records."""
        part, source = config.sensor_model(), self.recordings
        before, last = _divided(part)
        if before == _divided(self.usual.sensor_model())[0]:
            part, source = last, self._unrounded
        return site_windows([part.apply(one, config.seed) for one in source], config.windows, use)


def _divided(part: SensorModel) -> tuple[SensorModel, SensorModel]:
    """A part without ranges and resolution, and one with these alone: the last step of what it does."""
    triads = {"accelerometer": part.accelerometer, "gyroscope": part.gyroscope}
    before = {name: replace(one, full_scale=None, resolution=0.0) for name, one in triads.items()}
    last = {name: Triad(one.full_scale, one.resolution) for name, one in triads.items()}
    return replace(part, name="", **before), SensorModel(**last)


def simulated(part: SensorModel, rate: float, spec: WindowSpec) -> StudyConfig:
    """A study with a protocol's part, windows and rate."""
    config = StudyConfig(synthesis=Synthesis(rate_hz=rate), windows=spec)
    return at_rate(with_model(config, part), rate)


def worn(part: SensorModel, rate: float, spec: WindowSpec) -> StudyConfig:
    """A study in which a part reads what was worn as it is, within the ranges of the one simulated."""
    ranges = {
        name: replace(getattr(SensorModel(), name), full_scale=getattr(part, name).full_scale)
        for name in ("accelerometer", "gyroscope")
    }
    return simulated(SensorModel(**ranges), rate, spec)


def curves(
    name: str, sites: Sequence[str], sides: tuple[Side, Side], use: Use, asked: Sequence[str]
) -> Curves:
    """Train and test both sides with every value, on those of the activities `asked` that both can test."""
    knobs = [knob for knob in VALUES if knob != ALONE or use == "both"]
    tried = [_variants(side.usual, knobs) for side in sides]
    usual = [side.windows(side.usual, use) for side in sides]
    shared = [
        activity
        for activity in asked
        if all(activity in one.ranked(asked, by_subject=True, resamples=1).activities for one in usual)
    ]

    def scored(side: Side, windows: SiteWindows) -> SiteScores:
        return site_scores(
            windows.ranked(shared, by_subject=True, resamples=1), windows.person_of(), side.site_of
        )

    of_side = []
    for side, windows, some in zip(sides, usual, tried, strict=True):
        base = scored(side, windows)
        others = [scored(side, side.windows(variant.config, use)) for variant in some]
        drawn = np.array([base.mean_samples - one.mean_samples for one in others])
        low, high = np.nanquantile(drawn, (0.025, 0.975), axis=1)
        of_side.append((base.mean, [base.mean - one.mean for one in others], low, high))
    f1, loss, low, high = (np.array(each) for each in zip(*of_side, strict=True))
    return Curves(name, tuple(sites), tuple(shared), tuple(tried[0]), f1, loss, low, high)


def _variants(usual: StudyConfig, knobs: Sequence[str]) -> list[Variant]:
    """Those of the values that are cheaper than the part has them."""
    return [
        variant
        for knob in knobs
        for variant in variants(usual, knob, VALUES[knob])
        if knob == ALONE or KNOBS[knob].dearer(KNOBS[knob].own(usual), variant.value)
    ]


class Verdict(NamedTuple):
    """How a rule fares against what was worn."""

    rule: str
    cases: int
    within: float  # share of sites and parameters whose cheapest value is at most one step off
    same: float  # share of those at which it is the same
    apart: float  # mean difference of the losses at a step

    @property
    def met(self) -> bool:
        """Whether both bars are reached."""
        return self.within >= WITHIN and self.apart <= APART


def verdicts(sets: Sequence[Curves]) -> list[Verdict]:
    """The simulation, at all sites and where `w2w need` is not silent, and two rules that look at nothing."""
    rules: dict[str, tuple[Callable[[Curves, str], np.ndarray], float, float]] = {
        "simulation": (_simulated_steps, 1.0, 0.0),
        "simulation, where it speaks": (_simulated_steps, 1.0, LEAST_F1),
        "nothing cheaper will do": (lambda one, _: np.zeros(len(one.sites), int), 0.0, 0.0),
        "the cheapest will do": (lambda one, knob: np.full(len(one.sites), len(one.rows(knob))), 0.0, 0.0),
    }
    found = []
    for rule, (steps, share, least) in rules.items():
        spoken = [as_shown(one.f1[1]) >= least for one in sets]
        off = np.concatenate(
            [
                np.abs(one.steps(knob)[0] - steps(one, knob))[sites]
                for one, sites in zip(sets, spoken, strict=True)
                for knob in COUNTED
                if one.rows(knob)
            ]
        )
        if not len(off):
            continue
        apart = np.concatenate(
            [
                np.abs(one.loss[0] - share * one.loss[1])[:, sites].ravel()
                for one, sites in zip(sets, spoken, strict=True)
            ]
        )
        found.append(
            Verdict(rule, len(off), float((off <= 1).mean()), float((off == 0).mean()), float(apart.mean()))
        )
    return found


def _simulated_steps(one: Curves, knob: str) -> np.ndarray:
    return one.steps(knob)[1]
