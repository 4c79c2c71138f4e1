# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of a finished study: one for each heatmap, and the study as a Blender file."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from w2w.core.colours import patch_colours, score_range, span_note
from w2w.core.results_folder import StudyResults
from w2w.core.selection.advice import best_single
from w2w.core.selection.headline import mean_title
from w2w.core.wording import capital

from ..blender import needs_blender
from ..runs.folder import HEATMAPS, MEAN, SUBSET, picture_names

if TYPE_CHECKING:
    from w2w.drawing.body import BodyPictures  # Pillow and matplotlib are slow to import

BLEND = "study.blend"

EXPECTED = "Expected F1"
"""What the colours of every heatmap mean."""

MAX_LISTED = 12
"""Sensors that fit beside the picture; the summary lists all."""


def write_pictures(out: Path) -> None:
    """Draw `heatmaps/*.png` of a finished study: one for each activity, the mean and the set."""
    from w2w.drawing.body import BodyPictures, size_for
    from w2w.drawing.heatmap import VIEW_PIXELS, heatmap_figure  # matplotlib is slow to import

    study = StudyResults.load(out)
    utility = study.utility
    folder = out / HEATMAPS
    titles = [name.replace("_", " ").capitalize() for name in utility.activities]
    best = [int(scores.argmax()) for scores in utility.expected_f1.T]
    maps = [*zip(picture_names(utility.activities), titles, utility.expected_f1.T, best, strict=True)]
    allowed = study.config().constraints.terms(study.patches)["allowed"]
    maps.append((MEAN, mean_title(utility), utility.expected_mean, best_single(utility, allowed)))
    body = study.body()
    shaded = BodyPictures(body, size_for(body, VIEW_PIXELS - 3))  # soft edges may take three more
    with ThreadPoolExecutor(1) as pages:  # the next body is coloured while the last one's page is made
        drawn = []
        for name, title, scores, spot in maps:
            low, high = score_range(scores, utility.colour_span)
            views = shaded.coloured(patch_colours(study.patches, scores, low, high))
            subtitle = "" if utility.can_rank else "These clips cannot rank placements. "
            subtitle += f"Best spot: {study.patches.names[spot]} ({scores[spot]:.2f} on other clips)"
            note = span_note(scores, low, high)
            page = (folder / f"{name}.png", views, title, low, high, EXPECTED, subtitle)
            drawn.append(pages.submit(heatmap_figure, *page, note=note))
        for one in drawn:
            one.result()
        _draw_worn(study, shaded)


def write_blend(out: Path) -> None:
    """Save a finished study's `study.blend`: body, actions, empties, heatmaps and what the panel shows."""
    with needs_blender():
        from w2w.scene.study_file import write_study

    study = StudyResults.load(out)
    utility, body = study.utility, study.body()
    write_study(
        out / BLEND,
        body,
        study.patches,
        (study.motion(clip.name) for clip in study.clips),
        utility.expected_f1,
        utility.activities,
        utility.expected_mean,
        marked(study).order,
        results=study,
        span=utility.colour_span,
    )


class Marked(NamedTuple):
    """The set that a picture marks, with the expected F1 of its first sensor, its first two, and so on."""

    order: list[int]
    scores: list[float]
    target: float | None
    sentence: str


def marked(study: StudyResults) -> Marked:
    """The set to wear together in the summary; the best spot where there is none."""
    worn = study.summary.get("worn_together")
    if worn is None:
        best = study.summary["best_single_patch"]
        return Marked([best["patch"]], [best["expected_f1"]], None, best["sentence"])
    order = [sensor["patch"] for sensor in worn["places"]]
    scores = [sensor["expected_f1_so_far"] for sensor in worn["places"]]
    return Marked(order, scores, worn["target"], capital(worn["sentence"]))


def _draw_worn(study: StudyResults, shaded: BodyPictures) -> None:
    from w2w.drawing.heatmap import subset_figure  # matplotlib is slow to import

    utility, patches, body = study.utility, study.patches, shaded.body
    shown = marked(study)
    order = list(shown.order[:MAX_LISTED])
    low, high = score_range(utility.expected_mean, utility.colour_span)
    pictures = shaded.coloured(patch_colours(patches, utility.expected_mean, low, high))
    corners = body.vertices[patches.triangles[order]]
    normals = body.vertex_normals[patches.triangles[order]].mean(axis=1)
    subtitle = shown.sentence
    if len(order) < len(shown.order):
        subtitle += f" (the first {len(order)} of {len(shown.order)} patches shown)"
    count = f"{len(shown.order)} sensor{'s' if len(shown.order) != 1 else ''}"
    subset_figure(
        study.out / HEATMAPS / f"{SUBSET}.png",
        pictures,
        f"Where to wear {count}",
        shaded.locate(corners.mean(axis=1), normals),
        [patches.names[patch] for patch in order],
        shown.scores[: len(order)],
        EXPECTED,
        target=shown.target,
        subtitle=subtitle,
        scale=(low, high),
        scale_label=EXPECTED,
        note=span_note(utility.expected_mean, low, high),
    )
