# SPDX-License-Identifier: GPL-3.0-or-later
"""A library of several sources under one set of labels, and what it says when compared within them."""

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from w2w.core.csv_tables import csv_text
from w2w.core.files import write_text
from w2w.core.library.library import Clip, Library, LibraryError, read_library, unique_names
from w2w.core.ranking.pooling import Pooling
from w2w.core.ranking.utility import UtilityMap
from w2w.core.study.clip_files import is_used
from w2w.core.study.results import StudyResults
from w2w.core.windows.inputs import as_blocks

from ..validation.across_sources import AcrossSources, across_sources, between_sources
from ..validation.library_names import RULES
from ..validation.library_repeats import Repeats, repeats
from ..validation.protocol import first_rule
from ..validation.source_test import told_sources
from ..validation.within_sources import MixedWindows, SourcedMap, rank_within_sources

LABELS = "labels.csv"
CURVE = (3, 5, 7, 10)
"""Clips of each activity, in each half of the performers, of the learning curve."""

ENOUGH = 2 * CURVE[-1]
"""Clips from which on an activity takes part in the curve, so that all its points are of the same ones."""


def labelled_by_name(libraries: Sequence[Path]) -> Library:
    """The clips of several folders that `library_names` knows, under its labels.

    Raises LibraryError if a folder holds no motion, or no clip's name is known.
    """
    titles = _titles(libraries)
    clips, files, skipped = [], [], []
    for folder, title in zip(libraries, titles, strict=True):
        found = read_library(folder, own_labels=False)
        for clip in found.clips:
            file = f"{title}/{clip.file}" if title else clip.file
            rule, who = first_rule(RULES, file)
            if rule is None:
                skipped.append((file, "no known library calls a clip so (docs/studies.md)"))
                continue
            subject = f"{rule.source} {who}" if who else ""
            clips.append(Clip(clip.path, file, "", rule.activity, subject, "", rule.source))
            files.append(file)
    if not clips:
        raise LibraryError(
            f"no file in {', '.join(map(str, libraries))} has a name that a known library gives its clips: "
            "give --labels with columns file, activity, source"
        )
    named = [replace(clip, name=name) for clip, name in zip(clips, unique_names(files), strict=True)]
    return Library(libraries[0], tuple(named), "the names that known libraries give", tuple(skipped))


def with_enough(library: Library, fewest: int) -> Library:
    """The library less the activities that fewer clips show.

    Raises LibraryError if fewer than two activities are left.
    """
    counts = library.activities
    kept = tuple(clip for clip in library.clips if counts[clip.activity] >= fewest)
    if len({clip.activity for clip in kept}) < 2:
        most = max(counts, key=lambda name: counts[name])
        raise LibraryError(
            f"fewer than two activities have {fewest} clips ({most}: {counts[most]}): lower --fewest"
        )
    few = [
        (clip.file, f"fewer than {fewest} clips show {clip.activity} (--fewest)")
        for clip in library.clips
        if counts[clip.activity] < fewest
    ]
    return replace(library, clips=kept, skipped=(*library.skipped, *few))


def _titles(libraries: Sequence[Path]) -> list[str]:
    """What the paths of each folder's clips begin with: its name, with a number where two share one."""
    if len(libraries) == 1:
        return [""]
    names = [folder.resolve().name for folder in libraries]
    again = Counter(names)
    return [
        name if again[name] == 1 else f"{name}-{names[:number].count(name) + 1}"
        for number, name in enumerate(names)
    ]


def write_labels(path: Path, library: Library) -> None:
    """Write the labels as a csv that `--labels` reads."""
    rows = [["file", "activity", "subject", "source"]]
    rows += [[clip.file, clip.activity, clip.subject, clip.source] for clip in library.clips]
    write_text(path, csv_text(rows))


def mixed_windows(study: StudyResults) -> MixedWindows:
    """The windows of a finished run with where they are from.

    Raises ValueError if the run's labels name no sources.
    """
    used = [entry for entry in study.entries if is_used(entry)]
    if not all(entry.get("source") for entry in used):
        raise ValueError("every clip needs its source: give --labels a column 'source'")
    labels = study.labels()
    counts = [len(found.is_test) for found in study.windows]
    source = np.repeat([entry["source"] for entry in used], counts)
    who = np.where(labels.subject == "", labels.motion, labels.subject)
    performer = np.char.add(np.char.add(source, " "), who)
    inputs = as_blocks(study.inputs("ridge"))
    return MixedWindows(inputs, labels.activity, labels.motion, source, performer, labels.is_test)


@dataclass(frozen=True, eq=False)
class LibraryFindings:
    """What a library of several sources says."""

    windows: MixedWindows
    within: SourcedMap
    at_once: SourcedMap
    """Compared within sources, and all sources at once."""
    repeats: Repeats
    repeats_at_once: Repeats
    curve: dict[int, Repeats]  # by clips of each activity in a half, of the activities with enough
    curve_activities: tuple[str, ...]
    between: dict[str, float]  # rho of an activity's maps in different sources
    told: dict[str, UtilityMap]  # how well sources are told within an activity
    across: AcrossSources | None  # one source left out at a time; None if no two activities allow it


def study_library(
    study: StudyResults, halvings: int = 4, step: Callable[[str], AbstractContextManager] = nullcontext
) -> LibraryFindings:
    """Rank a finished run's clips within their sources, and see how far that repeats.

    `halvings`: of the performers.
    `step`: given what is done next; a context while it lasts.
    Raises ValueError if sources are not named, or nothing can be compared; the message says why.
    """
    windows, seed = mixed_windows(study), study.config().seed
    as_one = windows.as_one_source()
    pooling = Pooling.on(study.body(), study.patches)
    with step("ranking within sources"):
        within = rank_within_sources(windows, pooling, seed)
        at_once = rank_within_sources(as_one, pooling, seed)
    with step("comparing halves of the performers"):
        whole, whole_at_once = (repeats(one, pooling, halvings, seed=seed) for one in (windows, as_one))
    counts = windows.count("motion")
    many = tuple(name for name in within.activities if counts[name] >= ENOUGH)
    enough = windows.some(np.isin(windows.activity, many))
    sizes = CURVE if len(many) > 1 else ()
    with step("drawing the learning curve"):
        curve = {clips: repeats(enough, pooling, halvings, clips, seed) for clips in sizes}
    labels = (windows.activity, windows.source, windows.performer, windows.is_test)
    with step("telling the sources apart"):
        told = told_sources(windows.inputs, *labels, seed)
        across = _across(windows, seed)
    between = between_sources(within)
    return LibraryFindings(windows, within, at_once, whole, whole_at_once, curve, many, between, told, across)


def _across(windows: MixedWindows, seed: int) -> AcrossSources | None:
    """One source left out at a time; None if no two activities are shown by two sources."""
    try:
        return across_sources(windows, seed)
    except ValueError:
        return None
