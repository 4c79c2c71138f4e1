# SPDX-License-Identifier: GPL-3.0-or-later
"""Every setting on every data set, and what a set gets from a setting that the others chose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from w2w.core.body.body import Body
from w2w.core.files import json_number, write_json, write_text

from ..validation.by_source import merged
from ..validation.protocol import Protocol
from ..validation.site_scores import SiteScores, site_scores
from ..validation.site_windows import SiteWindows
from ..validation.sites import compare_scores
from ..validation.tuning import SETTINGS, Chosen, Result, Setting, leave_one_set_out
from .unpaired import RegionSimulator, Side, load_motions, real_side

PAGE, CONTENT = "left_out.md", "left_out.json"


def try_settings(
    protocol: Protocol,
    path: Path,
    libraries: Sequence[Path],
    seed: int = 0,
    settings: Sequence[Setting] = SETTINGS,
) -> dict[str, Result]:
    """The first analysis of a data set's protocol with one setting after the other.

    Raises ValueError if it cannot be done; the message says why.
    """
    body = Body.bundled()
    simulator = RegionSimulator(body, protocol, seed)
    motions, _ = load_motions(protocol, libraries, body)
    real = real_side(protocol, protocol.read(path), protocol.analyses[0])
    sides: dict[tuple, Side] = {}
    scores: dict[tuple[str, ...], SiteScores] = {}
    results = {}
    for setting in settings:
        changed, analysis = setting.of(protocol, protocol.analyses[0])
        if setting.signals not in sides:
            sides[setting.signals] = simulator.with_sensor(changed.sensor).side(motions, analysis)
        made = simulated_scores(sides[setting.signals], simulator.site_of, protocol, setting, seed)
        names = made.activities
        if names not in scores:
            scores[names] = scores_of(real.windows, names, protocol.worn_site_of, seed)
        results[setting.name] = _result(scores[names], made, tuple(protocol.sites), seed)
    return results


def simulated_scores(
    side: Side, site_of: np.ndarray, protocol: Protocol, setting: Setting, seed: int
) -> SiteScores:
    """Scores of all sources at once, or the mean over sources ranked alone wherever one can be."""
    activities = protocol.analyses[0].activities
    whole = scores_of(side.windows, activities, site_of, seed)
    if not setting.sources_apart:
        return whole
    source = np.array([side.source_of[clip] for clip in side.windows.clip.tolist()])
    parts = []
    for name in np.unique(source):
        try:
            parts.append(scores_of(side.windows.some(source == name), activities, site_of, seed))
        except ValueError:
            continue  # this source alone shows nothing that can be compared
    tested = {name for part in parts for name in part.activities}
    rest = whole.of([name for name in whole.activities if name not in tested])
    return merged([*parts, rest], whole.activities)


def scores_of(
    windows: SiteWindows, activities: Sequence[str], site_of: np.ndarray | None, seed: int
) -> SiteScores:
    """F1 by site of those activities that can be tested, one person left out at a time."""
    found = windows.ranked(activities, by_subject=True, seed=seed)
    return site_scores(found, windows.person_of(), site_of, seed)


def _result(real: SiteScores, made: SiteScores, sites: tuple[str, ...], seed: int) -> Result:
    shared = [name for name in made.activities if name in real.activities]
    found = compare_scores(real.of(shared), made.of(shared), sites, seed)
    return Result(found.mean_rho, found.overall.spearman, found.cells.value, found.regret.lost)


def write_left_out(out: Path, results: Mapping[str, Mapping[str, Result]]) -> str:
    """Write ``left_out.md`` and ``left_out.json``; returns the page.

    Raises ValueError if there are fewer than two sets.
    """
    chosen = leave_one_set_out(results)
    lines = ["# Settings chosen on the other data sets", "", *_chosen(chosen), ""]
    lines += [
        "Chosen is the setting of the highest mean rho by activity over the other sets. Each cell: mean rho "
        "by activity, rho of mean F1, r over cells, regret.",
        "",
        *_all(results),
        "",
    ]
    content = {
        name: {
            "chosen": chosen[name].setting,
            "settings": {
                setting: {score: json_number(value) for score, value in result._asdict().items()}
                for setting, result in of.items()
            },
        }
        for name, of in results.items()
    }
    text = "\n".join(lines)
    write_json(out / CONTENT, content)
    write_text(out / PAGE, text)
    return text


def _chosen(chosen: Mapping[str, Chosen]) -> list[str]:
    lines = [
        "| data set left out | chosen by the others | what it reaches | as fixed | best in hindsight |",
        "|---|---|---|---|---|",
    ]
    for name, one in chosen.items():
        cells = [
            name,
            one.setting,
            _cell(one.result),
            _cell(one.fixed),
            f"{_cell(one.hindsight)} ({one.best})",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def _all(results: Mapping[str, Mapping[str, Result]]) -> list[str]:
    settings = list(next(iter(results.values())))
    lines = [f"| setting | {' | '.join(results)} |", "|---|" + "---|" * len(results)]
    return lines + [
        f"| {setting} | {' | '.join(_cell(of[setting]) for of in results.values())} |" for setting in settings
    ]


def _cell(result: Result) -> str:
    return f"{result.mean_rho:.2f}, {result.rho_of_mean:.2f}, {result.cells:.2f}, {result.regret:.3f}"
