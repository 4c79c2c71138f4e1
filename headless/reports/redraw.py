# SPDX-License-Identifier: GPL-3.0-or-later
"""Another choice of sensors in a finished run's summary, report and pictures."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from w2w.core.clip_files import WORK
from w2w.core.files import UNFINISHED, write_json, write_text
from w2w.core.findings.summary import PLACEMENTS, map_content, placement_table, write_map
from w2w.core.ranking.utility import UtilityMap
from w2w.core.results_folder import UTILITY, StudyResults
from w2w.core.study import StudyConfig

from ..runs.folder import HEATMAPS, only_run, picture_files
from ..runs.monitor import RunMonitor
from ..runs.own_files import check, claimed, note
from . import draw, html

LEFT_BEHIND = ("lock", "holder", "running")
"""Parts of the work folder that belong to the process at work: they are not copied."""


@contextmanager
def copied(results: Path, folder: Path) -> Iterator[Path]:
    """A copy of a results folder to work in; it gets its name when the block is done."""
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(
        dir=folder.parent, prefix=f".{folder.name[:40]}.", suffix=UNFINISHED
    ) as temporary:
        copy = Path(temporary) / folder.name
        shutil.copytree(results, copy, ignore=shutil.ignore_patterns(*LEFT_BEHIND, f".*{UNFINISHED}"))
        yield copy
        if folder.exists():
            folder.rmdir()
        copy.replace(folder)


def check_redraw(study: StudyResults) -> None:
    """Refuse a results folder, by a ForeignFileError, in which a foreign file is where a choice is drawn."""
    files = [f"{HEATMAPS}/{file}" for file in picture_files(study.utility.activities)]
    check(study.out, [draw.BLEND, html.REPORT, *files])


def redraw(
    out: Path,
    utility: UtilityMap,
    config: StudyConfig,
    clusters: np.ndarray,
    content: Mapping[str, Any],
    monitor: RunMonitor,
) -> dict[str, str]:
    """Write another choice into a results folder: its tables, report and pictures; what failed, and why.

    `utility` is the ranking under the choice's mean, `clusters` are the groups of patches that say the same,
    and `content` is what `advice_content` makes of the choice. Nothing is touched where a FolderBusyError or
    ForeignFileError is raised.
    """
    study = StudyResults.load(out)
    with only_run(out / WORK):
        again = not np.array_equal(utility.weights, study.utility.weights)
        tables = ["config.json", "summary.json", PLACEMENTS, *([UTILITY, "utility.csv"] if again else [])]
        check_redraw(study)
        placements = study.config().placements
        content = {**content, **map_content(utility, study.patches, placements)}
        with claimed(out, [draw.BLEND]):
            if again:
                write_map(out, utility, study.patches, clusters)
            write_text(out / PLACEMENTS, placement_table(content["cards"], study.patches))
            changes = {"config.json": {"parameters": config.as_dict()}, "summary.json": content}
            for name, change in changes.items():
                before = json.loads((out / name).read_text(encoding="utf-8"))
                write_json(out / name, {**before, **change})
            html.write_report(out)
            failed = draw.draw_folder(out, study.utility.activities, monitor)
        note(out, tables)
    return failed
