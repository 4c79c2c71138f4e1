# SPDX-License-Identifier: GPL-3.0-or-later
"""The data sets that a protocol was fixed for, and one page of what all of them say."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from w2w.core.body.body import Body
from w2w.core.csv_tables import csv_text
from w2w.core.files import write_text

from ..datasets.mighar import MIGHAR_SENSORS, read_positions
from ..validation.dsads import DSADS
from ..validation.mhad import MHAD
from ..validation.mighar import mighar
from ..validation.protocol import Found, Protocol
from ..validation.umafall import UMAFALL
from ..validation.upfall import UPFALL
from .by_protocol import compare_worn
from .protocol_report import figure_name, interval
from .simple_rules import RULES
from .unpaired import RegionSimulator, library_simulation

PAGE = "truth.md"


DATA_SETS: Mapping[str, Protocol] = {"mhad": MHAD, "umafall": UMAFALL, "dsads": DSADS, "upfall": UPFALL}


def mighar_set(positions: Path, told: Callable[[str], None]) -> Protocol:
    """The MIG HAR garment at the sites where a user placed its sensors.

    Raises ValueError, OSError if the csv is wrong, or no region is called so.
    """
    protocol = mighar(read_positions(positions), told)
    RegionSimulator(Body.bundled(), protocol)  # a wrong region is said before minutes of reading
    return protocol


def against_libraries(
    protocol: Protocol, path: Path, libraries: Sequence[Path], seed: int, told: Callable[[str], None]
) -> list[Found]:
    """Hold the worn sensors of a data set against clips of libraries."""
    worn = protocol.read(path)
    return compare_worn(protocol, worn, library_simulation(protocol, libraries, seed, told), seed, told)


def write_empty_positions(path: Path) -> None:
    """Write a csv of all sensors of the garment, for a user to say where they are."""
    rows = [["sensor", "region", "vertex"], *([sensor, "", ""] for sensor in range(MIGHAR_SENSORS))]
    write_text(path, csv_text(rows))


def write_page(out: Path, found: Mapping[str, Sequence[Found]], names: Mapping[str, str]) -> str:
    """Write ``truth.md``: sets by agreement, ceiling, regret and transfer, and a figure each.

    `found`: by the folder of a set.
    `names`: what each set is called.
    """
    lines = ["# Does W2W predict real people?", "", *_table(found, names), ""]
    lines += [
        "Rho of mean F1 over the sites, real against simulated; the ceiling is what as many other people "
        "would reach, from random halves by Spearman-Brown. Regret is the real F1 lost by wearing the sensor "
        "where the simulation says instead of at the really best site; then by rules that need no "
        "ranking. Level: how far simulated F1 lies "
        "above people's. In brackets 95 % intervals over people and clips.",
        "",
    ]
    for name, analyses in found.items():
        lines += [f"## {names[name]}", ""]
        for one in analyses:
            missed = [
                f"{bar.what} ({bar.found:.2f}, asked for {bar.wanted})" for bar in one.bars if not bar.met
            ]
            verdict = f"Missed: {', '.join(missed)}." if missed else "All that was asked for is reached."
            picture = f"{name}/{figure_name(one)}"
            lines += [f"### {one.name}", "", f"{one.why} {verdict}", ""]
            lines += [f"![Real against simulated F1]({picture})", ""]
        lines += [f"All of it: [{name}/report.md]({name}/report.md).", ""]
    text = "\n".join(lines)
    write_text(out / PAGE, text)
    return text


def _table(found: Mapping[str, Sequence[Found]], names: Mapping[str, str]) -> list[str]:
    lines = [
        "| data set | analysis | activities, sites | rho of mean F1 | ceiling | mean rho by activity "
        f"| ceiling | regret | {' | '.join(RULES)} | at random | level | trained on simulated "
        "| trained on people |",
        "|---" * (12 + len(RULES)) + "|",
    ]
    for name, analyses in found.items():
        for one in analyses:
            v = one.validation
            best = max(one.ways, key=lambda way: way.simulated.mean())
            cells = [
                names[name],
                one.name,
                f"{len(v.real.activities)}, {len(v.sites)}",
                interval(v.overall.spearman, v.overall.low, v.overall.high),
                f"{v.overall_ceiling.value:.2f}",
                interval(v.mean_rho, v.mean_low, v.mean_high),
                f"{v.ceiling.value:.2f}",
                f"{v.regret.lost:.3f} ({v.regret.low:.3f} to {v.regret.high:.3f})",
                *(f"{one.rules[rule]:.3f}" if rule in one.rules else "" for rule in RULES),
                f"{v.regret.at_random:.3f}",
                f"{v.level.value:+.2f} ({v.level.low:+.2f} to {v.level.high:+.2f})",
                f"{best.simulated.mean():.2f} ({best.way})",
                f"{best.real.mean():.2f}",
            ]
            lines.append(f"| {' | '.join(cells)} |")
    return lines
