# SPDX-License-Identifier: GPL-3.0-or-later
"""The placement challenge: anybody's ranking of sites, judged by people who wore sensors there."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.csv_tables import csv_text, read_table
from w2w.core.wording import clean

from ..datasets.utd_mhad import read_utd_mhad
from ..validation.protocol import Protocol
from ..validation.site_scores import SiteScores
from ..validation.site_windows import site_windows
from ..validation.sites import SiteValidation, compare_scores
from .unpaired import real_side, scores_of
from .utd import WINDOW

SEED = 0
"""Seed of folds, resamples and halves of the people: the same for everybody."""

COLUMNS = ("data_set", "activity", "site", "score")
HEADINGS = (
    "data set", "method", "activities, sites", "rho of mean F1", "ceiling", "mean rho by activity", "ceiling",
    "regret", "at random",
)  # fmt: skip

UTD, WRIST = "UTD-MHAD", "right wrist"

UNSHOWN = ("jumping jacks", "phone call", "open a door", "upstairs")
"""Activities of which no motion library at hand shows two clips: as in docs/truth.md, they take no part."""

Method = Mapping[str, Mapping[tuple[str, str], float]]
"""Scores by data set, then by activity (empty for all of them) and site."""


class Judge(NamedTuple):
    """What people's sensors say of a data set."""

    name: str
    sites: tuple[str, ...]
    activities: tuple[str, ...]
    scores: SiteScores  # of what is ranked: sites, or activities where one sensor was worn at a time

    @property
    def of_activities(self) -> bool:
        """Whether the activities at one site are ranked."""
        return len(self.sites) == 1


def judge_of(protocol: Protocol, path: Path) -> Judge:
    """The judge of an unpaired data set: the activities of its test that its people can be tested on."""
    test = protocol.analyses[0]
    activities = [name for name in test.activities if name not in UNSHOWN]
    real = real_side(protocol, protocol.read(path), test._replace(activities=tuple(activities)))
    scores = scores_of(real.windows, activities, protocol.worn_site_of, SEED)
    return Judge(protocol.name, tuple(protocol.sites), scores.activities, scores)


def judge_of_utd(path: Path) -> Judge:
    """UTD-MHAD's judge: which of its 21 actions the sensor on the wrist recognises best."""
    worn = [trial.recording for trial in read_utd_mhad(path) if trial.recording.sites == (WRIST,)]
    windows = site_windows(worn, WINDOW)
    scores = scores_of(windows, sorted(set(windows.activity.tolist())), None, SEED)
    return Judge(UTD, (WRIST,), scores.activities, turned_over(scores))


def turned_over(scores: SiteScores) -> SiteScores:
    """Scores whose activities stand where the sites did."""
    return replace(
        scores,
        activities=("all",),
        f1=scores.f1.T,
        samples=np.swapaxes(scores.samples, -1, -2),
        halves=np.swapaxes(scores.halves, -1, -2),
    )


def read_method(path: Path) -> dict[str, dict[tuple[str, str], float]]:
    """Read a ranking: a csv with columns ``data_set, site, score`` and, if wanted, ``activity``.

    A higher score is better. Raises ValueError if it is no such table; the message says which line.
    """
    found: dict[str, dict[tuple[str, str], float]] = {}
    for line, row in read_table(path, ("data_set", "site", "score"), ("activity",)).rows:
        try:
            score = float(row["score"])
        except ValueError:
            score = np.nan
        if not np.isfinite(score):
            raise ValueError(f"{clean(path)}, line {line}: '{row['score']}' is no score")
        found.setdefault(row["data_set"], {})[row["activity"], row["site"]] = score
    return found


def method_csv(method: Method) -> str:
    """A ranking as a csv that `read_method` reads."""
    rows = [
        (name, activity, site, f"{score:.6f}")
        for name, scores in method.items()
        for (activity, site), score in scores.items()
    ]
    return csv_text([COLUMNS, *rows])


def judged(judge: Judge, method: Method) -> SiteValidation | None:
    """What a method's scores are worth; None if it says nothing of the data set.

    An activity that it leaves out has the scores that it gives without an activity, else the mean of those
    that it gives with one. Raises ValueError if a site has no score at all.
    """
    given = method.get(judge.name)
    if not given:
        return None
    table = np.array([[_score(given, judge, a, s) for a in judge.activities] for s in judge.sites])
    made = table.T if judge.of_activities else table
    ranked = judge.activities if judge.of_activities else judge.sites
    scores = judge.scores
    fixed = replace(
        scores,
        f1=made,
        samples=np.broadcast_to(made, scores.samples.shape),
        halves=np.broadcast_to(made, scores.halves.shape),
    )
    return compare_scores(scores, fixed, ranked, SEED)


def _score(given: Mapping[tuple[str, str], float], judge: Judge, activity: str, site: str) -> float:
    for key in ((activity, site), ("", site)):
        if key in given:
            return given[key]
    others = [score for (_, where), score in given.items() if where == site]
    if not others:
        raise ValueError(
            f"{judge.name}: no score for the site '{site}'; its sites are {', '.join(judge.sites)}"
        )
    return float(np.mean(others))


def table_of(judges: Sequence[Judge], methods: Mapping[str, Method]) -> list[list[str]]:
    """A row a data set and method, under HEADINGS; a random choice first."""
    rows = []
    for judge in judges:
        size = f"{len(judge.activities)}, {len(judge.sites)}"
        nothing = judged(judge, {judge.name: {("", site): 0.0 for site in judge.sites}})
        at_random = "" if judge.of_activities else f"{nothing.regret.at_random:.3f}"
        by_activity = "" if judge.of_activities else f"{nothing.ceiling.value:.2f}"
        ceiling = f"{nothing.overall_ceiling.value:.2f}"
        rows.append(
            [judge.name, "random", size, "0", ceiling, by_activity and "0", by_activity, at_random, at_random]
        )
        for name, method in methods.items():
            found = judged(judge, method)
            if found is None:
                rows.append([judge.name, name, size, *["not given"] * 6])
                continue
            whole, lost = found.overall, found.regret
            regret = f"{lost.lost:.3f} ({lost.low:.3f} to {lost.high:.3f})"
            cells = [
                _rho(whole.spearman, whole.low, whole.high),
                ceiling,
                "" if judge.of_activities else _rho(found.mean_rho, found.mean_low, found.mean_high),
                by_activity,
                "" if judge.of_activities else regret,
                at_random,
            ]
            rows.append([judge.name, name, size, *cells])
    return rows


def _rho(value: float, low: float, high: float) -> str:
    return f"{value:.2f} ({low:.2f} to {high:.2f})" if np.isfinite(value) else "no order"
