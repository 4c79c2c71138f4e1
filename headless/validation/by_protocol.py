# SPDX-License-Identifier: GPL-3.0-or-later
"""Run all analyses of a protocol, and write them down with what was asked for beside what was found."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.files import write_json, write_text
from w2w.core.imu.recording import ImuRecording
from w2w.core.validation.protocol import Analysis, Bar, Protocol
from w2w.core.validation.site_transfer import WayFound, site_signals, try_ways
from w2w.core.validation.sites import SiteValidation, validate_sites
from w2w.core.validation.source_test import SourceTest, source_tests

from .report import write_validation
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
    places : tuple of str
        What stood for each site.
    """

    analysis: Analysis
    validation: SiteValidation
    bars: list[Bar]
    source_tests: list[SourceTest]
    ways: list[WayFound]
    notes: list[str]
    places: tuple[str, ...]


def run_protocol(
    protocol: Protocol,
    recordings: Sequence[ImuRecording],
    libraries: Sequence[Path],
    seed: int = 0,
    told: Callable[[str], None] = lambda _: None,
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
        Given a sentence for each analysis that cannot be done.

    Raises
    ------
    ValueError
        If none can be done; the message says why.
    """
    body = Body.bundled()
    motions, unusable = load_motions(protocol, libraries, body)
    simulator = RegionSimulator(body, protocol, seed)
    done, why = [], []
    for analysis in protocol.analyses:
        try:
            simulated = simulator.side(motions, analysis)
            real = real_side(protocol, recordings, analysis)
            found = validate_sites(
                real.windows, simulated.windows, tuple(protocol.sites), analysis.activities,
                by_subject=(True, True), seed=seed, site_of=simulator.site_of,
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
                f"{side}: {len(reasons)} clips could not be used, the first: {reasons[0]}."
                for side, reasons in (
                    ("Library", unusable),
                    ("Simulated", list(simulated.windows.skipped.values())),
                    ("Real", list(real.windows.skipped.values())),
                )
                if reasons
            ),
        ]
        tests = source_tests(simulated.windows, simulated.source_of, simulator.site_of, seed)
        ways = _ways(protocol, real, simulated, found.real.activities, simulator.site_of, seed)
        done.append(Found(analysis, found, protocol.judge(found), tests, ways, notes, simulator.places))
    if not done:
        raise ValueError(f"no analysis of {protocol.name} can be done: {'; '.join(why)}")
    return done


def _ways(
    protocol: Protocol,
    real: Side,
    simulated: Side,
    activities: Sequence[str],
    site_of: np.ndarray,
    seed: int,
) -> list[WayFound]:
    spec, use = protocol.windows, protocol.use
    worn = site_signals(real.recordings, activities, spec, np.arange(len(protocol.sites)), use)
    made = site_signals(simulated.recordings, activities, spec, site_of, use)
    return try_ways(worn, made, len(activities), seed)


def write_protocol(out: Path, protocol: Protocol, found: Sequence[Found]) -> str:
    """Write ``report.md`` and ``summary.json`` beside what `write_validation` writes of each analysis.

    Returns
    -------
    str
        The report.
    """
    from .figures import cells_figure  # matplotlib is slow to import

    lines = [f"# {protocol.name}: worn and simulated sensors", "", *_summary(found), ""]
    for one in found:
        suffix = suffix_of(one)
        title = f"{protocol.name}, {one.analysis.name}"
        write_validation(out, one.validation, title, one.notes, one.places, suffix)
        cells_figure(out / figure_name(one), one.validation, title)
        lines += [f"## {one.analysis.name}", "", one.analysis.why, "", one.validation.sentence(), ""]
        lines += [one.validation.regret_sentence(), "", *_bars(one.bars), "", *_sources(one), ""]
        lines += [*_transfer(one), ""]
        lines += [f"![F1 of every site and activity, real against simulated]({figure_name(one)})", ""]
        lines += [f"Activity by activity: [report{suffix}.md](report{suffix}.md).", ""]
    write_json(out / "summary.json", {one.analysis.name: _content(one) for one in found})
    text = "\n".join(lines)
    write_text(out / "report.md", text)
    return text


def suffix_of(found: Found) -> str:
    """What the names of an analysis's files have before their endings."""
    return f"_{found.analysis.name.replace(' ', '_').lower()}"


def figure_name(found: Found) -> str:
    """File of the picture of an analysis's cells."""
    return f"cells{suffix_of(found)}.png"


def _summary(found: Sequence[Found]) -> list[str]:
    lines = [
        "| analysis | activities | rho of mean F1 | two halves of the people | mean rho by activity | halves "
        "| r over cells | regret | blindly |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for one in found:
        v = one.validation
        cells = [
            one.analysis.name,
            str(len(v.real.activities)),
            interval(v.overall.spearman, v.overall.low, v.overall.high),
            interval(*v.overall_ceiling),
            interval(v.mean_rho, v.mean_low, v.mean_high),
            interval(*v.ceiling),
            interval(*v.cells),
            f"{v.regret.lost:.3f} ({v.regret.low:.3f} to {v.regret.high:.3f})",
            f"{v.regret.at_random:.3f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _bars(bars: Sequence[Bar]) -> list[str]:
    lines = ["| asked for | found | reached |", "|---|---|---|"]
    return lines + [
        f"| {bar.what} {bar.wanted} | {bar.found:.3f} | {'yes' if bar.met else 'no'} |" for bar in bars
    ]


def _sources(found: Found) -> list[str]:
    if not found.source_tests:
        return ["No activity is shown by two sources with two movers each."]
    sites = found.validation.sites
    lines = [
        "Where a clip is from, told within one activity (macro F1; chance is one over the sources):",
        "",
        f"| activity | sources | {' | '.join(sites)} |",
        "|---|---|" + "---|" * len(sites),
    ]
    return lines + [
        f"| {test.activity} | {', '.join(test.sources)} | {' | '.join(f'{f1:.2f}' for f1 in test.f1)} |"
        for test in found.source_tests
    ]


def _transfer(found: Found) -> list[str]:
    sites = found.validation.sites
    lines = [
        "Macro F1 on people, trained on simulated sensors; in brackets, trained on the other people:",
        "",
        f"| what is done about axes and gain | {' | '.join(sites)} | mean |",
        "|---|" + "---|" * (len(sites) + 1),
    ]
    for way in found.ways:
        pairs = [*zip(way.simulated, way.real, strict=True), (way.simulated.mean(), way.real.mean())]
        lines.append(f"| {way.way} | {' | '.join(f'{a:.2f} ({b:.2f})' for a, b in pairs)} |")
    return lines


def interval(value: float, low: float, high: float) -> str:
    """A number and its interval, in words."""
    return f"{value:.2f} ({low:.2f} to {high:.2f})"


def _content(found: Found) -> dict[str, Any]:
    return {
        "bars": [
            {**bar._asdict(), "found": round(bar.found, 6) if bar.found == bar.found else None}
            for bar in found.bars
        ],
        "source_tests": [
            {"activity": test.activity, "sources": list(test.sources), "f1": test.f1.round(6).tolist()}
            for test in found.source_tests
        ],
        "trained_on_simulated": {way.way: way.simulated.round(6).tolist() for way in found.ways},
        "trained_on_real": {way.way: way.real.round(6).tolist() for way in found.ways},
    }
