# SPDX-License-Identifier: GPL-3.0-or-later
"""The five steps through their operators, without a window."""

from __future__ import annotations

import base64
import io
import zlib
from dataclasses import fields, replace
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
import pytest

from w2w.core.colours import LEAST_SPAN, Scale
from w2w.core.findings import in_words
from w2w.core.ranking.utility import CLASSIFIERS
from w2w.core.selection import headline
from w2w.core.selection.answer import find_answer
from w2w.core.selection.headline import mean_caution, repeat_sentence, short
from w2w.core.selection.scored import ScoredMap, best_single
from w2w.scene.base.body import body_of
from w2w.scene.base.patches import patch_empties
from w2w.scene.heatmap import heatmap_names
from w2w.ui.jobs import jobs
from w2w.ui.panels import menus, properties
from w2w.ui.results import results
from w2w.ui.steps.baking import as_labelled, ranked_clips
from w2w.ui.study import scores
from w2w.ui.study.lists import answer_of, cautions_of
from w2w.ui.study.state import (
    STALE,
    bake_settings,
    config_of,
    missing_for_any_rank,
    missing_for_bake,
    missing_for_rank,
    patches_of,
    state_of,
    unreadable_ranking,
    utility_of,
)

from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def test_each_step_says_what_is_missing(library: Path) -> None:
    assert missing_for_bake(None) == "Add a body first"
    assert not bpy.ops.w2w.place_patches.poll()
    body = make_study(library, "")
    assert "Import motions" in missing_for_bake(body)
    bpy.ops.w2w.import_folder(directory=str(library))
    assert "Place spots" in missing_for_bake(body)
    bpy.ops.w2w.place_patches()
    assert missing_for_bake(body) == ""
    assert "Bake" in missing_for_rank(body)
    assert not bpy.ops.w2w.rank_patches.poll()
    bpy.ops.w2w.bake_signals()
    assert missing_for_rank(body) == ""


def test_the_joint_that_moves_decides_where_its_activity_is_seen(library: Path) -> None:
    body = make_study(library)
    utility = utility_of(body.w2w)
    assert set(utility.activities) == {"waving", "kicking", "stepping"}
    regions = np.array(patches_of(body).regions)
    waving = utility.f1[:, utility.activities.index("waving")]
    on_right_arm = np.array([region.startswith(("right elbow", "right palm")) for region in regions])
    assert waving[on_right_arm].min() > 0.9
    assert len(heatmap_names(body)) == 4
    assert not body.w2w.show_patches
    assert [place.patch for place in body.w2w.chosen] == [answer_of(body.w2w)["patch"]]


def test_the_ticks_choose_anew_at_once(library: Path) -> None:
    body = make_study(library)
    study, utility = body.w2w, utility_of(body.w2w)
    study.activities[0].part = "LEFT_OUT"
    mean = utility.expected_f1[:, 1:].mean(axis=1)
    (best,) = study.chosen
    assert best.f1 == study.regions[0].f1 == pytest.approx(mean.max(), abs=1e-6)
    chosen = {patch_empties(study.patch_collection).index(item) for item in study.chosen_collection.objects}
    assert chosen == {best.patch}


def test_views_show_their_heatmap(library: Path) -> None:
    body = make_study(library)
    for number, activity in enumerate(body.w2w.activities, start=1):
        body.w2w.view = f"A{number}"
        assert body.data.color_attributes.active_color.name == f"Expected F1: {activity.name}"
    body.w2w.view = "MEAN"
    assert body.data.color_attributes.active_color.name == "Expected F1"


def test_heatmaps_show_the_expected_f1_or_that_of_these_clips(library: Path) -> None:
    body = make_study(library)
    utility, patches = utility_of(body.w2w), patches_of(body)

    def shown() -> np.ndarray:
        attribute = body.data.color_attributes.active_color
        values = np.empty(4 * len(attribute.data), dtype=np.float32)
        attribute.data.foreach_get("color_srgb", values)
        return values.reshape(-1, 4)[:, :3]

    step, span = 1.1 / 255, LEAST_SPAN
    np.testing.assert_allclose(
        shown(), Scale.of(utility.expected_mean, span).colours(patches, utility.expected_mean), atol=step
    )
    body.w2w.scores = "ON_THESE"
    assert body.data.color_attributes.active_color.name == "F1 on these clips"
    assert len(heatmap_names(body)) == 4
    np.testing.assert_allclose(
        shown(), Scale.of(utility.mean, span).colours(patches, utility.mean), atol=step
    )


