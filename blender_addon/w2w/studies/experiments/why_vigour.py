# SPDX-License-Identifier: GPL-3.0-or-later
r"""Does a ranking by simulated sensors improve where less is made of how hard they are moved?

    python -m w2w.studies.experiments.why_vigour OUT LIBRARY... --mhad acc.npz --umafall \
        umafall.npz --dsads DSADS

`why_truth` found that simulated magnitudes are what clearly loses on Berkeley MHAD. Each candidate changes
the simulated side alone; half of the people judge, as worn, as there. Chosen on one set, shown on others:

- **Chosen** on Berkeley MHAD, "all actions" and "Kinect": the candidate of the highest mean over both of rho
  by activity, of several alike (six decimals) that of the least regret. None, if that is no higher than as
  fixed.
- **Shown** on UMAFall and DSADS, the first analysis of each, run once: it helps if its rho by activity is
  higher than as fixed on both and its regret higher on neither; that is beyond doubt only where the interval
  of the difference of rho leaves 0 out. What helps becomes an option, what does not is said in docs/truth.md.

Berkeley MHAD chose `CHOSEN`, mean rho .633 against .599 as fixed, before the other sets were computed.

All candidates are computed everywhere, for reading; only the one chosen counts. "as hard as people" looks at
the worn sensors, so it cannot be chosen: it tells whether hardness is the matter at all. Every candidate is
also seen through its magnitudes alone, by judges who see magnitudes alone, for reading, too.

Candidates and rules were committed before any of this was computed. Known were docs/truth.md and, anew, the
steps of `why_truth` on Berkeley MHAD.

Written to OUT: ``vigour_<set>_<analysis>.csv``, not computed again where it stands there already.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.imu.recording import ImuRecording

from ..comparisons.leave_out import scores_of
from ..validation.site_scores import SiteScores
from ..validation.site_transfer import magnitudes
from ..validation.site_windows import SiteWindows, site_windows
from .vigour_views import (
    Sampled,
    as_hard_as_people,
    compressed,
    directions,
    same_mean_by_source,
    unit_clips,
    unit_windows,
    varied_clips,
    without_lengths,
)
from .why_rows import Row, agreement, row_of, tell
from .why_truth import Made, both_sides

LADDERS = {"mhad": ("all actions", "Kinect"), "umafall": ("all activities",), "dsads": ("all activities",)}
CHOOSING = ("mhad",)

View = Callable[[np.ndarray], np.ndarray]


class Candidate(NamedTuple):
    """What is done about how hard simulated sensors are moved."""

    name: str
    view: View | None = None  # of windows (W, N, samples, 6)
    clips: Callable[[Sequence[ImuRecording]], list[ImuRecording]] | None = None  # of all recordings
    features: str = ""  # "" or "no lengths" or "one mean": what is done to the features


AS_FIXED, ORACLE = "as fixed", "as hard as people"

CANDIDATES = (
    Candidate(AS_FIXED),
    Candidate("every window equally hard", view=unit_windows),
    Candidate("every clip equally hard", clips=unit_clips),
    Candidate("compressed", view=compressed),
    Candidate("directions alone", view=directions),
    Candidate("clips harder or less hard by chance", clips=varied_clips),
    Candidate("no features of lengths", features="no lengths"),
    Candidate("sources of one mean", features="one mean"),
)

CHOSEN = "no features of lengths"


def main() -> None:
    """All candidates on every set there is data for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("libraries", type=Path, nargs="*")
    for name in LADDERS:
        parser.add_argument(f"--{name}", type=Path)
    asked = vars(parser.parse_args())
    asked["out"].mkdir(parents=True, exist_ok=True)
    chosen_by: list[list[Row]] = []
    for name, analyses in LADDERS.items():
        for analysis in analyses if asked[name] else ():
            path = asked["out"] / f"vigour_{name}_{analysis.replace(' ', '_')}.csv"
            if path.exists():
                continue
            rows = candidates(name, asked[name], asked["libraries"], analysis)
            tell(path, f"{name}, {analysis}", rows)
            if name in CHOOSING:
                chosen_by.append(rows)
    if len(chosen_by) == sum(len(LADDERS[name]) for name in CHOOSING):
        print(f"\nchosen on {', '.join(CHOOSING)}: {chosen(chosen_by)}")


def chosen(tables: Sequence[Sequence[Row]]) -> str:
    """The candidate of the highest rho by activity over analyses; what is fixed, if none is above it."""

    def merit(number: int) -> tuple[float, float, int]:
        rows = [table[number] for table in tables]
        rho, regret = (np.mean([getattr(row, kind)[0] for row in rows]) for kind in ("by_activity", "regret"))
        return round(float(rho), 6), -round(float(regret), 6), -number

    best = max(range(len(CANDIDATES)), key=merit)
    return CANDIDATES[best].name if merit(best)[0] > merit(0)[0] else AS_FIXED


def candidates(
    name: str, path: Path, libraries: Sequence[Path], analysis_name: str, seed: int = 0
) -> list[Row]:
    """Rows of all candidates, then of their magnitudes alone, on one analysis of a data set."""
    made, names = both_sides(name, path, libraries, analysis_name, seed)
    rows = []
    for end, last in (("", None), (", magnitudes", magnitudes)):
        judges = scores_of(
            site_windows(made.worn.recordings, made.protocol.windows, made.protocol.use, view=last),
            names, None, seed,
        )  # fmt: skip
        first = None
        for candidate in (*CANDIDATES, _oracle(made)):
            stands = _scored(made, candidate, last, names, seed)
            agreed = agreement(judges, stands, people=False)
            first = agreed[1] if first is None else first
            rows.append(row_of(candidate.name + end, stands, agreed, first))
            print(rows[-1].step, flush=True)
    return rows


def _oracle(made: Made) -> Candidate:
    return Candidate(ORACLE, clips=lambda _: as_hard_as_people(made.side(""), made.worn, made.site_of))


def _scored(
    made: Made, candidate: Candidate, last: View | None, names: Sequence[str], seed: int
) -> SiteScores:
    """F1 by site of the simulated side, changed as a candidate says."""
    side, protocol = made.side(""), made.protocol
    recordings = side.recordings if candidate.clips is None else candidate.clips(side.recordings)
    views = [view for view in (candidate.view, last) if view is not None]
    windows = site_windows(recordings, protocol.windows, protocol.use, view=_in_turn(views))
    if candidate.features == "no lengths":
        rate = recordings[0].rate
        windows = without_lengths(windows, Sampled(protocol.windows.samples(rate), rate))
    if candidate.features == "one mean":
        windows = same_mean_by_source(windows, _sources(windows, side.source_of))
    return scores_of(windows, names, made.site_of, seed)


def _sources(windows: SiteWindows, source_of: dict[str, str]) -> np.ndarray:
    return np.array([source_of[clip] for clip in windows.clip.tolist()])


def _in_turn(views: Sequence[View]) -> View:
    def seen(signals: np.ndarray) -> np.ndarray:
        for view in views:
            signals = view(signals)
        return signals

    return seen


if __name__ == "__main__":
    main()
