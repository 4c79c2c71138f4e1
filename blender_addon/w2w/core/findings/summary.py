# SPDX-License-Identifier: GPL-3.0-or-later
"""A finished study as plain values in files: summary, table, configuration."""

import platform
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from ..body.body import PACKAGE
from ..csv_tables import apart, csv_text
from ..files import DIGITS, file_sha256, write_json, write_text
from ..imu.cover import cover_content, cover_sentence
from ..library.library import Library, not_read_sentence
from ..patches.patches import PatchSet
from ..ranking.costs import cost_of, costs_at, is_as_good
from ..ranking.utility import UtilityMap
from ..study.clip_files import CLIP_LIST, WORK, Entry, write_clip_list
from ..study.results import UTILITY, ClipResult, Study, StudyResults
from ..windows.windows import WindowSpec
from ..wording import plain_words
from .advice_content import advice_content, cost_content, interval_content, patch_content, rounded, with_needs
from .cautions import cautions
from .notes import few_clips, label_content

PLACEMENTS = "placements.csv"
"""Where the recommended sensors go."""

BEFORE_ACTIVITIES = ("patch", "region", "vertex")
EXPECTED = ("expected_mean", "expected_low", "expected_high")
AFTER_ACTIVITIES = ("mean", "mean_low", "mean_high", *EXPECTED, "rank_low", "rank_high", "cluster")

MOST_REGIONS = 10
"""Regions listed."""

LIBRARIES = ("numpy", "scipy", "scikit-learn", "bpy")
"""Libraries whose version can change results."""


def write_results(study: Study) -> None:
    """Write the list of clips, placements, ranking and `summary.json` into the study's folder."""
    out = study.results.out
    write_clip_list(out, _listed(study))
    content = summary(study)
    content["cards"] = with_needs(content["cards"], study.needs)
    write_placements(out, content["cards"], study.results.patches)
    write_map(out, study.results.utility, study.results.patches, study.advice.clusters)
    write_json(out / "summary.json", content | ({"pilot": study.pilot} if study.pilot else {}))


def write_placements(out: Path, cards: Sequence[dict[str, Any]], patches: PatchSet) -> None:
    """Write where each recommended sensor goes; `w2w run --placements` reads it."""
    columns = ("spot", "words", "arrow", "slip_cm", "turn_deg", "needs", "patch")
    rows: list[Sequence[object]] = [("name", *columns, "vertex")]
    for card in cards:
        needs = card.get("needs", {}).get("sentence", "")
        cells = card | {"slip_cm": f"{card['slip_cm']:.0f}", "needs": needs}
        rows.append((card["sensor"], *map(cells.get, columns), int(patches.vertices[card["patch"]])))
    write_text(out / PLACEMENTS, csv_text(rows))


def write_map(out: Path, utility: UtilityMap, patches: PatchSet, clusters: np.ndarray) -> None:
    """Write the ranking, for programs and as a table."""
    utility.save(out / UTILITY)
    write_text(out / "utility.csv", patch_table(utility, patches, clusters))


def write_failure(out: Path, library: Library, problem: str, clips: Sequence[ClipResult]) -> None:
    """Write a `summary.json` with what was wrong, and the list of clips with the reason each was skipped."""
    skipped = _skipped(clips, library)
    used = [_entry(result) for result in clips if result.used]
    write_clip_list(out, [*used, *skipped, *_not_read(library)])
    found = len(library.clips) + len(library.skipped)
    content = {
        "problem": problem,
        "clips": {"found": found, "used": len(used), "skipped": len(skipped)},
        "labelled_by": library.labelled_by,
        "labels": label_content(library.check),
    }
    write_json(out / "summary.json", content)


def _skipped(results: Sequence[ClipResult], library: Library) -> list[Entry]:
    """The files that were not used, with the reasons."""
    left_out = [{"file": file, "skipped": reason} for file, reason in library.skipped]
    return left_out + [
        {"file": result.clip.file, "skipped": result.reason, "sha256": result.source_sha256}
        for result in results
        if not result.used
    ]


def _not_read(library: Library) -> list[Entry]:
    """An entry for each kind of files that are not read, with how many there are and what to do."""
    return [
        {"file": f"*{suffix}", "skipped": not_read_sentence([(suffix, number)]), "files": number}
        for suffix, number in library.unread
    ]


