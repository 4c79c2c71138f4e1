# SPDX-License-Identifier: GPL-3.0-or-later
"""How much of the F1 that a run expects at a site do people's sensors there reach?

    python -m w2w.studies.experiments.expected_at_sites LIBRARY... --mhad acc.npz --umafall umafall.npz
        --dsads DSADS --upfall CompleteDataSet.csv [--every 1]     # any of them

The first analysis of each set, as its protocol fixes it, with simulated sensors on the sites' patches and
every so many of the others, of 512 in all: the map that a run shows, with performers left out as people are
(styles or clips where they have no name) and with folds of clips, as runs have by default. Printed for each:
a row for every site (its patches' mean raw F1, mean expected F1 and mean ends of the interval, people's F1),
a row for every activity (its clips, raw F1 and people's F1, means over the sites), then Spearman's rho of
either map with people's F1, and how far either lies above people's on average.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import spearmanr

from w2w.core.body.body import Body
from w2w.core.imu.virtual import at_patches
from w2w.core.patches.patches import sample_patches
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import HALVINGS

from ..comparisons.truth import DATA_SETS
from ..comparisons.unpaired import RegionSimulator, load_motions, real_side
from ..validation.protocol import Protocol


def rows(protocol: Protocol, path: Path, libraries: Sequence[Path], every: int) -> Iterator[str]:
    """Lines of a table."""
    body, analysis = Body.bundled(), protocol.analyses[0]
    simulator = RegionSimulator(body, protocol, every=every)
    worn = real_side(protocol, protocol.read(path), analysis).windows
    made = simulator.side(load_motions(protocol, libraries, body)[0], analysis).windows
    pooling = Pooling.on(body, at_patches(sample_patches(body), simulator.patches))
    of_site = [np.flatnonzero(simulator.site_of == site) for site in range(len(protocol.sites))]
    for by_subject in (True, False):
        shared = [one for one in analysis.activities if (made.activity == one).any()]
        simulated = made.ranked(shared, by_subject, pooling=pooling, halvings=HALVINGS)
        people = worn.ranked(simulated.activities, by_subject=True)
        if people.activities != simulated.activities:
            simulated = made.ranked(people.activities, by_subject, pooling=pooling, halvings=HALVINGS)
        maps = (simulated.mean, simulated.expected_mean, simulated.expected_low, simulated.expected_high)
        raw, expected, low, high = ([one[of].mean() for of in of_site] for one in maps)
        way = "performers" if by_subject else "clips"
        for site, *values in zip(protocol.sites, raw, expected, low, high, people.mean, strict=True):
            r, e, a, b, f1 = (f"{value:.2f}".removeprefix("0") for value in values)
            yield f"| {protocol.name}, {way} | {site} | {r} | {e} ({a} to {b}) | {f1} |"
        rho = ", ".join(f"{spearmanr(one, people.mean)[0]:.2f}" for one in (raw, expected))
        above = (np.subtract(one, people.mean).mean() for one in (raw, expected))
        inside = sum(bool(a <= f1 <= b) for a, b, f1 in zip(low, high, people.mean, strict=True))
        over = ", ".join(f"{one:.3f}" for one in above)
        at_sites = np.mean([simulated.f1[of].mean(axis=0) for of in of_site], axis=0)
        clips = [len(np.unique(made.clip[made.activity == one])) for one in simulated.activities]
        for activity, of_it, *f1 in zip(
            simulated.activities, clips, at_sites, people.f1.mean(axis=0), strict=True
        ):
            yield f"| {protocol.name}, {way} | {activity}, {of_it} clips | {f1[0]:.2f} | {f1[1]:.2f} |"
        yield (
            f"{protocol.name}, {way}: {len(people.activities)} activities; rho of raw and of expected F1 "
            f"{rho}; above people's by {over}; {inside} of {len(raw)} intervals hold it"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("libraries", type=Path, nargs="+")
    for name in DATA_SETS:
        parser.add_argument(f"--{name}", type=Path)
    parser.add_argument("--every", type=int, default=1)
    given = parser.parse_args()
    for name, protocol in DATA_SETS.items():
        if path := getattr(given, name):
            for row in rows(protocol, path, given.libraries, given.every):
                print(row, flush=True)


if __name__ == "__main__":
    main()
