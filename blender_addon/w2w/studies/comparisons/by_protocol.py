# SPDX-License-Identifier: GPL-3.0-or-later
"""Run all analyses of a protocol."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..validation.protocol import Found, Protocol
from ..validation.site_transfer import WayFound, site_signals, try_ways
from ..validation.sites import validate_sites
from ..validation.source_test import source_tests
from .paired import paired_sides
from .unpaired import Sides, unpaired_sides


def run_protocol(
    protocol: Protocol,
    worn: Sequence[Any],
    libraries: Sequence[Path] = (),
    seed: int = 0,
    told: Callable[[str], None] = lambda _: None,
) -> list[Found]:
    """Do every analysis that has two activities, with what `protocol.read` gives.

    `told` is given a sentence for each library of no use and each analysis that cannot be done.

    Raises ValueError if no analysis can be done; the message says why.
    """
    if protocol.joints:
        sides_of = partial(paired_sides, protocol, worn, seed)
    else:
        sides_of = unpaired_sides(protocol, worn, libraries, seed, told)
    done, why = [], []
    for analysis in protocol.analyses:
        try:
            sides = sides_of(analysis)
            if sides is None:
                continue
            found = validate_sites(
                sides.real.windows, sides.simulated.windows, sides.sites, sides.activities, protocol.folds,
                (not protocol.joints,) * 2, seed, sides.site_of, sides.real_site_of, protocol.classifier,
                protocol.background,
            )  # fmt: skip
        except ValueError as error:
            if protocol.joints:
                raise
            why.append(f"{analysis.name}: {error}")
            told(f"Not done: {why[-1]}.")
            continue
        one = Found(analysis.name, analysis.why, found, sides.notes, sides.simulated_at)
        if protocol.rules:
            made = sides.simulated
            one = one._replace(
                bars=protocol.judge(found),
                source_tests=source_tests(made.windows, made.source_of, sides.site_of, seed),
                ways=_ways(protocol, sides, found.real.activities, seed),
            )
        done.append(one)
    if not done:
        what = "; ".join(why) or "no sensors were worn in trials of two activities"
        raise ValueError(f"no analysis of {protocol.name} can be done: {what}")
    return done


def _ways(protocol: Protocol, sides: Sides, activities: Sequence[str], seed: int) -> list[WayFound]:
    spec, use = protocol.windows, protocol.use
    worn_at = np.arange(len(sides.sites)) if sides.real_site_of is None else sides.real_site_of
    worn = site_signals(sides.real.recordings, activities, spec, worn_at, use)
    made = site_signals(sides.simulated.recordings, activities, spec, sides.site_of, use)
    return try_ways(worn, made, len(activities), seed)
