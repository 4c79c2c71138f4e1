# SPDX-License-Identifier: GPL-3.0-or-later
"""Write down what a library of several sources says: a page, a table, a picture and plain values."""

from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.csv_tables import csv_text
from w2w.core.files import json_number, write_json, write_text
from w2w.core.ranking.expected import WANTED, clips_needed
from w2w.core.ranking.utility import UtilityMap

from ..validation.library_repeats import MeansAgree
from .library import ENOUGH, LibraryFindings

WRITTEN = PAGE, TABLE, CONTENT, PICTURE = "library.md", "library.csv", "library.json", "library_curve.png"
MOST_TIMES = 20
"""Beyond so many times the clips the formula's answer is no advice."""


def write_library(out: Path, found: LibraryFindings) -> str:
    """Write `library.md`, `library.csv`, `library.json` and, of a learning curve, its picture.

    Returns the page.
    """
    rows = activity_rows(found)
    write_text(out / TABLE, csv_text([list(rows[0]), *([_plain(v) for v in row.values()] for row in rows)]))
    write_json(out / CONTENT, _content(found, rows))
    lines = ["# A library of several sources", "", *_sizes(found), "", *_whole(found), ""]
    lines += [verdict(found), "", *_means(found), "", *_activities(rows), "", *_across(found), *_curve(found)]
    if found.curve:
        from .figures import curve_figure  # matplotlib is slow to import

        curve_figure(out / PICTURE, *curve_values(found))
        lines += [f"![Agreement of halves and F1 against clips an activity]({PICTURE})", ""]
    text = "\n".join(lines)
    write_text(out / PAGE, text)
    return text


def activity_rows(found: LibraryFindings) -> list[dict[str, Any]]:
    """Each ranked activity: its clips, performers and sources, its F1, and how far its map repeats."""
    clips, performers = (found.windows.count(what) for what in ("motion", "performer"))
    rows = []
    for number, name in enumerate(found.within.activities):
        f1, told = found.within.f1[:, number], found.told.get(name)
        rows.append(
            {
                "activity": name,
                "sources": ", ".join(found.within.sources_of(name)),
                "clips": clips[name],
                "performers": performers[name],
                "f1_best_patch": float(f1.max()),
                "f1_mean": float(f1.mean()),
                "rho_of_halves": _mean(found.repeats.by_activity[name]),
                "rho_between_sources": found.between.get(name, np.nan),
                "source_told_f1": np.nan if told is None else float(told.mean.mean()),
                "source_chance": np.nan if told is None else 1 / len(told.activities),
            }
        )
    return rows


def verdict(found: LibraryFindings) -> str:
    """Whether these clips are enough for a map that other performers would show again."""
    rho = _mean(found.repeats.mean)
    if np.isnan(rho):
        return "Performers cannot be halved: how far the map repeats is not known."
    text = (
        f"Maps of disjoint halves of the performers agree at rho {_spread(found.repeats.mean)} for the mean"
    )
    if rho >= WANTED:
        return f"{text}: enough clips and performers to read the map patch by patch."
    times = clips_needed(rho)
    if times > MOST_TIMES:
        return f"{text}: these clips do not show a map that repeats."
    return (
        f"{text}, below {WANTED}: about {times:.1f} times as many clips, of other performers, would make "
        "halves agree so."
    )


def curve_values(found: LibraryFindings) -> tuple[list[int], list[float], list[float], list[float]]:
    """Clips in a half, rho of the mean, mean rho by activity and F1."""
    sizes = list(found.curve)
    points = [found.curve[size] for size in sizes]
    return (
        sizes,
        [_mean(point.mean) for point in points],
        [point.mean_by_activity for point in points],
        [_mean(point.f1) for point in points],
    )


def _sizes(found: LibraryFindings) -> list[str]:
    windows, within = found.windows, found.within
    lines = ["| source | clips | performers | activities compared |", "|---|---|---|---|"]
    for source in np.unique(windows.source).tolist():
        here = windows.source == source
        clips, performers = (len(set(values[here])) for values in (windows.motion, windows.performer))
        compared = len(within.parts[source].activities) if source in within.parts else 0
        why = f" ({within.left_out[source]})" if source in within.left_out else ""
        lines.append(f"| {source} | {clips} | {performers} | {compared}{why} |")
    return [
        *lines,
        "",
        "Clips are distinct motions; where nobody is named, every motion counts as a performer of its own.",
    ]


def _whole(found: LibraryFindings) -> list[str]:
    lines = [
        "| clips compared | activities | F1 of the best patch | mean over patches | F1 that one "
        "half's choice gives the other | rho of halves, mean | by F1 unsmoothed | rho of halves, by "
        "activity |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, ranked, again in (
        ("within each source", found.within, found.repeats),
        ("all sources at once", found.at_once, found.repeats_at_once),
    ):
        mean = ranked.f1.mean(axis=1)
        before = " | ".join(_two(float(cell)) for cell in (mean.max(), mean.mean(), _mean(again.f1)))
        after = f"{_two(_mean(again.raw))} | {_two(again.mean_by_activity)}"
        lines.append(f"| {name} | {len(ranked.activities)} | {before} | {_spread(again.mean)} | {after} |")
    return lines