def patch_table(utility: UtilityMap, patches: PatchSet, clusters: np.ndarray) -> str:
    """A csv table of every patch's F1: patch, region, vertex, each activity, mean, rank, and their intervals.

    Patches of one `cluster` predict nearly the same.
    """
    others = (*BEFORE_ACTIVITIES, *AFTER_ACTIVITIES)
    rows: list[list[object]] = [[*BEFORE_ACTIVITIES, *apart(utility.activities, others), *AFTER_ACTIVITIES]]
    for patch, region in enumerate(patches.regions):
        means = (utility.mean, utility.mean_low, utility.mean_high)
        scores = [*utility.f1[patch], *(values[patch] for values in (*means, *utility.expected))]
        cells = [f"{score:.{DIGITS}f}" for score in scores]
        ranks = utility.rank_low[patch], utility.rank_high[patch]
        rows.append([patch, region, patches.vertices[patch], *cells, *ranks, clusters[patch]])
    return csv_text(rows)


def summary(study: Study) -> dict[str, Any]:
    """All findings of the study, for people and programs."""
    utility, patches = study.results.utility, study.results.patches
    covers = {} if study.config.on_skin else cover_content(study.results.out, patches)
    on_cloth = cover_sentence(covers, len(patches))
    used, place = map(_entry, study.used), study.advice.answer.patch
    found = cautions(utility, study.results.clips, used, study.config, on_cloth, place)
    return {
        "clips": study_counts(study),
        "labelled_by": study.library.labelled_by,
        "files_of_kinds_not_read": dict(study.library.unread),
        "labels": label_content(study.library.check),
        "cautions": [caution._asdict() for caution in found],
        "windows": window_content(study.clips, study.config.windows),
        "ranked_activities": list(utility.activities),
        "activities": _activities(study),
        "left_out": utility.left_out,
        "protocol": utility.protocol,
        "classifier": utility.classifier,
        "sensor": study.config.sensor,
        **covers,
        **advice_content(study.advice, study.results.utility, patches, found),
        **map_content(study.results, study.config.placements, study.advice.answer.base.under),
    }


def config_content(study: Study) -> dict[str, Any]:
    """Every parameter, the versions and the hash of the list of clips, which has the hash of each."""
    return {
        "parameters": study.config.as_dict(),
        "body": {"name": study.body.name, "sha256": file_sha256(study.results.out / WORK / "body.npz")},
        "versions": versions(),
        "labelled_by": study.library.labelled_by,
        "clips": {"file": CLIP_LIST, "sha256": file_sha256(study.results.out / CLIP_LIST)},
    }


def versions() -> dict[str, str]:
    """Version of W2W, of Python, of Blender and of each library that results depend on."""
    try:
        manifest = (PACKAGE.parents[1] / "blender_manifest.toml").read_text(encoding="utf-8")
        own = tomllib.loads(manifest)["version"]
    except OSError:
        own = _installed("where-to-wear")
    known = {"w2w": own, "python": platform.python_version()}
    known |= {name: version for name in LIBRARIES if (version := _installed(name))}
    if "bpy" not in known and "bpy" in sys.modules:  # the Blender program
        known["bpy"] = sys.modules["bpy"].app.version_string
    return known


@cache
def _installed(name: str) -> str:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return ""


def window_content(results: Sequence[ClipResult], spec: WindowSpec) -> dict[str, Any]:
    """The window, the used clips that are shorter, and how long the median one is."""
    durations = np.array([result.details["duration_s"] for result in results if result.used])
    median = float(np.median(durations)) if len(durations) else 0.0
    return {
        "length_s": spec.length_s,
        "stride_s": spec.stride_s,
        "clips_shorter": int((durations < spec.length_s).sum()),
        "median_clip_s": round(median, 2),
    }


def study_counts(study: Study) -> dict[str, int]:
    """Number of motion files found, and of clips used, ranked (in the map) and skipped."""
    found, used = len(study.clips) + len(study.library.skipped), len(study.used)
    ranked = sum(result.clip.activity in study.results.utility.activities for result in study.used)
    return {"found": found, "used": used, "ranked": ranked, "skipped": found - used}


