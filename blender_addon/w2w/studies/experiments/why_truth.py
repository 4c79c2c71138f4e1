# SPDX-License-Identifier: GPL-3.0-or-later
r"""Where simulated and worn sensors rank sites differently: one thing is replaced at a time.

    python -m w2w.studies.experiments.why_truth OUT --utd UTD --mhad acc.npz --umafall umafall.npz \
        --dsads DSADS LIBRARY...

Half of a data set's people judge, as worn. What stands in for the other half goes, step by step, from worn
sensors to simulated ones (`STEPS`); each must rank sites as the judges do. All steps meet the same 400
judges (200 random halvings, both ways), whose spread is the delete-half jackknife's (Shao and Wu 1989), so
the intervals are over people; for simulated steps performers are resampled, too. "Four people alone" are
drawn eight times, trained on one another only and judged by all others: there the range of draws is given.
On UTD-MHAD, whose takes were seen and worn at once, activities are ranked at the wrist, not sites.

Written to OUT: ``why_<set>_<analysis>.csv``, which is not computed again where it stands there already, and
``why.png``. All steps but the last three, their numbers and the analyses were fixed before any was computed;
seen were docs/evidence.md and docs/validation.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from w2w.core.body.body import Body
from w2w.core.ranking.agreement import spearman_rows

from ..comparisons.leave_out import scores_of, simulated_scores
from ..comparisons.site_simulator import SiteSimulator
from ..comparisons.truth import DATA_SETS
from ..comparisons.unpaired import Moving, RegionSimulator, Side, load_motions, real_side
from ..comparisons.utd import POSE_CUTOFF_HZ, SITES, WINDOW, simulated_trial
from ..datasets.utd_mhad import UTD_IMU_RATE, read_utd_mhad
from ..validation.protocol import Analysis, Protocol
from ..validation.site_scores import SiteScores
from ..validation.site_windows import SiteWindows, site_windows
from ..validation.tuning import Setting
from .why_figure import figure
from .why_rows import NONE, Row, agreement, estimate, row_of, tell, three
from .why_views import VIEWS, below, tempo

LADDERS = {"mhad": ("all actions", "Kinect"), "umafall": ("all activities",), "dsads": ("all activities",)}
"""Analyses of each protocol."""

LOOSE = Setting("worn loosely", tissue=(6.0, 0.3, 0.8))
LOOSE_TURN_DEG = 15.0
"""How far each clip's sensors sit turned at random, beside LOOSE's soft tissue."""

MOST_FASTER = 2.0
"""An activity is played at most so many times as fast, or slow."""

FEW_PEOPLE, FEW_DRAWS = 4, 8


class Step(NamedTuple):
    """What stands in for half of the people, and how their judges are seen."""

    name: str
    side: str  # "worn" or "few" or "simulated"
    view: str = ""
    """"" or "band" or "posture" or "magnitudes" or "low magnitudes": what is taken from the signals: what is
    above the simulated band, each window's mean specific force, the directions, or directions and what is
    above the band."""
    made: str = ""
    """"" or "ideal" or "loose" or "tempo" or "apart": what is changed in how they are simulated, or
    scored."""
    judged: str = ""  # view of the judges' signals


STEPS = (
    Step("worn by other people", "worn"),
    Step("worn, in the simulated band", "worn", "band"),
    Step("worn, without posture", "worn", "posture"),
    Step("worn, magnitudes alone", "worn", "magnitudes"),
    Step("worn by four people alone", "few"),
    Step("worn by four people, in the simulated band", "few", "band"),
    Step("simulated, as fixed", "simulated"),
    Step("simulated, without sensor errors", "simulated", made="ideal"),
    Step("simulated, worn loosely", "simulated", made="loose"),
    Step("simulated, at people's tempo", "simulated", made="tempo"),
    Step("simulated, sources apart", "simulated", made="apart"),
    Step("simulated, without posture", "simulated", "posture"),
    Step("simulated, magnitudes alone", "simulated", "magnitudes"),
    Step("judges without posture: worn", "worn", "posture", judged="posture"),
    Step("judges without posture: simulated", "simulated", "posture", judged="posture"),
    Step("judges by magnitudes: worn", "worn", "magnitudes", judged="magnitudes"),
    Step("judges by magnitudes: simulated", "simulated", "magnitudes", judged="magnitudes"),
    Step("judges in the simulated band: worn", "worn", "band", judged="band"),
    Step("judges in the simulated band: simulated", "simulated", judged="band"),
    # the last three were added after the others had been read
    Step("worn, magnitudes in the simulated band", "worn", "low magnitudes"),
    Step("judges by magnitudes in that band: worn", "worn", "low magnitudes", judged="low magnitudes"),
    Step("judges by magnitudes in that band: simulated", "simulated", "magnitudes", judged="low magnitudes"),
)


def main() -> None:
    """Climb every ladder there is data for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("libraries", type=Path, nargs="*")
    for name in ("utd", *LADDERS):
        parser.add_argument(f"--{name}", type=Path)
    asked = vars(parser.parse_args())
    asked["out"].mkdir(parents=True, exist_ok=True)
    if asked["utd"]:
        tell(_table(asked["out"], "utd", "wrist"), "utd, wrist", paired_ladder(asked["utd"]))
    for name, analyses in LADDERS.items():
        for analysis in analyses if asked[name] else ():
            table = _table(asked["out"], name, analysis)
            if not table.exists():
                rows = ladder(name, asked[name], asked["libraries"], analysis)
                tell(table, f"{name}, {analysis}", rows)
    figure(asked["out"])


