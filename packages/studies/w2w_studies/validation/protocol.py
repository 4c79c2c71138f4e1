# SPDX-License-Identifier: GPL-3.0-or-later
"""A test of the simulation against people who wear sensors, fixed before anything is computed."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.presets import DEFAULT_SENSOR, PRESETS
from w2w.core.imu.sensor import SensorModel
from w2w.core.keypoints.joint_sets import JointSet
from w2w.core.windows.windows import WindowSpec

from .site_transfer import WayFound
from .site_windows import Use
from .sites import SiteValidation
from .source_test import SourceTest

KINECT = "UTD-MHAD"
"""The source whose clips are paths of joints, not files of motion."""

HDM05, BANDAI, MIXAMO, CMU = "HDM05", "Bandai-Namco", "Mixamo", "CMU"

BY_POSTURE = "sitting or standing"
"""Activity of clips whose thighs say which of the two they show."""


class Rule(NamedTuple):
    """Which clips show an activity."""

    activity: str
    source: str
    pattern: str
    """Regular expression, in any case, for a file's path inside its library or the name of a trial of
    UTD-MHAD. Its group ``who`` says who moves, or what else must not be trained on and tested; without one,
    every clip stands for itself."""


def first_rule(rules: Iterable[Rule], clip: str) -> tuple[Rule | None, str]:
    """The first rule that fits a clip, None if none does, and who moves, empty if it does not say."""
    for rule in rules:
        if found := re.search(rule.pattern, clip, re.IGNORECASE):
            return rule, found.groupdict().get("who") or ""
    return None, ""


class Match(NamedTuple):
    """What a clip shows, where it is from and who moves."""

    activity: str
    source: str
    who: str


class Analysis(NamedTuple):
    """One comparison: of some activities, simulated from the clips of some sources, or at some sites."""

    name: str
    """Empty if it is the only one."""
    why: str
    activities: tuple[str, ...] = ()
    sources: tuple[str, ...] = ()
    cutoff_hz: float = 0.0
    """Band of the motion files' trajectories."""
    sites: tuple[str, ...] = ()
    """Sites of paired trials."""
    merged: tuple[str, ...] = ()
    """Activities that count as one, on both sides."""

    def label(self, activity: str) -> str:
        """The activity that this one counts as."""
        return " or ".join(self.merged) if activity in self.merged else activity


class Bar(NamedTuple):
    """What was asked for, and whether it was reached."""

    what: str
    found: float
    wanted: str
    met: bool


class Found(NamedTuple):
    """What an analysis found, and what a reader must know."""

    name: str
    why: str
    validation: SiteValidation
    notes: list[str]
    simulated_at: tuple[str, ...]
    """What stood for each site."""
    bars: Sequence[Bar] = ()
    source_tests: Sequence[SourceTest] = ()
    ways: Sequence[WayFound] = ()
    """Trained on simulated, tested on worn sensors."""
    rules: Mapping[str, float] = MappingProxyType({})
    """Real F1 lost by rules that need no ranking."""

    @property
    def suffix(self) -> str:
        """Between the names of its files and their endings."""
        return f"_{self.name.replace(' ', '_').lower()}" if self.name else ""


@dataclass(frozen=True)
class Protocol:
    """All that is decided about a data set.

    Its worn sensors are compared with clips of other people, which `rules` find by their names, or, if it
    has `joints`, with the poses of the same people in the same trials.
    """

    name: str
    file_help: str
    """What `read` takes."""
    read: Callable[[Path], Sequence[Any]]
    """Its worn sensors under its own names of activities; or trials with a recording and a pose."""
    rate_hz: float
    sites: Mapping[str, str | SensorSite | int]
    """Where the simulated sensors of a site sit. Unpaired: on every patch of the regions that hold the words,
    whose mean F1 is the site's, at one point, or on the patch of a vertex of the body."""
    analyses: tuple[Analysis, ...]
    """The first is the test; the others were fixed with it and help to read it."""
    real: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    """The data set's own names of each activity."""
    rules: tuple[Rule, ...] = ()
    """The first that fits a clip counts."""
    joints: JointSet | None = None
    """Joint set of the poses."""
    pose_hz: float = 0.0
    """Frames of the poses a second."""
    sensor: SensorModel = PRESETS[DEFAULT_SENSOR]
    kinect_hz: float = 3.0
    """Band of the paths of UTD-MHAD's joints, and of other video pose (docs/evidence/people.md)."""
    windows: WindowSpec = field(default_factory=WindowSpec)
    use: Use = "both"
    classifier: str = "ridge"
    folds: int = 5
    """By clip, the same on both sides."""
    by_subject: tuple[bool, bool] = (True, True)
    """Leave one person, and on the simulated side one performer, out instead."""
    background: tuple[str, ...] = ()
    """Activities that the others are trained against, not compared themselves."""
    remarks: Callable[[Sequence[str]], list[str]] = lambda _: []
    """What a reader must know besides, by the activities shown."""
    title: str = ""
    """Title of its report, if that says more than the name."""
    bars: Mapping[str, float] = field(default_factory=lambda: {"regret": 0.03, "rho over ceiling": 0.8})
    """Least rho of mean F1 ("rho of mean F1"), mean rho by activity ("mean rho"), correlation over the cells
    ("r over cells") and rho of mean F1 over its ceiling ("rho over ceiling"), and most regret ("regret")."""
    parts: tuple[str, ...] = ()
    """Analyses of one kind of source each, which show what recognising the sources did to the first."""
    worn_site_of: np.ndarray | None = None
    """Site of each worn sensor, where a site has several."""

    def match(self, clip: str) -> Match | None:
        """What a clip shows by the first rule that fits it; None if none does."""
        rule, who = first_rule(self.rules, clip)
        return None if rule is None else Match(rule.activity, rule.source, f"{rule.source} {who or clip}")

    def activity_of(self, real: str) -> str:
        """Our name of one of the data set's activities; empty if it takes no part."""
        return next((name for name, theirs in self.real.items() if real in theirs), "")

    def judge(self, found: SiteValidation) -> list[Bar]:
        """What the bars asked for, and whether it was reached."""
        ceiling = found.overall_ceiling.value
        values = {
            "rho of mean F1": found.overall.spearman,
            "mean rho": found.mean_rho,
            "r over cells": found.cells.value,
            "rho over ceiling": found.overall.spearman / ceiling if ceiling > 0 else float("nan"),
            "regret": found.regret.lost,
        }
        bars = []
        for name, bar in self.bars.items():
            value = float(values[name])
            most = name == "regret"
            met = value <= bar if most else value >= bar
            bars.append(Bar(name, value, f"{'<=' if most else '>='} {bar:g}", met))
        return bars


def usual_analyses(
    activities: tuple[str, ...],
    why: str = "The test: every activity that two clips show, one band for all sources.",
    band: tuple[float, str] = (10.0, "W2W's band"),
) -> tuple[Analysis, Analysis]:
    """All sources at the Kinect's band; then motion capture alone, at a band of its own."""
    captured = (HDM05, BANDAI, MIXAMO, CMU)
    return (
        Analysis("all activities", why, activities, (*captured, KINECT), 3.0),
        Analysis("motion capture", f"Without the Kinect, at {band[1]}.", activities, captured, band[0]),
    )
