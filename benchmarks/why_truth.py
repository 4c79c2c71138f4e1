# SPDX-License-Identifier: GPL-3.0-or-later
"""Where simulated and worn sensors rank sites differently: one thing is replaced at a time.

    python -m benchmarks.why_truth OUT --utd UTD --mhad acc.npz --umafall umafall.npz --dsads DSADS LIBRARY...

Half of a data set's people judge, as worn. What stands in for the other half goes, step by step, from worn
sensors to simulated ones (`STEPS`); each must rank sites as the judges do. All steps meet the same 400
judges (200 random halvings, both ways), whose spread is the delete-half jackknife's (Shao and Wu 1989), so
the intervals are over people; for simulated steps performers are resampled, too. "Four people alone" are
drawn eight times, trained on one another only and judged by all others: there the range of draws is given.
On UTD-MHAD, whose takes were seen and worn at once, activities are ranked at the wrist, not sites.

Written to OUT: ``why_<set>_<analysis>.csv``, which is not computed again where it stands there already, and
``why.png``. All steps but the last three, their numbers and the analyses were fixed before any was computed;
seen were docs/truth.md and docs/validation.md.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from headless.validation.leave_out import scores_of, simulated_scores
from headless.validation.paired import AS_DEFAULT, POSE_CUTOFF_HZ
from headless.validation.truth import DATA_SETS
from headless.validation.unpaired import Moving, RegionSimulator, Side, load_motions, real_side
from headless.validation.utd import SITES, WINDOW, simulated_trial
from w2w.core.body.body import Body
from w2w.core.csv_tables import csv_text
from w2w.core.datasets.utd_mhad import UTD_IMU_RATE, read_utd_mhad
from w2w.core.files import write_text
from w2w.core.ranking.agreement import spearman_rows
from w2w.core.validation.protocol import Analysis, Protocol
from w2w.core.validation.regret import lost
from w2w.core.validation.site_scores import SiteScores
from w2w.core.validation.site_windows import SiteWindows, site_windows
from w2w.core.validation.sites import mean_rho
from w2w.core.validation.tuning import Setting

from .why_figure import figure
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
    """What stands in for half of the people, and how their judges are seen.

    Attributes
    ----------
    name : str
    side : {"worn", "few", "simulated"}
    view : {"", "band", "posture", "magnitudes", "low magnitudes"}
        What is taken from the signals: what is above the simulated band, each window's mean specific force,
        the directions, or directions and what is above the band.
    made : {"", "ideal", "loose", "tempo", "apart"}
        What is changed in how they are simulated, or scored.
    judged : str
        View of the judges' signals.
    """

    name: str
    side: str
    view: str = ""
    made: str = ""
    judged: str = ""


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


class Row(NamedTuple):
    """How a step's ranking agrees with its judges'; each (value, low, high).

    Attributes
    ----------
    step : str
    f1 : float
        Mean over sites and activities.
    of_mean, by_activity, regret : tuple of 3 floats
    against : tuple of 3 floats
        Rho by activity less that of the first step of its kind: worn by other people, simulated as fixed.
    """

    step: str
    f1: float
    of_mean: tuple[float, float, float]
    by_activity: tuple[float, float, float]
    regret: tuple[float, float, float]
    against: tuple[float, float, float]


NONE = (np.nan,) * 3


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
        _tell(asked["out"], "utd", "wrist", paired_ladder(asked["utd"]))
    for name, analyses in LADDERS.items():
        for analysis in analyses if asked[name] else ():
            if not _table(asked["out"], name, analysis).exists():
                _tell(asked["out"], name, analysis, ladder(name, asked[name], asked["libraries"], analysis))
    figure(asked["out"])


def ladder(name: str, path: Path, libraries: Sequence[Path], analysis_name: str, seed: int = 0) -> list[Row]:
    """All steps on one analysis of a data set."""
    data_set, body = DATA_SETS[name], Body.bundled()
    analysis = next(one for one in data_set.protocol.analyses if one.name == analysis_name)
    rules = tuple(rule for rule in data_set.protocol.rules if rule.source in analysis.sources)
    motions, _ = load_motions(replace(data_set.protocol, rules=rules), libraries, body)
    worn = real_side(data_set.protocol, data_set.read(path), analysis)
    makers = _Made(data_set.protocol, analysis, motions, worn, seed)
    fixed = makers.side("")
    tested = [
        scores_of(side.windows, analysis.activities, of, seed).activities
        for side, of in ((worn, None), (fixed, makers.site_of))
    ]
    names = tuple(activity for activity in tested[0] if activity in tested[1])
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
        agreed = _agreement(judges, stands, step.side == "worn")
        firsts.setdefault(step.side, agreed[1])
        rows.append(_row(step.name, stands, agreed, firsts[step.side]))
        print(rows[-1].step, flush=True)
    return rows


class _Made:
    """Simulated recordings of an analysis, made in one way or another."""

    def __init__(
        self, protocol: Protocol, analysis: Analysis, motions: Sequence[Moving], worn: Side, seed: int
    ) -> None:
        self.protocol, self.analysis, self.seed = protocol, analysis, seed
        self._motions, self._worn = motions, worn
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
        worn, made = (tempo(recordings) for recordings in (self._worn.recordings, self.side("").recordings))
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


Agreed = tuple[tuple[np.ndarray, np.ndarray], ...]
"""rho of mean F1, rho by activity and regret: as they are, and with performers resampled, each (judges,)."""


def _agreement(judges: SiteScores, stands: SiteScores, people: bool) -> Agreed:
    """What stands in for half of the people, by the other half."""
    judged = np.concatenate([judges.halves[0], judges.halves[1]])
    if people:
        seen = np.concatenate([stands.halves[1], stands.halves[0]])
        drawn = seen
    else:
        seen, drawn = np.broadcast_to(stands.f1, judged.shape), stands.samples[: len(judged)]
    return tuple(zip(_three(judged, seen), _three(judged, drawn), strict=True))


def _three(judged: np.ndarray, seen: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    means = [np.nanmean(side, axis=-1) for side in (judged, seen)]
    regret = lost(*(mean[..., None] for mean in means))
    return np.nan_to_num(spearman_rows(*means)), mean_rho(judged, seen), regret


def _row(step: str, stands: SiteScores, agreed: Agreed, first: tuple[np.ndarray, np.ndarray]) -> Row:
    against = tuple(one - other for one, other in zip(agreed[1], first, strict=True))
    return Row(step, float(stands.f1.mean()), *(_estimate(*one) for one in (*agreed, against)))


def _estimate(values: np.ndarray, drawn: np.ndarray) -> tuple[float, float, float]:
    return (float(values.mean()), *(float(one) for one in np.quantile(drawn, [0.025, 0.975])))


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
        found.append([float(value[0]) for value in _three(others.f1[None], stands.f1[None])])
    of = [(float(np.mean(one)), min(one), max(one)) for one in zip(*found, strict=True)]
    print(step.name, flush=True)
    return Row(step.name, float(np.mean(f1)), *of, NONE)


def paired_ladder(path: Path, seed: int = 0) -> list[Row]:
    """UTD-MHAD's wrist: activities ranked by F1, of the same takes worn and simulated."""
    site = "right wrist"
    trials = [trial for trial in read_utd_mhad(path) if trial.recording.sites == (site,)]
    simulator = AS_DEFAULT.simulator({site: SITES[site]}, UTD_IMU_RATE)
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
            Row(step, float(stands.f1.mean()), NONE, _estimate(rho, rho), NONE, _estimate(*[rho - first] * 2))
        )
    return rows


def _table(out: Path, name: str, analysis: str) -> Path:
    return out / f"why_{name}_{analysis.replace(' ', '_')}.csv"


def _tell(out: Path, name: str, analysis: str, rows: Sequence[Row]) -> None:
    """Print a ladder and write its csv."""
    columns = ("of_mean", "by_activity", "regret", "against")
    head = ["step", "f1", *(f"{column}{end}" for column in columns for end in ("", "_low", "_high"))]
    table = [
        [row.step, *(round(value, 3) for value in (row.f1, *(v for c in columns for v in getattr(row, c))))]
        for row in rows
    ]
    write_text(_table(out, name, analysis), csv_text([head, *table]))
    print(f"\n{name}, {analysis}\n| step | F1 | rho of mean F1 | mean rho by activity | regret | against |")
    print("|---" * 6 + "|")
    for row in rows:
        cells = [f"{value:.2f} ({low:.2f} to {high:.2f})" for value, low, high in row[2:]]
        print(f"| {row.step} | {row.f1:.2f} | {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
