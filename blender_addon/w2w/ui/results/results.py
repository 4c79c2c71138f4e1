# SPDX-License-Identifier: GPL-3.0-or-later
"""A ranking on the body: heatmaps, the chosen sensors and the table of regions."""

import json
from collections.abc import Sequence

import bpy
import numpy as np

from ...core.colours import score_range
from ...core.findings.advice_content import answer_content, place_content
from ...core.findings.cautions import POSTURES, alone_caution, cautions, heaviest_first
from ...core.ranking.utility import UtilityMap
from ...core.selection import headline
from ...core.selection.answer import find_answer
from ...core.selection.scored import PlaceScore, compare_known
from ...core.study.choosing import scored_map
from ...core.study.ranking import LabelledClip
from ...core.wording import capital
from ...scene import heatmap
from ...scene.base.patches import empties_by_patch, mark_empties
from ...scene.files.study_file import pack
from ..jobs import jobs
from ..study import counting, lists, scores, state
from ..viewport import legend

TABLE_ROWS = 8

_waiting: set[str] = set()
"""Bodies to paint when they leave Edit Mode."""


def store(body: bpy.types.Object, utility: UtilityMap, ranked_as: str, clips: Sequence[LabelledClip]) -> None:
    """Keep a ranking of clips, each with the first of its motion, in the file and show it on the body."""
    study = body.w2w
    first = not study.utility_key
    if first:
        study.show_patches = False  # hundreds of axes would hide the colours
    same = not first and [activity.name for activity in study.activities] == list(utility.activities)
    study.utility_text, study.utility_key = pack(utility)
    study.ranked_as = ranked_as
    facts = (lists.facts_of(study.clips[clip.name]) for clip in clips)
    study.cautions_text = json.dumps(cautions(utility, clips, facts, state.config_of(study)))
    with state.without_updates():
        counting.list_activities(study, utility.activities, state.run_of(study))
        if not same:
            study.view, study.minus, study.activity_index = scores.MEAN_VIEW, scores.NOTHING, -1
    if not body.data.materials:
        body.data.materials.append(heatmap.heatmap_material())
    choose(body)
    paint(body)


def clear(body: bpy.types.Object) -> None:
    """Remove a ranking, which was of other patches."""
    study = body.w2w
    study.utility_text = study.utility_key = study.ranked_as = study.answer_text = study.cautions_text = ""
    study.compared_text = ""
    lists.list_labels(study)
    study.chosen.clear()
    study.regions.clear()
    lists.forget_advice(study)
    study.picked = study.compared = -1
    for mesh in legend.meshes_of(body):
        heatmap.remove_heatmaps(mesh)
    legend.remove_marks(body)
    legend.remove(body)
    heatmap.remove_heatmaps(body)
    if study.chosen_collection is not None:
        bpy.data.collections.remove(study.chosen_collection)


def fit_range(body: bpy.types.Object) -> None:
    """Let one fixed colour range span the scores of all activities."""
    study, utility = body.w2w, state.utility_of(body.w2w)
    if utility is None:
        return
    with state.without_updates():
        study.fix_range = True
        f1 = scores.activity_scores(study, utility)
        study.range_low, study.range_high = score_range(f1)
    paint(body)


def paint(body: bpy.types.Object, follow: bool = True) -> None:
    """Colour the body's heatmaps and show the chosen one; other bodies that show it `follow`."""
    study, patches = body.w2w, state.patches_of(body)
    utility = state.utility_of(study)
    if utility is None or patches is None:
        return
    if body.data.is_editmode:  # colours cannot be reached there: they follow when it is left
        _waiting.add(body.name)
        return
    shared = None
    if study.fix_range or scores.beside_of(study) is not None:
        shared = scores.scale_of(study, utility)
    f1, mean = scores.activity_scores(study, utility), scores.mean_scores(study, utility)
    name = heatmap.MEAN if study.scores == scores.EXPECTED else heatmap.ON_THESE_CLIPS
    heatmap.add_heatmaps(
        body, patches, f1, utility.activities, mean, name,
        lambda own: shared or scores.own_scale(study, own),
    )  # fmt: skip
    if scores.minus_index(study) >= 0:
        heatmap.add_difference(body, patches, scores.shown_scores(study, utility))
    legend.paint_character(body)
    legend.paint(body)
    show(body)
    for other in legend.bodies_beside(body) if follow else ():
        paint(other, follow=False)


def paint_waiting() -> None:
    """Paint the bodies whose colours were changed while they were in Edit Mode, and are no longer."""
    for body in [bpy.data.objects.get(name) for name in _waiting]:
        if body is not None and not body.data.is_editmode:
            _waiting.discard(body.name)
            paint(body)


