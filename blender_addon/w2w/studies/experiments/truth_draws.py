# SPDX-License-Identifier: GPL-3.0-or-later
r"""How far one draw of the sensors' errors moves the comparison with real people.

    python -m w2w.studies.experiments.truth_draws LIBRARY... --mhad acc.npz --umafall umafall.npz \
        --dsads DSADS [--draws 8]

Every analysis of `w2w study truth`, with the errors of the simulated sensors drawn anew each time and all
else (people, clips, folds) left as it is. Printed for each: what the first draw gives, which is the command's
own, the median and the range over the draws, in how many draws each bar is met, and how often simulation
calls which site the best. An analysis that has parts is scored by them, too.
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body

from ..comparisons.leave_out import scores_of
from ..comparisons.truth import DATA_SETS
from ..comparisons.unpaired import RegionSimulator, load_motions, real_side
from ..validation.by_source import replaced_sides
from ..validation.protocol import Analysis, Protocol
from ..validation.site_scores import SiteScores
from ..validation.sites import SiteValidation, compare_scores


def main() -> None:
    """Compare each set as often as asked, and print what moves."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("libraries", type=Path, nargs="+")
    for name in DATA_SETS:
        parser.add_argument(f"--{name}", type=Path)
    parser.add_argument("--draws", type=int, default=8)
    asked = vars(parser.parse_args())
    for name, protocol in DATA_SETS.items():
        if asked[name]:
            tell(protocol, draws(protocol, asked[name], asked["libraries"], asked["draws"]))


def draws(
    protocol: Protocol, path: Path, libraries: Sequence[Path], count: int
) -> dict[str, list[SiteValidation]]:
    """Each analysis by each draw; then its parts by each, where there are any."""
    body = Body.bundled()
    motions, _ = load_motions(protocol, libraries, body)
    recordings = protocol.read(path)
    found: dict[str, list[SiteValidation]] = {}
    for analysis in protocol.analyses:
        worn = real_side(protocol, recordings, analysis).windows
        real: SiteScores | None = None
        for seed in range(count):
            simulator = RegionSimulator(body, protocol, seed)
            made = simulator.side(motions, analysis).windows
            if real is None:
                names = both_test(analysis, (worn, made))
                real = scores_of(worn, names, None, 0)
            simulated = scores_of(made, names, simulator.site_of, 0)
            compared = compare_scores(real, simulated, tuple(protocol.sites))
            found.setdefault(analysis.name, []).append(compared)
    if protocol.parts:
        whole, *parts = (found[name] for name in (protocol.analyses[0].name, *protocol.parts))
        for of_draw in zip(whole, *parts, strict=True):
            for side, compared in list(replaced_sides(of_draw[0], of_draw[1:]).items())[1:]:
                found.setdefault(side, []).append(compared)
    return found


def both_test(analysis: Analysis, sides: Sequence) -> tuple[str, ...]:
    """Activities of which both sides have enough to test."""
    tested = [scores_of(side, analysis.activities, None, 0).activities for side in sides]
    return tuple(name for name in analysis.activities if all(name in of for of in tested))


def tell(protocol: Protocol, found: dict[str, list[SiteValidation]]) -> None:
    """Print a table, the bars of the analyses, and which sites are called the best."""
    what = ("rho of mean F1", "mean rho by activity", "r over cells", "regret")
    print(f"{protocol.name}: first draw; median (range)\n")
    print(f"| analysis | {' | '.join(what)} | best site |")
    print("|---|" + "---|" * (len(what) + 1))
    for name, drawn in found.items():
        values = np.array([(v.overall.spearman, v.mean_rho, v.cells.value, v.regret.lost) for v in drawn])
        digits = (2, 2, 2, 3)
        cells = [
            f"{of[0]:.{n}f}; {np.median(of):.{n}f} ({of.min():.{n}f} to {of.max():.{n}f})"
            for of, n in zip(values.T, digits, strict=True)
        ]
        best = Counter(v.sites[int(np.argmax(v.simulated.mean))] for v in drawn).most_common()
        print(f"| {name} | {' | '.join(cells)} | {', '.join(f'{site} {n}' for site, n in best)} |")
    for analysis in protocol.analyses:
        bars = [protocol.judge(v) for v in found[analysis.name]]
        met = [
            f"{of[0].what} {of[0].wanted} in {sum(bar.met for bar in of)}" for of in zip(*bars, strict=True)
        ]
        print(f"\n{analysis.name}, of {len(bars)} draws: {'; '.join(met)}")
    print(flush=True)


if __name__ == "__main__":
    main()
