# SPDX-License-Identifier: GPL-3.0-or-later
"""Worn and simulated F1 of a set's sites, cached, for rules that predict one site from others.

The protocol is docs/evidence/pilot.md.
"""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.files import load_arrays, write_npz
from w2w.core.findings.pilot import macro_f1
from w2w.core.imu.virtual import at_patches
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.halves import HALVINGS
from w2w.core.ranking.pooling import Pooling

from ..validation.protocol import Protocol
from ..validation.site_windows import SiteWindows
from .unpaired import RegionSimulator, load_motions, real_side

SEED = 20261128
"""Of the halves of the people, and of the pilots drawn from them."""

PARTS = ("search", "aside")
DRAWS = 20
"""Pilots of two and of three people that are drawn."""

WAYS = ("performers out", "folds of clips")
EVERY = 6
"""Of the patches away from the sites each so-many-th has a sensor."""


class Simulated(NamedTuple):
    """F1 expected at S sites, by activity, both ways."""

    activities: np.ndarray  # (A,)
    expected: np.ndarray  # (2, S, A)
    distance: np.ndarray  # (S, S): between the sites' patches at rest, m


class Worn(NamedTuple):
    """F1 of pilots at S sites: of all people of a half, then of drawn twos and threes."""

    activities: np.ndarray  # (A,)
    f1: np.ndarray  # (P, S, A); NaN where an activity cannot be tested
    people: np.ndarray  # (P,): how many
    by_person: np.ndarray  # (K, S): macro F1 of each person, of all
    chance: np.ndarray  # (S, A): with labels dealt by chance


def half_of(people: Sequence[str], part: str) -> list[str]:
    """The people of a part."""
    mixed = np.random.default_rng(SEED).permutation(sorted(set(people))).tolist()
    middle = (len(mixed) + 1) // 2
    return sorted(mixed[:middle] if part == PARTS[0] else mixed[middle:])


def simulated_f1(
    protocol: Protocol, libraries: Sequence[Path], kept: Path, told: Callable[[str], None]
) -> Simulated:
    """Expected F1 of the sites of a set, read from `kept` if it is there."""
    if not kept.exists():
        body, analysis = Body.bundled(), protocol.analyses[0]
        simulator = RegionSimulator(body, protocol, every=EVERY)
        made = simulator.side(load_motions(protocol, libraries, body, told)[0], analysis).windows
        patches = at_patches(sample_patches(body), simulator.patches)
        pooling, shown = Pooling.on(body, patches), [a for a in analysis.activities if a in made.activity]
        of_site = [np.flatnonzero(simulator.site_of == site) for site in range(len(protocol.sites))]
        maps = [made.ranked(shown, by, pooling=pooling, halvings=HALVINGS) for by in (True, False)]
        both = [a for a in maps[0].activities if a in maps[1].activities]
        expected = [
            [one.expected_f1[of].mean(axis=0)[[one.activities.index(a) for a in both]] for of in of_site]
            for one in maps
        ]
        at = body.vertices[patches.vertices]
        between = np.linalg.norm(at[:, None] - at[None], axis=2)
        distance = [[between[np.ix_(a, b)].min() for b in of_site] for a in of_site]
        write_npz(kept, Simulated(np.array(both), np.array(expected), np.array(distance))._asdict())
    return Simulated(**load_arrays(kept, Simulated._fields, "is no cache of the study"))


def worn_f1(protocol: Protocol, path: Path, part: str, activities: Sequence[str], kept: Path) -> Worn:
    """F1 of pilots of a part of the people of a set, read from `kept` if it is there."""
    if not kept.exists():
        windows = real_side(protocol, protocol.read(path), protocol.analyses[0]).windows
        everyone = half_of(windows.subject.tolist(), part)
        windows = windows.some(np.isin(windows.subject, everyone))
        found = windows.ranked(activities, by_subject=True)
        names = list(found.activities)
        rng = np.random.default_rng(SEED)
        drawn = [rng.choice(everyone, size, replace=False) for size in (2, 3) for _ in range(DRAWS)]
        pilots = [everyone, *(some.tolist() for some in drawn if len(some) <= len(everyone))]
        by_person = [
            [macro_f1(found.truth[rows], column, len(names)) for column in found.predictions[rows].T]
            for who in everyone
            for rows in [np.isin(found.clip, windows.clip[windows.subject == who])]
        ]
        write_npz(
            kept,
            Worn(
                np.array(names),
                np.stack([_pilot(windows, some, names) for some in pilots]),
                np.array([len(some) for some in pilots]),
                np.array(by_person),
                _pilot(_by_chance(windows), everyone, names),
            )._asdict(),
        )
    return Worn(**load_arrays(kept, Worn._fields, "is no cache of the study"))


def _pilot(windows: SiteWindows, people: Sequence[str], names: Sequence[str]) -> np.ndarray:
    """F1 (S, A) of some people, one left out at a time; NaN where they show too little to be tested."""
    f1 = np.full((windows.features.shape[1], len(names)), np.nan)
    try:
        found = windows.some(np.isin(windows.subject, people)).ranked(names, by_subject=True)
    except ValueError:
        return f1
    f1[:, [names.index(a) for a in found.activities]] = found.f1
    return f1


def _by_chance(windows: SiteWindows) -> SiteWindows:
    """The windows with each person's labels dealt anew among the clips."""
    rng, activity = np.random.default_rng(SEED), windows.activity.copy()
    for who in sorted(set(windows.subject.tolist())):
        clips = sorted(set(windows.clip[windows.subject == who].tolist()))
        labels = [windows.activity[windows.clip == clip][0] for clip in clips]
        for clip, label in zip(clips, rng.permutation(labels).tolist(), strict=True):
            activity[windows.clip == clip] = label
    return windows._replace(activity=activity)
