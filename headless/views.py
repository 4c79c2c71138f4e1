# SPDX-License-Identifier: GPL-3.0-or-later
"""What a finished study looks like: a picture for each heatmap, and the study as a Blender file."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from blender_addon.w2w.core.amass import read_amass
from blender_addon.w2w.core.colours import patch_colours, score_range
from blender_addon.w2w.core.library import unique_names
from blender_addon.w2w.core.motion import Motion

from .figures import heatmap_figure, subset_figure
from .load_clip import quiet_output
from .pipeline import Study
from .progress import Progress

if TYPE_CHECKING:
    from blender_addon.w2w.scene.render import BodyRenderer

MEAN, SUBSET = "mean", "subset"

MAX_LISTED = 12
"""More places than this do not fit beside the picture; the summary has them all."""


def write_pictures(study: Study, progress: Progress) -> None:
    """Draw `heatmaps/*.png`: one an activity, one of the mean, one of the chosen places."""
    from blender_addon.w2w.scene.render import BodyRenderer

    utility = study.recommendation.utility
    folder = study.out / "heatmaps"
    folder.mkdir(exist_ok=True)
    for old in folder.glob("*.png"):
        old.unlink()
    titles = [name.replace("_", " ").capitalize() for name in utility.activities]
    maps = [*zip(picture_names(utility.activities), titles, utility.f1.T, strict=True)]
    maps.append((MEAN, "All activities (mean)", utility.mean))
    with progress.bar("Drawing heatmaps", len(maps) + 1) as advance, BodyRenderer(study.body) as renderer:
        for name, title, scores in maps:
            low, high = score_range(scores)
            with quiet_output():
                pictures = renderer.render(patch_colours(study.patches, scores, low, high))
            best = study.patches.names[int(np.argmax(scores))]
            heatmap_figure(
                folder / f"{name}.png", pictures, title, low, high, subtitle=f"Best spot: {best} ({high:.2f})"
            )
            advance(1)
        _draw_subset(study, renderer)
        advance(1)


def picture_names(activities: tuple[str, ...]) -> list[str]:
    """File names of the activities' pictures, distinct from each other and from the other two."""
    names = unique_names([MEAN, SUBSET, *(f"{activity}." for activity in activities)])
    return names[2:]


def write_blend(study: Study, progress: Progress) -> None:
    """Save `study.blend`: body, actions, parented empties and heatmaps."""
    from blender_addon.w2w.scene.study_file import write_study

    utility = study.recommendation.utility
    with progress.spinner("Saving study.blend"), quiet_output():
        write_study(
            study.out / "study.blend",
            study.body,
            study.patches,
            _motions(study),
            utility.f1,
            utility.activities,
            utility.mean,
            study.recommendation.subset.order,
        )


def _draw_subset(study: Study, renderer: BodyRenderer) -> None:
    utility, subset, patches = study.recommendation.utility, study.recommendation.subset, study.patches
    order = list(subset.order[:MAX_LISTED])
    low, high = score_range(utility.mean)
    with quiet_output():
        pictures = renderer.render(patch_colours(patches, utility.mean, low, high))
    corners = study.body.vertices[patches.triangles[order]]
    normals = study.body.vertex_normals[patches.triangles[order]].mean(axis=1)
    subtitle = subset.sentence()
    if len(order) < len(subset.order):
        subtitle += f" (the first {len(order)} of {len(subset.order)} places shown)"
    count = f"{len(subset.order)} sensor{'s' if len(subset.order) != 1 else ''}"
    subset_figure(
        study.out / "heatmaps" / f"{SUBSET}.png",
        pictures,
        f"Where to wear {count}" if subset.reached else "Where to wear: the best set there is",
        renderer.locate(corners.mean(axis=1), normals),
        [patches.names[patch] for patch in order],
        subset.mean_max_after_each[: len(order)],
        target=subset.target,
        subtitle=subtitle,
        scale=(low, high),
    )


def _motions(study: Study) -> Iterator[Motion]:
    for outcome in study.used:
        clip = outcome.clip
        motion = read_amass(study.out / "motions" / f"{clip.name}.npz", z_up=True)
        yield motion.labelled(clip.activity, clip.subject, clip.name)
