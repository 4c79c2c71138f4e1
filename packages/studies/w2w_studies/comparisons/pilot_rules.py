# SPDX-License-Identifier: GPL-3.0-or-later
"""Rules that predict people's F1 at a site from a map and from F1 worn at others, and how far each is off.

Fixed in docs/evidence/pilot.md.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.special import expit, logit

from w2w.core.findings.pilot import half_width, learned, levelled, width_with

from .pilot import Simulated, Worn

EDGE = 0.02
"""F1 is kept this far from 0 and 1 in log odds."""

Rule = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""Macro F1 (S,) predicted from that expected (S,), that worn at some sites (K,) and their numbers (K,)."""


def no_pilot(e: np.ndarray, *_: np.ndarray) -> np.ndarray:
    """The map as it is."""
    return e


def for_all(e: np.ndarray, w: np.ndarray, *_: np.ndarray) -> np.ndarray:
    """F1 of the worn sites everywhere."""
    return np.full_like(e, w.mean())


def shift(e: np.ndarray, w: np.ndarray, at: np.ndarray, k: float = 1.0) -> np.ndarray:
    """The map moved by a share of the difference."""
    return e + k * (w - e[at]).mean()


def less_noise(e: np.ndarray, w: np.ndarray, at: np.ndarray, c: float) -> np.ndarray:
    """The map moved by the difference less what is noise."""
    d = (w - e[at]).mean()
    return e + d * max(0.0, 1 - (c / d) ** 2) if d else e


def log_odds(e: np.ndarray, w: np.ndarray, at: np.ndarray, k: float) -> np.ndarray:
    """The map moved by a share of the difference in log odds."""
    odds, worn = (logit(np.clip(f1, EDGE, 1 - EDGE)) for f1 in (e, w))
    return expit(odds + k * (worn - odds[at]).mean())


def between(e: np.ndarray, w: np.ndarray, at: np.ndarray, k: float) -> np.ndarray:
    """F1 of the worn sites with a share of the map's contrast."""
    return w.mean() + k * (e - e[at].mean())


def rules() -> dict[str, Rule]:
    """All rules for macro F1 from one site, in the order of the table."""
    found: dict[str, Rule] = {
        "no pilot": no_pilot,
        "worn site's F1 for all": for_all,
        "constant shift": shift,
    }
    found |= {f"shrunk shift {k}": partial(shift, k=k) for k in (0.5, 0.6, 0.7, 0.8, 0.9)}
    found |= {f"shift less noise {c}": partial(less_noise, c=c) for c in (0.03, 0.05, 0.08)}
    found |= {f"log odds {k}": partial(log_odds, k=k) for k in (0.7, 0.85, 1.0)}
    return found | {f"between {k}": partial(between, k=k) for k in (0.25, 0.5, 0.75)}


class Case(NamedTuple):
    """One set and way: F1 by site and activity that is expected, of all people, and of each pilot."""

    by_person: np.ndarray  # (K, S): macro F1
    e: np.ndarray  # (S, A)
    w: np.ndarray  # (S, A)
    pilots: np.ndarray  # (P, S, A)
    people: np.ndarray  # (P,)
    distance: np.ndarray  # (S, S)


def cases(made: Simulated, worn: Worn) -> list[Case]:
    """Both ways of a set, over the activities of both sides."""
    names = [name for name in made.activities.tolist() if name in worn.activities.tolist()]
    of_made, of_worn = ([one.activities.tolist().index(name) for name in names] for one in (made, worn))
    f1 = worn.f1[..., of_worn]
    return [
        Case(worn.by_person, e[:, of_made], f1[0], f1, worn.people, made.distance)
        for e in made.expected.astype(float)
    ]


def tries(case: Case, sites: int, people: int | None = None) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Worn sites (K,) and F1 (K, A) there: of everyone, or of each pilot of so many people."""
    chosen = [0] if people is None else np.flatnonzero(case.people[1:] == people) + 1
    for pilot in chosen:
        for at in combinations(range(len(case.e)), sites):
            w = case.pilots[pilot, list(at)]
            if not np.isnan(w).any():
                yield np.array(at), w


def left_out(case: Case, at: np.ndarray) -> np.ndarray:
    """Numbers of the sites that were not worn."""
    return np.setdiff1d(np.arange(len(case.e)), at)


def errors(case: Case, rule: Rule, sites: int = 1, people: int | None = None) -> np.ndarray:
    """Predicted less worn macro F1 at sites left out, over all pilots."""
    e, w = case.e.mean(axis=1), case.w.mean(axis=1)
    found = [
        (np.clip(rule(e, some.mean(axis=1), at), 0, 1) - w)[left_out(case, at)]
        for at, some in tries(case, sites, people)
    ]
    return np.concatenate(found) if found else np.array([np.nan])


def by_activity_errors(case: Case, rule: Rule, m: float) -> np.ndarray:
    """Predicted less worn F1 of each activity at sites left out, from one site."""
    e, found = case.e.mean(axis=1), []
    for at, some in tries(case, 1):
        level = rule(e, some.mean(axis=1), at) - e
        d = (some - case.e[at]).mean(axis=0)
        predicted = np.clip(case.e + level[:, None] + m * (d - d.mean()), 0, 1)
        found.append((predicted - case.w)[left_out(case, at)].ravel())
    return np.concatenate(found)


def by_distance_errors(case: Case, sites: int, length: float) -> np.ndarray:
    """Predicted less worn macro F1 at sites left out, worn sites' shifts weighted by nearness."""
    e, w = case.e.mean(axis=1), case.w.mean(axis=1)
    found = []
    for at, some in tries(case, sites):
        weight = np.exp(-case.distance[:, at] / length)
        predicted = e + (weight * (some.mean(axis=1) - e[at])).sum(axis=1) / weight.sum(axis=1)
        found.append((np.clip(predicted, 0, 1) - w)[left_out(case, at)])
    return np.concatenate(found)


def regrets(case: Case, rule: Rule, sites: int = 1) -> np.ndarray:
    """People's F1 lost at the site that each pilot's prediction ranks first."""
    e, w = case.e.mean(axis=1), case.w.mean(axis=1)
    return np.array([w.max() - w[rule(e, some.mean(axis=1), at).argmax()] for at, some in tries(case, sites)])


class Held(NamedTuple):
    """The frozen rule on a case."""

    errors: np.ndarray  # predicted less worn macro F1 at sites left out
    inside: np.ndarray  # whether the 90 % interval held it
    by_activity: np.ndarray  # predicted less worn F1 of each activity


def frozen(case: Case, sites: int = 1, people: int | None = None) -> Held:
    """Errors and intervals of the product's rule."""
    n = people or len(case.by_person)
    spread = case.by_person.std(axis=0, ddof=1)
    macro, inside, each = [], [], []
    for at, some in tries(case, sites, people):
        out = left_out(case, at)
        predicted = levelled(case.e, (learned(some, n) - case.e[at]).mean(axis=0))
        off = (predicted.mean(axis=1) - case.w.mean(axis=1))[out]
        own = case.by_person[:, at].mean(axis=1)
        half = width_with(float(spread[at].mean()), n, sites) if people else half_width(own, sites)
        macro.append(off)
        inside.append(np.abs(off) <= half)
        each.append((predicted - case.w)[out].ravel())
    if not macro:
        return Held(*[np.array([np.nan])] * 3)
    return Held(*map(np.concatenate, (macro, inside, each)))


def mean_abs(of: Sequence[np.ndarray]) -> float:
    """Mean absolute error."""
    return float(np.nanmean(np.abs(np.concatenate(of))))