def show(body: bpy.types.Object) -> None:
    """Show the heatmap that the study's view names."""
    names = heatmap.heatmap_names(body)
    if not names:
        return
    less = scores.minus_index(body.w2w) >= 0 and heatmap.DIFFERENCE in names
    name = heatmap.DIFFERENCE if less else names[min(scores.view_index(body.w2w), len(names) - 1)]
    heatmap.show_heatmap(body, name)
    legend.show_on_character(body)


def list_regions(body: bpy.types.Object, allowed: np.ndarray | None = None) -> None:
    """Fill the table of regions, each by its best patch of those allowed (N,)."""
    study, patches = body.w2w, state.patches_of(body)
    utility = state.utility_of(study)
    study.regions.clear()
    if utility is None or patches is None:
        return
    mean = scores.expected_mean(study, utility)
    whole = counting.is_as_ranked(study, utility) and not headline.mean_caution(utility)
    for patch in patches.best_of_regions(mean, allowed)[:TABLE_ROWS]:
        row = study.regions.add()
        row.patch, row.label, row.f1 = patch, patches.regions[patch], mean[patch]
        row.low, row.high = utility.expected.at(patch)[1:] if whole else (0.0, 0.0)


def choose(body: bpy.types.Object) -> None:
    """Choose the best spot that the wishes allow, and mark it on the body."""
    study, patches = body.w2w, state.patches_of(body)
    utility = state.utility_of(study)
    if utility is None or patches is None:
        return
    study.chosen.clear()
    if jobs.message is not None and not jobs.message.is_error:
        jobs.dismiss()  # it may tell the answer before
    config = state.config_of(study)
    try:
        terms = config.constraints.terms(patches, config.max_places)
    except ValueError as error:
        lists.keep_answer(study, {"sentence": f"{capital(error)}."})
        list_regions(body)
        mark_chosen(body)
        return
    list_regions(body, terms.allowed)
    mean = scores.expected_mean(study, utility)
    if counting.is_as_ranked(study, utility):
        found = find_answer(scored_map(utility, patches, state.body_as_run(body), config))
        others = [each for each in lists.cautions_of(study) if not each.text.startswith(POSTURES)]
        about = heaviest_first([*others, alone_caution(utility, "posture", found.posture, found.patch)])
        study.cautions_text = json.dumps(about)
        lists.keep_answer(study, answer_content(found, patches, about))
        patch = found.patch
    else:
        patch = int(np.where(terms.allowed, mean, -1).argmax())
        f1 = f"F1 {headline.short(mean[patch])} over the activities that count"
        lists.keep_answer(study, {"sentence": f"{capital(patches.names[patch])}: {f1}."})
    row = study.chosen.add()
    row.patch, row.label, row.f1 = patch, patches.names[patch], mean[patch]
    compare_places(body)
    mark_chosen(body)


def compare_places(body: bpy.types.Object) -> None:
    """Score the products and places that are to be compared, as `w2w place --compare` does."""
    study = body.w2w
    words = [word.strip() for word in study.compare.split(",") if word.strip()]
    if not words:
        study.compared_text = ""
        return
    known: Sequence[PlaceScore] = ()
    try:
        utility, patches, config = state.ranking_of(body), state.placed_patches(body), state.config_of(study)
        known, unknown = compare_known(scored_map(utility, patches, state.body_as_run(body), config), words)
    except ValueError as error:
        unknown = [f"{capital(error)}."]
    study.compared_text = json.dumps([[place_content(score, patches) for score in known], " ".join(unknown)])


def mark_chosen(body: bpy.types.Object) -> None:
    """Draw the leading set as spheres, in a collection of their own, and on the character; others as axes."""
    study = body.w2w
    if study.patch_collection is None:
        return
    empties = empties_by_patch(study.patch_collection)
    patches, chosen = state.patches_of(body), list(lists.leading(study))
    wanted = [empties[row.patch] for row in chosen if row.patch in empties]
    if study.chosen_collection is None:
        study.chosen_collection = bpy.data.collections.new(f"Sensor Places: {body.name}")
        study.chosen_collection.color_tag = "COLOR_01"
        home = body.users_collection[0] if body.users_collection else bpy.context.scene.collection
        home.children.link(study.chosen_collection)
    mark_empties(study.chosen_collection, wanted, study.patch_size)
    if study.character is not None and patches is not None:
        vertices = [int(patches.vertices[row.patch]) for row in chosen]
        legend.mark_character(body, vertices, [row.label for row in chosen])


def hide_patches(study: bpy.types.PropertyGroup) -> None:
    """Show or hide all patches through their collection, or Blender would still evaluate them."""
    if study.patch_collection is not None:
        study.patch_collection.hide_viewport = not study.show_patches