def ladder(name: str, path: Path, libraries: Sequence[Path], analysis_name: str, seed: int = 0) -> list[Row]:
    """All steps on one analysis of a data set."""
    makers, names = both_sides(name, path, libraries, analysis_name, seed)
    worn, analysis = makers.worn, makers.analysis
    known: dict[tuple, SiteScores] = {}

    def scored(side: str, view: str = "", made: str = "") -> SiteScores:
        key = side, view, made
        if key not in known and side == "worn":
            known[key] = scores_of(_seen(worn, makers.protocol, view, analysis), names, None, seed)
        elif key not in known:
            known[key] = makers.scores(made, view, names)
        return known[key]

    rows, firsts = [], {}
    for step in STEPS:
        if step.side == "few":
            rows.append(_few(step, worn, makers.protocol, analysis, names, seed))
            continue
        judges, stands = scored("worn", step.judged), scored(step.side, step.view, step.made)
        agreed = agreement(judges, stands, step.side == "worn")
        firsts.setdefault(step.side, agreed[1])
        rows.append(row_of(step.name, stands, agreed, firsts[step.side]))
        print(rows[-1].step, flush=True)
    return rows


def both_sides(
    name: str, path: Path, libraries: Sequence[Path], analysis_name: str, seed: int = 0
) -> tuple[Made, tuple[str, ...]]:
    """What makes the simulated side of an analysis, and the activities that both sides can test."""
    protocol, body = DATA_SETS[name], Body.bundled()
    analysis = next(one for one in protocol.analyses if one.name == analysis_name)
    rules = tuple(rule for rule in protocol.rules if rule.source in analysis.sources)
    motions, _ = load_motions(replace(protocol, rules=rules), libraries, body)
    worn = real_side(protocol, protocol.read(path), analysis)
    makers = Made(protocol, analysis, motions, worn, seed)
    print(f"{name}, {analysis_name}: {len({one.motion.clip for one in motions})} clips", flush=True)
    tested = [
        scores_of(side.windows, analysis.activities, of, seed).activities
        for side, of in ((worn, None), (makers.side(""), makers.site_of))
    ]
    return makers, tuple(activity for activity in tested[0] if activity in tested[1])


