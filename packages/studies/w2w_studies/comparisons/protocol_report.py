# SPDX-License-Identifier: GPL-3.0-or-later
"""Report what a protocol's analyses found against what was asked for."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from w2w.core.files import json_number, write_json, write_text

from ..validation.by_source import replaced_sides
from ..validation.protocol import Bar, Found, Protocol
from .report import write_validation


def write_protocol(out: Path, protocol: Protocol, found: Sequence[Found]) -> str:
    """Write ``report.md`` and ``summary.json``, besides what `write_validation` writes of each analysis.

    Returns the report.
    """
    from .figures import cells_figure  # matplotlib is slow to import

    lines = [f"# {protocol.name}: worn and simulated sensors", "", *_summary(found), ""]
    for one in found:
        title = f"{protocol.name}, {one.name}"
        write_validation(out, one, title)
        cells_figure(out / figure_name(one), one.validation, title)
        lines += [f"## {one.name}", "", one.why, "", one.validation.sentence(), ""]
        lines += [one.validation.regret_sentence(), one.validation.level_sentence(), ""]
        lines += [*_bars(one.bars), ""]
        if one.ways:
            lines += [*_sources(one), "", *_transfer(one), ""]
        lines += [f"![F1 of every site and activity, real against simulated]({figure_name(one)})", ""]
        lines += [f"Activity by activity: [report{one.suffix}.md](report{one.suffix}.md).", ""]
    lines += _after_the_fact(protocol, found)
    write_json(out / "summary.json", {one.name: _content(one) for one in found})
    text = "\n".join(lines)
    write_text(out / "report.md", text)
    return text


def figure_name(found: Found) -> str:
    """File of the picture of an analysis's cells."""
    return f"cells{found.suffix}.png"


def _summary(found: Sequence[Found]) -> list[str]:
    lines = [
        "| analysis | activities | rho of mean F1 | as many others | mean rho by activity | as many others "
        "| r over cells | at most | regret | at random |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for one in found:
        v = one.validation
        cells = [
            one.name,
            str(len(v.real.activities)),
            interval(v.overall.spearman, v.overall.low, v.overall.high),
            interval(*v.overall_ceiling),
            interval(v.mean_rho, v.mean_low, v.mean_high),
            interval(*v.ceiling),
            interval(*v.cells),
            f"{v.cells_ceiling:.2f}",
            f"{v.regret.lost:.3f} ({v.regret.low:.3f} to {v.regret.high:.3f})",
            f"{v.regret.at_random:.3f}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _after_the_fact(protocol: Protocol, found: Sequence[Found]) -> list[str]:
    """The test again with one side at a time scored source by source, where the analyses allow it."""
    parts = [one.validation for one in found if one.name in protocol.parts]
    if not parts or len(parts) < len(protocol.parts):
        return []
    lines = [
        "## Whether sources were recognised",
        "",
        "An experiment, thought of after the test: each activity is scored within the analyses of one kind "
        "of source, where the source says nothing, on one side at a time.",
        "",
        "| F1 of | rho of mean F1 | mean rho by activity | r over cells | regret |",
        "|---|---|---|---|---|",
    ]
    for name, v in replaced_sides(found[0].validation, parts).items():
        cells = [
            name,
            interval(v.overall.spearman, v.overall.low, v.overall.high),
            interval(v.mean_rho, v.mean_low, v.mean_high),
            interval(*v.cells),
            f"{v.regret.lost:.3f} ({v.regret.low:.3f} to {v.regret.high:.3f})",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, ""]


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
        "bars": [{**bar._asdict(), "found": json_number(bar.found)} for bar in found.bars],
        "source_tests": [
            {"activity": test.activity, "sources": list(test.sources), "f1": test.f1.round(6).tolist()}
            for test in found.source_tests
        ],
        "trained_on_simulated": {way.way: way.simulated.round(6).tolist() for way in found.ways},
        "trained_on_real": {way.way: way.real.round(6).tolist() for way in found.ways},
    }