def test_the_panel_warns_where_sources_and_activities_coincide(library: Path) -> None:
    body = make_study(library)
    study, utility = body.w2w, utility_of(body.w2w)
    for clip in study.clips:
        clip.rate = 120.0 if clip.activity == "waving" else 30.0
    used = [replace(as_labelled(clip), motion_key=clip.name) for clip in ranked_clips(study)]
    assert not [caution for caution in cautions_of(study) if "sources" in caution.text]
    results.store(body, utility, study.ranked_as, used)
    first = cautions_of(study)[0]
    assert first.weight == "stops the answer"
    assert "kicking and stepping come from SMPL skeletons at 30 frames/s alone" in first.text
    assert "waving from SMPL skeletons at 120 frames/s alone" in first.text
    results.clear(body)
    assert cautions_of(study) == []


def test_the_panel_says_what_the_console_and_the_report_say(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = make_study(library)
    study, utility, patches = body.w2w, utility_of(body.w2w), patches_of(body)
    best = best_single(utility)
    sentences = in_words.sure_sentences(answer_of(study), utility)
    found = find_answer(ScoredMap(utility, patches, body_of(body)))
    assert answer_of(study)["sentence"] == found.sentence()
    assert sentences[-1] == f"{repeat_sentence(utility)}."
    assert found.detail() in sentences
    first, second = scores.patch_lines(study, utility, best)
    assert mean_caution(utility)  # the library has few clips
    assert first == f"expected F1 {utility.expected_mean[best]:.2f} (too few clips for an interval)"
    assert second == f"rank 1 of {len(patches)}, as good; on these clips {utility.mean[best]:.2f}"
    assert study.regions[0].high == 0
    for module in (headline, in_words):
        monkeypatch.setattr(module, "mean_caution", lambda _: "")
    first, second = scores.patch_lines(study, utility, best)
    low, high = utility.expected_low[best], utility.expected_high[best]
    assert first.startswith(f"expected F1 {utility.expected_mean[best]:.2f} ({low:.2f} to {high:.2f})")
    assert first.endswith(", as good")
    assert second.startswith(f"rank 1 of {len(patches)}; on these clips {utility.mean[best]:.2f} (")
    results.list_regions(body)
    assert study.regions[0].high == pytest.approx(high)
    study.activities[0].part = "LEFT_OUT"
    fewer = utility.expected_f1[:, 1:].mean(axis=1)
    assert f"F1 {short(fewer.max())} over the activities" in answer_of(study)["sentence"]
    assert study.regions[0].f1 == pytest.approx(fewer.max(), abs=1e-6)


@pytest.mark.slow
def test_a_ranking_that_cannot_be_read_is_said_to_be_one_and_can_be_made_anew(library: Path) -> None:
    body = make_study(library)
    utility = utility_of(body.w2w)
    assert unreadable_ranking(body.w2w) == ""
    arrays = {field.name: getattr(utility, field.name) for field in fields(utility)}
    del arrays["reliability"]
    arrays["left_out"] = "{}"
    content = io.BytesIO()
    np.savez(content, **arrays)
    body.w2w.utility_text = base64.b64encode(zlib.compress(content.getvalue())).decode("ascii")
    body.w2w.utility_key = "earlier"
    assert utility_of(body.w2w) is None
    assert unreadable_ranking(body.w2w).startswith("The ranking in this file cannot be read")
    assert bpy.ops.w2w.rank_patches() == {"FINISHED"}
    assert utility_of(body.w2w) is not None


def test_placing_again_leaves_nothing_stale(library: Path) -> None:
    body = make_study(library)
    objects = len(bpy.data.objects)
    body.w2w.patch_seed = 1
    bpy.ops.w2w.place_patches()
    assert len(bpy.data.objects) == objects
    assert utility_of(body.w2w) is None
    assert len(heatmap_names(body)) == 0
    assert {state_of(clip, bake_settings(body.w2w)) for clip in body.w2w.clips} == {STALE}
    empties = patch_empties(body.w2w.patch_collection)
    carriers = [empty.parent_vertices[:] for empty in empties]
    np.testing.assert_array_equal(carriers, patches_of(body).triangles)


def test_two_studies_in_one_file_do_not_mix(library: Path) -> None:
    first = make_study(library)
    before = (first.w2w.utility_key, [clip.signals for clip in first.w2w.clips], len(first.w2w.chosen))
    second = make_study(library, "motions patches")
    assert second is not first
    assert utility_of(second.w2w) is None
    second.w2w.activities["waving"].part = "BACKGROUND"
    assert {activity.part for activity in first.w2w.activities} == {"COUNTED"}
    bpy.ops.w2w.remove_patches()
    assert (first.w2w.utility_key, [c.signals for c in first.w2w.clips], len(first.w2w.chosen)) == before
    assert len(first.w2w.patch_collection.objects) == N_PATCHES
    assert {clip.action for clip in first.w2w.clips}.isdisjoint({clip.action for clip in second.w2w.clips})


def test_a_copied_body_does_not_claim_the_patches_of_the_first(library: Path) -> None:
    body = make_study(library, "patches")
    copy = body.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert patches_of(copy) is None
    assert patches_of(body) is not None


def test_an_unfit_mesh_is_refused_with_a_reason(library: Path) -> None:
    make_study(library, "")
    bpy.ops.mesh.primitive_cube_add()
    with pytest.raises(RuntimeError, match="has no armature, and its faces are not SMPL"):
        bpy.ops.w2w.use_mesh()
    assert jobs.message.is_error


def test_a_classifier_that_cannot_work_here_says_why_and_can_be_changed(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = make_study(library, "motions patches signals")

    class Unavailable:
        @staticmethod
        def unavailable() -> str:
            return "the classifier needs PyTorch"

    with monkeypatch.context() as patched:
        patched.setitem(CLASSIFIERS, body.w2w.classifier, SimpleNamespace(load=lambda: Unavailable))
        assert missing_for_rank(body).startswith("The classifier needs PyTorch")
        assert missing_for_any_rank(body) == ""
        assert not bpy.ops.w2w.rank_patches.poll()
    assert bpy.ops.w2w.rank_patches.poll()


def test_presets_set_the_sensor(library: Path) -> None:
    body = make_study(library, "")
    presets = sorted((menus.PRESETS / menus.PRESET_FOLDER).glob("*.py"))
    assert len(presets) >= 3
    for preset in presets:
        bpy.ops.script.execute_preset(filepath=str(preset), menu_idname="W2W_MT_study_presets")
        assert f'study.sensor = "{body.w2w.sensor}"' in preset.read_text()
        assert config_of(body.w2w).synthesis.rate_hz == body.w2w.rate


def test_everything_has_a_tooltip() -> None:
    for name in dir(bpy.ops.w2w):
        assert getattr(bpy.ops.w2w, name).get_rna_type().description, name
    for group in (properties.W2W_PG_study, properties.W2W_PG_scene):
        for prop in group.bl_rna.properties:
            if (
                not prop.is_readonly
                and not prop.is_hidden
                and not prop.identifier.endswith(("name", "_text", "_key", "ranked_as"))
            ):
                assert prop.description or prop.type in ("COLLECTION", "POINTER"), prop.identifier


def test_numbers_that_have_a_unit_show_it() -> None:
    study, shape = properties.W2W_PG_study.bl_rna, properties.W2W_PG_study.bl_rna.properties["shape"]
    assert study.properties["rate"].name == "Rate (Hz)"
    assert study.properties["window_s"].unit == "TIME_ABSOLUTE"
    assert shape.fixed_type.properties["weight"].name == "Weight (kg)"
    assert shape.fixed_type.properties["height"].unit == "LENGTH"
