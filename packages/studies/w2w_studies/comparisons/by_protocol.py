# SPDX-License-Identifier: GPL-3.0-or-later
"""Run all analyses of a protocol, whatever data set and whatever simulation it compares."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording

from ..validation.protocol import Analysis, Found, Protocol
from ..validation.site_transfer import WayFound, site_signals, try_ways
from ..validation.sites import validate_sites
from ..validation.source_test import source_tests
from .simple_rules import regrets
from .unpaired import Side, Simulated, real_side, skipped_note


class Sides(NamedTuple):
    """Both sides of an analysis: what is compared, and what a reader must know."""

    real: Side
    simulated: Side
    sites: tuple[str, ...]
    activities: tuple[str, ...]
    notes: list[str]
    simulated_at: tuple[str, ...]
    site_of: np.ndarray | None = None
    """Site of each simulated sensor, and of each real one, where a site has several."""
    real_site_of: np.ndarray | None = None


def compare_worn(
    protocol: Protocol,
    worn: Sequence[ImuRecording],
    simulate: Callable[[Analysis], Simulated],
    seed: int = 0,
    told: Callable[[str], None] = lambda _: None,
) -> list[Found]:
    """Hold worn sensors, of any data set or one's own, against what a run or libraries simulate.

    `told` is given a sentence for each analysis that cannot be done.

    Raises ValueError if no analysis can be done; the message says why.
    """
    return run_protocol(protocol, partial(worn_sides, protocol, worn, simulate), seed, told)


def worn_sides(
    protocol: Protocol,
    worn: Sequence[ImuRecording],
    simulate: Callable[[Analysis], Simulated],
    analysis: Analysis,
) -> Sides:
    """Worn and simulated sensors of an analysis."""
    made, real = simulate(analysis), real_side(protocol, worn, analysis)
    lost = sorted({one.subject for one in real.recordings} - set(real.windows.subject.tolist()))
    rates = [f"{side.recordings[0].rate:g} Hz" for side in (real, made.side)]
    notes = [
        analysis.why,
        "Unpaired: other people, other rooms, other instructions than in the simulated clips.",
        *([f"Worn at {rates[0]}, simulated at {rates[1]}."] if rates[0] != rates[1] else []),
        *made.notes,
    ]
    for name, side in (("Simulated", made.side), ("Real", real)):
        if skipped := side.windows.skipped:
            notes.append(f"{name} {skipped_note(skipped.values())}")
    if lost:
        notes.append(f"People of whom no clip can be used: {', '.join(lost)}.")
    sites = analysis.sites or tuple(protocol.sites)
    activities = tuple(dict.fromkeys(map(analysis.label, analysis.activities)))
    return Sides(real, made.side, sites, activities, notes, made.at, made.site_of, protocol.worn_site_of)


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
            if protocol.joints or len(protocol.analyses) == 1:
                raise
            why.append(f"{analysis.name}: {error}")
            told(f"Not done: {why[-1]}.")
            continue
        one = Found(
            analysis.name, analysis.why, found, sides.notes, sides.simulated_at, protocol.judge(found),
            rules=regrets(found, sides.simulated.recordings, sides.site_of),
        )  # fmt: skip
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
