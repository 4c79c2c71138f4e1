# SPDX-License-Identifier: GPL-3.0-or-later
"""A test of the simulation against people who wear sensors, fixed before anything is computed."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

from w2w.core.body.landmarks import SensorSite
from w2w.core.imu.sensor import SensorModel
from w2w.core.ranking.windows import WindowSpec

from .site_windows import Use
from .sites import SiteValidation

KINECT = "UTD-MHAD"
"""The source whose clips are paths of joints, not files of motion."""

BY_POSTURE = "sitting or standing"
"""Activity of clips of which the thighs say which of both they show."""


class Rule(NamedTuple):
    """Which clips show an activity.

    Attributes
    ----------
    activity, source : str
    pattern : str
        Regular expression, in any case, for a file's path inside its library or the name of a trial of
        UTD-MHAD. Its group ``who`` says who moves, or what else must not be trained on and tested; without
        one, every clip stands for itself.
    """

    activity: str
    source: str
    pattern: str


def first_rule(rules: Iterable[Rule], clip: str) -> tuple[Rule | None, str]:
    """The first rule that fits a clip, None where none does, and who moves, empty where it does not say."""
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
    """One comparison.

    Attributes
    ----------
    name : str
    why : str
        A sentence.
    activities, sources : tuple of str
    cutoff_hz : float
        Band of the motion files' trajectories.
    """

    name: str
    why: str
    activities: tuple[str, ...]
    sources: tuple[str, ...]
    cutoff_hz: float


class Bar(NamedTuple):
    """What was asked for, and whether it was reached."""

    what: str
    found: float
    wanted: str
    met: bool


@dataclass(frozen=True)
class Protocol:
    """All that is decided about a data set.

    Parameters
    ----------
    name : str
    real : mapping of str to tuple of str
        The data set's own names of each activity.
    rules : tuple of Rule
        The first that fits a clip counts.
    sites : mapping of str to (str, SensorSite or int)
        What the simulated sensors of a site sit on: every patch of the regions that hold the words, whose
        mean F1 is the site's, or one point, or the patch of a vertex of the body.
    analyses : tuple of Analysis
        The first is the test; the others were fixed with it and help to read it.
    rate_hz : float
    sensor : SensorModel
        Of the simulated sensors.
    kinect_hz : float
        Band of the paths of UTD-MHAD's joints.
    windows : WindowSpec
    use : {"both", "acc", "gyr"}
    bars : mapping of str to float
        Least rho of mean F1 ("rho of mean F1"), mean rho by activity ("mean rho"), correlation over the cells
        ("r over cells") and rho of mean F1 over its ceiling ("rho over ceiling"), and most regret ("regret").
    parts : tuple of str
        Analyses of one kind of source each, which show what recognising the sources did to the first.
    """

    name: str
    real: Mapping[str, tuple[str, ...]]
    rules: tuple[Rule, ...]
    sites: Mapping[str, str | SensorSite | int]
    analyses: tuple[Analysis, ...]
    rate_hz: float
    sensor: SensorModel
    kinect_hz: float
    windows: WindowSpec
    use: Use
    bars: Mapping[str, float]
    parts: tuple[str, ...] = ()

    def match(self, clip: str) -> Match | None:
        """What a clip shows by the first rule that fits it; None where none does."""
        rule, who = first_rule(self.rules, clip)
        return None if rule is None else Match(rule.activity, rule.source, f"{rule.source} {who or clip}")

    def activity_of(self, real: str) -> str:
        """Our name of one of the data set's activities; empty where it takes no part."""
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
