# SPDX-License-Identifier: GPL-3.0-or-later
"""Run all analyses of a protocol."""

from collections.abc import Callable, Sequence

import numpy as np

from ..validation.protocol import Analysis, Found, Protocol
from ..validation.site_transfer import WayFound, site_signals, try_ways
from ..validation.sites import validate_sites
from ..validation.source_test import source_tests
from .unpaired import Sides


def run_protocol(
    protocol: Protocol,
    sides_of: Callable[[Analysis], Sides | None],
    seed: int = 0,
    told: Callable[[str], None] = lambda _: None,
) -> list[Found]:
    """Do every analysis that has two activities, with the sides that `sides_of` makes.

    `told` is given a sentence for each analysis that cannot be done.

    Raises ValueError if no analysis can be done; the message says why.
    """
    done, why = [], []
    for analysis in protocol.analyses:
        try:
            sides = sides_of(analysis)
            if sides is None:
                continue
            found = validate_sites(
                sides.real.windows, sides.simulated.windows, sides.sites, sides.activities, protocol.folds,
                protocol.by_subject, seed, sides.site_of, sides.real_site_of, protocol.classifier,
                protocol.background,
            )  # fmt: skip
        except ValueError as error:
            if protocol.joints:
                raise
            why.append(f"{analysis.name}: {error}")
            told(f"Not done: {why[-1]}.")
            continue
        one = Found(
            analysis.name, analysis.why, found, sides.notes, sides.simulated_at, protocol.judge(found)
        )
        made = sides.simulated
        if made.source_of:
            one = one._replace(
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