class Made:
    """Simulated recordings of an analysis, made in one way or another."""

    def __init__(
        self, protocol: Protocol, analysis: Analysis, motions: Sequence[Moving], worn: Side, seed: int
    ) -> None:
        self.protocol, self.analysis, self.seed = protocol, analysis, seed
        self._motions, self.worn = motions, worn
        self._sides: dict[str, Side] = {}
        self.site_of = RegionSimulator(Body.bundled(), protocol, seed).site_of

    def side(self, made: str) -> Side:
        """The recordings; those that are only scored in another way are the same."""
        made = "" if made == "apart" else made
        if made not in self._sides:
            protocol, motions = self.protocol, self._motions
            if made == "ideal":
                protocol, _ = Setting(made, noise=False).of(protocol, self.analysis)
            if made == "loose":
                protocol, _ = LOOSE.of(protocol, self.analysis)
                sensor = replace(protocol.sensor, mounting_turn_deg=LOOSE_TURN_DEG)
                protocol = replace(protocol, sensor=sensor)
            if made == "tempo":
                faster = self._faster()
                motions = [_played(one, faster.get(one.motion.activity, 1.0)) for one in motions]
            self._sides[made] = RegionSimulator(Body.bundled(), protocol, self.seed).side(
                motions, self.analysis
            )
        return self._sides[made]

    def _faster(self) -> dict[str, float]:
        """How many times as fast as the library's people the worn sensors' people do an activity."""
        worn, made = (tempo(recordings) for recordings in (self.worn.recordings, self.side("").recordings))
        return {
            name: float(np.clip(worn[name] / made[name], 1 / MOST_FASTER, MOST_FASTER))
            for name in set(worn) & set(made)
        }

    def scores(self, made: str, view: str, names: Sequence[str]) -> SiteScores:
        """F1 of some activities by site."""
        side = self.side(made)
        seen = side._replace(windows=_seen(side, self.protocol, view, self.analysis))
        protocol = replace(self.protocol, analyses=(self.analysis._replace(activities=tuple(names)),))
        setting = Setting(made, sources_apart=made == "apart")
        return simulated_scores(seen, self.site_of, protocol, setting, self.seed)


def _played(moving: Moving, faster: float) -> Moving:
    return moving._replace(motion=replace(moving.motion, rate=moving.motion.rate * faster))


def _seen(side: Side, protocol: Protocol, view: str, analysis: Analysis) -> SiteWindows:
    recordings = side.recordings
    if view in ("band", "low magnitudes"):
        recordings = [below(recording, analysis.cutoff_hz) for recording in recordings]
    return site_windows(recordings, protocol.windows, protocol.use, view=VIEWS[view])


def _few(
    step: Step, worn: Side, protocol: Protocol, analysis: Analysis, names: Sequence[str], seed: int
) -> Row:
    """Four people alone, by all others as worn."""
    rng = np.random.default_rng(seed)
    judged, seen = (_seen(worn, protocol, view, analysis) for view in (step.judged, step.view))
    people, f1, found = np.unique(judged.subject), [], []
    for _ in range(FEW_DRAWS):
        few = np.isin(judged.subject, rng.choice(people, FEW_PEOPLE, replace=False))
        parts = judged.some(~few), seen.some(few)
        sides = [scores_of(part, names, None, seed) for part in parts]
        shared = [name for name in names if all(name in side.activities for side in sides)]
        others, stands = (side.of(shared) for side in sides)
        f1.append(stands.f1.mean())
        found.append([float(value[0]) for value in three(others.f1[None], stands.f1[None])])
    of = [(float(np.mean(one)), min(one), max(one)) for one in zip(*found, strict=True)]
    print(step.name, flush=True)
    return Row(step.name, float(np.mean(f1)), *of, NONE)


def paired_ladder(path: Path, seed: int = 0) -> list[Row]:
    """UTD-MHAD's wrist: activities ranked by F1, of the same takes worn and simulated."""
    site = "right wrist"
    trials = [trial for trial in read_utd_mhad(path) if trial.recording.sites == (site,)]
    simulator = SiteSimulator({site: SITES[site]}, UTD_IMU_RATE)
    worn = [trial.recording for trial in trials]
    made = [simulated_trial(trial, simulator, POSE_CUTOFF_HZ) for trial in trials]
    names = tuple(dict.fromkeys(recording.activity for recording in worn))
    band = [below(recording, POSE_CUTOFF_HZ) for recording in worn]
    whole, low, simulated = (
        scores_of(site_windows(side, WINDOW), names, None, seed) for side in (worn, band, made)
    )
    judges = whole.halves.reshape(-1, len(names))
    rows, first = [], None
    for step, stands, others in (
        ("worn by other people", whole, True),
        ("worn by other people, below 3 Hz", low, True),
        ("worn by the judges, below 3 Hz", low, False),
        ("simulated from the judges' own takes", simulated, False),
        ("simulated from other people's takes", simulated, True),
    ):
        halves = stands.halves[::-1] if others else stands.halves
        rho = np.nan_to_num(spearman_rows(judges, halves.reshape(-1, len(names))))
        first = rho if first is None else first
        rows.append(
            Row(step, float(stands.f1.mean()), NONE, estimate(rho, rho), NONE, estimate(*[rho - first] * 2))
        )
    return rows


def _table(out: Path, name: str, analysis: str) -> Path:
    return out / f"why_{name}_{analysis.replace(' ', '_')}.csv"


if __name__ == "__main__":
    main()
