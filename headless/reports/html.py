# SPDX-License-Identifier: GPL-3.0-or-later
"""`w2w report`: a finished study as one page that opens in any browser, without a network."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup
from rich.console import Console

from w2w.core.body.body import Body
from w2w.core.files import write_text
from w2w.core.findings.counts import (
    clip_counts,
    counts_sentence,
    few_clips,
    interval_caution,
    left_out_sentences,
)
from w2w.core.findings.label_notes import copies_sentence
from w2w.core.findings.summary import best_regions
from w2w.core.garments.caught import caught_sentences
from w2w.core.garments.cover import garment_sentence
from w2w.core.imu.wearing import wearing_sentences
from w2w.core.ranking.utility import UtilityMap
from w2w.core.results_folder import StudyResults
from w2w.core.selection import headline
from w2w.core.wording import capital

from ..console import USAGE, ending
from ..options import window_warning
from ..runs.own_files import claimed
from .report_data import as_script_json, title, view_data
from .still_picture import still_picture

REPORT = "report.html"

PAGE = Path(__file__).resolve().parent / "report_page"

SCRIPTS = ("viewer.js", "page.js")

PRODUCTS = 3
"""Products in the first screen, numbered on the body."""

MAX_CONFUSED = 12
"""Activities up to which a table of mistakes can be read."""


def report(
    results: Annotated[Path, typer.Argument(metavar="RESULTS", help="Results folder of a finished run.")],
    project: Annotated[
        str | None, typer.Option("--title", help="Project name on the page.  [default: the run's]")
    ] = None,
) -> None:
    """Write `report.html` into a finished results folder: the heatmaps in 3D, the choice, the tables.

    The page is one file and needs no network. `w2w run` writes it by itself.

    Exit codes: 0 written, 2 the folder holds no finished run.
    """
    console = Console(highlight=False)
    with ending(USAGE, console):
        path = write_report(results, project)
    console.print(f"Report: {path}")


def write_report(out: Path, project: str | None = None) -> Path:
    """Write a finished study's `report.html` into its folder, under the run's title or another.

    A ValueError says that the folder holds no finished run, or a foreign `report.html`.
    """
    study = StudyResults.load(out)
    summary, config = (
        json.loads((out / name).read_text(encoding="utf-8")) for name in ("summary.json", "config.json")
    )
    project = config["parameters"].get("title", "") if project is None else project.strip()
    with claimed(out, [REPORT]):
        write_text(out / REPORT, page(study, study.body(), summary, config, project))
    return out / REPORT


def page(
    study: StudyResults, body: Body, summary: dict[str, Any], config: dict[str, Any], project: str = ""
) -> str:
    """The page's HTML, from a study and what its `summary.json` and `config.json` hold."""
    if "cards" not in summary:
        raise ValueError(f"{study.out} is from an earlier W2W: run `w2w place {study.out} --redraw` first")
    utility, answer = study.utility, summary["answer"]
    best, patch = summary["best_single_patch"]["patch"], answer["patch"]
    worn = summary.get("worn_together")
    for sensor in worn["places"] if worn else ():
        sensor["called"] = sensor["product"] or sensor["name"]
    together = [sensor["patch"] for sensor in worn["places"]] if worn else []
    shown = [product["patch"] for product in answer["products"][:PRODUCTS]] or [patch]
    environment = Environment(loader=FileSystemLoader(PAGE), autoescape=True, undefined=StrictUndefined)
    environment.filters |= {"f1": "{:.2f}".format, "title": title, "capital": capital}
    clips = clip_counts(summary["clips"]["found"], [clip.activity for clip in study.clips], utility)
    return environment.get_template("page.html").render(
        project=project,
        summary=summary,
        config=config,
        clips=clips,
        counts=counts_sentence(clips, utility),
        caution=interval_caution(utility),
        mean_caution=headline.mean_caution(utility),
        can_rank=utility.can_rank,
        spot_caution=headline.spot_caution(best, utility),
        answer=answer,
        products=answer["products"],
        cards=summary["cards"],
        still=still_picture(study, body, shown, together),
        repeats=headline.confidence_sentence(utility, best),
        notes=_notes(summary, len(study.patches)),
        left_out=left_out_sentences(utility.left_out),
        worn=worn,
        body=body,
        wearing=wearing_sentences(study.config().sensor_model()),
        utility=utility,
        n_patches=len(study.patches),
        mean_title=headline.mean_title(utility),
        mean_explained=headline.mean_sentence(utility),
        regions=best_regions(utility, study.patches),
        activities=_activities(study, summary, patch),
        mistakes=_mistakes(utility, patch),
        skipped=sorted(summary["skipped"], key=lambda entry: entry["file"]),
        style=Markup((PAGE / "style.css").read_text(encoding="utf-8")),
        scripts=[Markup((PAGE / name).read_text(encoding="utf-8")) for name in SCRIPTS],
        data=Markup(as_script_json(view_data(body, study.patches, utility, shown, patch))),
    )


def _activities(study: StudyResults, summary: dict[str, Any], best: int) -> list[dict[str, Any]]:
    """Each tested activity: its clips, its own best spot, and how the recommended patch `best` does."""
    utility, tested, rows = study.utility, study.utility.tested_clips(), []
    for number, name in enumerate(utility.activities):
        own = int(utility.expected_f1[:, number].argmax())
        rows.append(
            {
                "name": name,
                **summary["activities"][name],
                "where": study.patches.names[own],
                "patch": own,
                "expected": float(utility.expected_f1[own, number]),
                "f1": float(utility.f1[own, number]),
                "low": float(utility.f1_low[own, number]),
                "high": float(utility.f1_high[own, number]),
                "caution": few_clips(tested[number]),
                "at_best": float(utility.expected_f1[best, number]),
            }
        )
    return rows


def _notes(summary: dict[str, Any], n_patches: int) -> list[str]:
    """Notes on labels, copies, windows and garments."""
    notes = [f"Labels: {note}" for note in summary.get("labels", {}).get("notes", [])]
    windows = window_warning(summary["windows"], summary["clips"]["used"]) if "windows" in summary else ""
    worn = garment_sentence(summary.get("garments", {}), n_patches)
    caught = caught_sentences([(entry["clip"], entry) for entry in summary.get("used", [])])
    used = summary.get("used", [])
    copies = [(entry["file"], entry["same_motion_as"]) for entry in used if "same_motion_as" in entry]
    sentences = (copies_sentence(copies), windows, worn, *caught)
    return notes + [f"{sentence}." for sentence in sentences if sentence]


def _mistakes(utility: UtilityMap, patch: int) -> list[dict[str, Any]]:
    """Rows of the confusion table of one patch, each window count with its share of the row."""
    if len(utility.activities) > MAX_CONFUSED:
        return []
    return [
        {"name": name, "cells": [(int(count), float(count / max(row.sum(), 1))) for count in row]}
        for name, row in zip(utility.activities, utility.confusion[patch], strict=True)
    ]