def _means(found: LibraryFindings) -> list[str]:
    """How far two ways to average all activities repeat, with all sources and less one."""
    again = found.repeats
    lines = ["| sources | rho of halves, mean over activities | mean over sources |", "|---|---|---|"]
    lines.append(f"| all | {_spread(again.mean)} | {_spread(again.of_sources)} |")
    for source, pairs in again.left_out.items():
        lines.append(f"| less {source} | {' | '.join(_spread(rho) for rho in np.array(pairs).T)} |")
    return [*lines, "", "Mean over sources: each source's map is the mean over its own activities."]


def _across(found: LibraryFindings) -> list[str]:
    """Activities that several sources show, where their source was never seen."""
    if found.across is None:
        return ["No two activities are shown by two sources each.", ""]
    unseen, seen, sources = found.across
    lines = [
        f"One source left out at a time, the {len(unseen.activities)} activities that several sources show; "
        f"beside it the same windows, performers left out:",
        "",
        "| activity | motions | F1, source never seen: best patch | mean | F1, performer never seen: best "
        "patch | mean |",
        "|---|---|---|---|---|---|",
    ]
    for name in unseen.activities:
        motions = ", ".join(f"{source} {count}" for source, count in sources[name].items())
        lines.append(
            f"| {name} | {motions} | {_best_and_mean(unseen, name)} | {_best_and_mean(seen, name)} |"
        )
    means = " | ".join(f"{ranked.mean.max():.2f} | {ranked.mean.mean():.2f}" for ranked in (unseen, seen))
    return [*lines, f"| **all** | | {means} |", ""]


def _best_and_mean(ranked: UtilityMap, activity: str) -> str:
    if activity not in ranked.activities:
        return " | "
    f1 = ranked.f1[:, ranked.activities.index(activity)]
    return f"{f1.max():.2f} | {f1.mean():.2f}"


def _activities(rows: list[dict[str, Any]]) -> list[str]:
    lines = [
        "| activity | sources | clips | performers | F1, best patch | mean | rho of halves | rho between "
        "sources | source told, F1 (chance) |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        told = row["source_told_f1"]
        source = "" if np.isnan(told) else f"{told:.2f} ({row['source_chance']:.2f})"
        numbers = ("f1_best_patch", "f1_mean", "rho_of_halves", "rho_between_sources")
        cells = [str(row[name]) for name in ("activity", "sources", "clips", "performers")]
        lines.append(f"| {' | '.join([*cells, *(_two(row[name]) for name in numbers), source])} |")
    return lines


def _curve(found: LibraryFindings) -> list[str]:
    if not found.curve:
        return [f"No learning curve: fewer than two activities have {ENOUGH} clips.", ""]
    lines = [
        f"Of the {len(found.curve_activities)} activities with at least {ENOUGH} clips, two halves of the "
        "performers with so many clips an activity each:",
        "",
        "| clips an activity | rho of halves, mean | by activity | F1 that one half's choice gives the "
        "other |",
        "|---|---|---|---|",
    ]
    for size, *values in zip(*curve_values(found), strict=True):
        lines.append(f"| {size} | {' | '.join(_two(value) for value in values)} |")
    return [*lines, ""]


def _content(found: LibraryFindings, rows: list[dict[str, Any]]) -> dict[str, Any]:
    sizes, mean, by_activity, f1 = curve_values(found)
    return {
        "activities": [{key: _plain(value) for key, value in row.items()} for row in rows],
        "rho_of_halves": _plain(_mean(found.repeats.mean)),
        "rho_of_halves_by_halving": [_plain(float(rho)) for rho in found.repeats.mean],
        "rho_of_halves_by_raw_f1": _plain(_mean(found.repeats.raw)),
        "rho_of_halves_by_activity": _plain(found.repeats.mean_by_activity),
        "rho_of_halves_by_source_means": _plain(_mean(found.repeats.of_sources)),
        "rho_of_halves_by_source_means_by_halving": [_plain(float(r)) for r in found.repeats.of_sources],
        "rho_of_halves_less_a_source": {
            source: {
                name: [_plain(float(rho)) for rho in values]
                for name, values in zip(MeansAgree._fields, zip(*pairs, strict=True), strict=True)
            }
            for source, pairs in found.repeats.left_out.items()
        },
        "source_never_seen": _across_content(found),
        "rho_of_halves_all_at_once": _plain(_mean(found.repeats_at_once.mean)),
        "sentence": verdict(found),
        "curve": [
            dict(
                zip(
                    ("clips", "rho_of_halves", "rho_by_activity", "f1"),
                    (size, *(_plain(v) for v in values)),
                    strict=True,
                )
            )
            for size, *values in zip(sizes, mean, by_activity, f1, strict=True)
        ],
        "left_out": found.within.left_out,
    }


def _across_content(found: LibraryFindings) -> dict[str, Any] | None:
    if found.across is None:
        return None
    unseen, seen, sources = found.across
    return {
        "activities": {
            name: {
                "motions": sources[name],
                "f1_source_never_seen": _plain(float(unseen.f1[:, number].mean())),
            }
            for number, name in enumerate(unseen.activities)
        },
        "macro_f1_source_never_seen": _plain(float(unseen.mean.mean())),
        "macro_f1_performer_never_seen": _plain(float(seen.mean.mean())),
    }


def _mean(values: np.ndarray) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else float("nan")


def _spread(values: np.ndarray) -> str:
    """Mean, and from which to which halving."""
    known = values[np.isfinite(values)]
    return f"{known.mean():.2f} ({known.min():.2f} to {known.max():.2f})" if len(known) else ""


def _two(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}"


def _plain(value: Any) -> Any:
    """Numbers as on file: rounded, and null where not known."""
    return json_number(value) if isinstance(value, float) else value
