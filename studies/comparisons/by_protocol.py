# SPDX-License-Identifier: GPL-3.0-or-later
"""Run all analyses of a protocol."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.imu.recording import ImuRecording

from ..validation.protocol import Analysis, Bar, Protocol
from ..validation.site_transfer import WayFound, site_signals, try_ways
from ..validation.sites import SiteValidation, validate_sites
from ..validation.source_test import SourceTest, source_tests
from .unpaired import RegionSimulator, Side, clips_in_words, load_motions, real_side


class Found(NamedTuple):
    """What an analysis found.

    Attributes
    ----------
    analysis : Analysis
    validation : SiteValidation
    bars : list of Bar
    source_tests : list of SourceTest
    ways : list of WayFound
        Trained on simulated, tested on worn sensors.
    notes : list of str
    simulated_at : tuple of str
        What stood for each site.
    """

    analysis: Analysis
    validation: SiteValidation
    bars: list[Bar]
    source_tests: list[SourceTest]
    ways: list[WayFound]
    notes: list[str]
    simulated_at: tuple[str, ...]


def run_protocol(
    protocol: Protocol,
    recordings: Sequence[ImuRecording],
    libraries: Sequence[Path],
    seed: int = 0,
    told: Callable[[str], None] = lambda _: None,
    real_site_of: np.ndarray | None = None,
) -> list[Found]:
    """Do every analysis for which the libraries have two activities.

    Parameters
    ----------
    protocol : Protocol
    recordings : sequence of ImuRecording
        Of the worn sensors, under the data set's own names of activities.
    libraries : sequence of Path
    seed : int
    told : callable
        Given a sentence for each library of which nothing is used and each analysis that cannot be done.
    real_site_of : ndarray of int, optional
        Site of each worn sensor, where a site has several; by default each sensor is a site.

    Raises
    ------
    ValueError
        If none can be done; the message says why.
    """
    body = Body.bundled()
    motions, unusable = load_motions(protocol, libraries, body, told)
    simulator = RegionSimulator(body, protocol, seed)
    worn_at = np.arange(len(protocol.sites)) if real_site_of is None else real_site_of
    worn_sites = recordings[0].sites if real_site_of is not None else ()
    done, why = [], []
    for analysis in protocol.analyses:
        try:
            simulated = simulator.side(motions, analysis)
            real = real_side(protocol, recordings, analysis, worn_sites)
            found = validate_sites(
                real.windows, simulated.windows, tuple(protocol.sites), analysis.activities,
                by_subject=(True, True), seed=seed, site_of=simulator.site_of, real_site_of=worn_at,
            )  # fmt: skip
        except ValueError as error:
            why.append(f"{analysis.name}: {error}")
            told(f"Not done: {why[-1]}.")
            continue
        shown = [moving for moving in motions if moving.motion.clip in simulated.source_of]
        notes = [
            analysis.why,
            "Unpaired: other people, other rooms, other instructions than in the simulated clips.",
            f"Distinct simulated motions: {clips_in_words(shown)}.",
            *(
                f"{side} clips that could not be used: {len(reasons)}; the first: {reasons[0]}."
                for side, reasons in (
                    ("Library", unusable),
                    ("Simulated", list(simulated.windows.skipped.values())),
                    ("Real", list(real.windows.skipped.values())),
                )
                if reasons
            ),
        ]
        tests = source_tests(simulated.windows, simulated.source_of, simulator.site_of, seed)
        ways = _ways(protocol, real, simulated, found.real.activities, (worn_at, simulator.site_of), seed)
        done.append(Found(analysis, found, protocol.judge(found), tests, ways, notes, simulator.simulated_at))
    if not done:
        raise ValueError(f"no analysis of {protocol.name} can be done: {'; '.join(why)}")
    return done


def _ways(
    protocol: Protocol,
    real: Side,
    simulated: Side,
    activities: Sequence[str],
    site_of: tuple[np.ndarray, np.ndarray],
    seed: int,
) -> list[WayFound]:
    spec, use = protocol.windows, protocol.use
    worn = site_signals(real.recordings, activities, spec, site_of[0], use)
    made = site_signals(simulated.recordings, activities, spec, site_of[1], use)
    return try_ways(worn, made, len(activities), seed)