def _activities(study: Study) -> dict[str, dict[str, Any]]:
    clips = Counter(result.clip.activity for result in study.used)
    windows: Counter[str] = Counter()
    motions: dict[str, set[str]] = {}
    for result, ranked in zip(study.used, study.results.clips, strict=True):
        windows[result.clip.activity] += result.details["windows"]
        motions.setdefault(result.clip.activity, set()).add(ranked.motion_key)
    return {
        name: {
            "clips": clips[name],
            "distinct_motions": len(motions[name]),
            "windows": windows[name],
            "ranked": name in study.results.utility.activities,
            "interval_caution": few_clips(len(motions[name])),
        }
        for name in sorted(clips)
    }


def map_content(
    results: StudyResults, placements: Iterable[tuple[str, Any]], base: Sequence[int]
) -> dict[str, Any]:
    """Scores of the user's placements and of regions; costs are against a sensor on the patches `base`."""
    utility, patches = results.utility, results.patches
    return {
        "own_placements": own_scores([name for name, _ in placements], utility, patches, base),
        "regions": _regions(utility, patches, base),
    }


def own_scores(
    names: Sequence[str], utility: UtilityMap, patches: PatchSet, base: Sequence[int]
) -> list[dict[str, Any]]:
    """Scores of the user's placements, by their names among the patches.

    `rank` is one more than the number of sampled patches with a higher expected F1. The costs are against a
    sensor that moves over the patches `base`.
    """
    known = [name.lower() for name in patches.names]
    own = [known.index(plain_words(name)) for name in names]
    sampled = np.setdiff1d(np.arange(len(patches)), own)
    expected = utility.expected_mean
    return [
        {
            **patch_content(patch, utility, patches),
            "rank": int((expected[sampled] > expected[patch]).sum()) + 1,
            "of": len(sampled) + 1,
            **cost_content(cost_of(utility, base, [patch])),
        }
        for patch in own
    ]


def best_regions(
    utility: UtilityMap, patches: PatchSet, base: Sequence[int], allowed: np.ndarray
) -> list[dict[str, Any]]:
    """The best allowed patch (N,) of each region by expected F1, with its scores, best region first.

    The costs are against a sensor that moves over the patches `base`.
    """
    as_good = is_as_good(costs_at(utility, base))
    return [
        {
            "patch": patch,
            "name": patches.names[patch],
            "expected": float(utility.expected_mean[patch]),
            "low": float(utility.expected_low[patch]),
            "high": float(utility.expected_high[patch]),
            "as_good": bool(as_good[patch]),
            "f1": float(utility.mean[patch]),
            "f1_low": float(utility.mean_low[patch]),
            "f1_high": float(utility.mean_high[patch]),
        }
        for patch in patches.best_of_regions(utility.expected_mean, allowed)[:MOST_REGIONS]
    ]


def _regions(utility: UtilityMap, patches: PatchSet, base: Sequence[int]) -> dict[str, dict[str, Any]]:
    """The number and scores of the patches of each named region, the best expected first."""
    regions = np.array(patches.regions)
    content, as_good = {}, is_as_good(costs_at(utility, base))
    for best in patches.best_of_regions(utility.expected_mean):
        here = regions == regions[best]
        content[patches.regions[best]] = {
            "patches": int(here.sum()),
            "as_good": int(as_good[here].sum()),
            "best_patch": best,
            **interval_content("best_expected_f1", *utility.expected.at(best)),
            "average_expected_f1": rounded(utility.expected_mean[here].mean()),
            "best_mean_f1": rounded(utility.mean[here].max()),
            "average_mean_f1": rounded(utility.mean[here].mean()),
        }
    return content


def _listed(study: Study) -> Iterator[Entry]:
    """Entries of the used clips, with the earlier clip of the same motion, then those of the skipped."""
    copies = dict(study.copies)
    for result in study.used:
        same = {"same_motion_as": copies[result.clip.file]} if result.clip.file in copies else {}
        yield _entry(result) | same
    yield from _skipped(study.clips, study.library)
    yield from _not_read(study.library)


def _entry(result: ClipResult) -> Entry:
    """The entry of a used clip."""
    clip = result.clip
    labels = {"file": clip.file, "clip": clip.name, "activity": clip.activity, "subject": clip.subject}
    source = {"source": clip.source} if clip.source else {}
    return {**labels, **source, **result.details, "sha256": result.source_sha256}
