# SPDX-License-Identifier: GPL-3.0-or-later
"""Spots that people name in the panel are simulated and ranked as those of `w2w run --placements`."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from typer.testing import CliRunner

from w2w.core.imu.recording import ImuRecording
from w2w.core.patches.own_placements import read_placements
from w2w.core.study.results import StudyResults
from w2w.core.study.signals import place_patches, record_baked
from w2w.headless.app import APP
from w2w.scene.base.body import body_of
from w2w.scene.base.patches import empties_by_patch
from w2w.ui.jobs import jobs
from w2w.ui.results.own_placements import by_name, is_pending, patch_of_own, scores_of_own
from w2w.ui.steps import baking
from w2w.ui.study import signal_cache
from w2w.ui.study.state import (
    BAKED,
    bake_settings,
    config_of,
    patches_of,
    rank_settings,
    state_of,
    utility_of,
)

from ..sensor_steps import assert_same_to_one_step
from .made_study import N_PATCHES, make_study, open_study, save_study
from .test_restore import open_file

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

TABLE = "name,vertex,x,y,z\nStrap pod,1234,,,\nclip,,0.14,-0.06,0.98\n"


def table(folder: Path, text: str = TABLE) -> str:
    """A table of placements."""
    (folder / "own.csv").write_text(text, encoding="utf-8")
    return str(folder / "own.csv")


def click(body: bpy.types.Object, vertex: int) -> None:
    """Pick the patch of a vertex, as a click on it does."""
    assert bpy.ops.w2w.select_patch(patch=int(patches_of(body).labels[vertex])) == {"FINISHED"}
    body.w2w.picked_vertex = vertex


def all_steps() -> None:
    """From the patches to the ranking."""
    for step in (bpy.ops.w2w.place_patches, bpy.ops.w2w.bake_signals, bpy.ops.w2w.rank_patches):
        assert step() == {"FINISHED"}


@pytest.fixture
def ranked(library: Path, made_once: Callable[..., Path]) -> bpy.types.Object:
    """A ranked study with two placements of one's own."""

    def make(folder: Path) -> None:
        body = make_study(library)
        click(body, 1234)
        assert bpy.ops.w2w.add_placement(name=" Strap  pod") == {"FINISHED"}
        bpy.ops.w2w.add_placement(name="ring", vertex=int(patches_of(body).vertices[5]))
        all_steps()
        save_study(folder)

    return open_study(made_once("own study", make))


def test_a_clicked_spot_is_named_and_waits_for_the_patches_to_be_placed(library: Path) -> None:
    body = make_study(library)
    assert not bpy.ops.w2w.add_placement.poll()
    click(body, 1234)
    before = (body.w2w.patches_key, body.w2w.utility_key)
    assert bpy.ops.w2w.add_placement(name=" Strap  pod") == {"FINISHED"}
    assert by_name(body.w2w) == {"Strap pod": 1234}
    assert is_pending(body.w2w)
    assert (body.w2w.patches_key, body.w2w.utility_key) == before
    assert scores_of_own(body, body.w2w.own[0]) is None
    assert patch_of_own(body, body.w2w.own[0]) == -1
    bpy.ops.w2w.select_patch(patch=9)
    bpy.ops.w2w.add_placement(name="middle")
    assert by_name(body.w2w)["middle"] == patches_of(body).vertices[9]


@pytest.mark.slow
def test_placements_are_patches_with_signals_scores_and_a_rank(
    ranked: bpy.types.Object, tmp_path: Path
) -> None:
    study, patches, utility = ranked.w2w, patches_of(ranked), utility_of(ranked.w2w)
    assert not is_pending(study)
    assert len(patches) == N_PATCHES + 1  # the ring lies where a patch was sampled
    assert [patch_of_own(ranked, own) for own in study.own] == [N_PATCHES, 5]
    assert patches.names[N_PATCHES] == "Strap pod"
    assert empties_by_patch(study.patch_collection)[N_PATCHES].name == "Strap pod"
    expected = place_patches(body_of(ranked), config_of(study))
    np.testing.assert_array_equal(patches.triangles, expected.triangles)
    assert patches.names == expected.names
    pod = scores_of_own(ranked, study.own[0])
    others = np.setdiff1d(np.arange(N_PATCHES), 5)
    assert pod["rank"] == 1 + int((utility.expected_mean[others] > utility.expected_mean[N_PATCHES]).sum())
    assert pod["of"] == N_PATCHES
    study.max_places = 1
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    summary = json.loads((tmp_path / "saved" / "summary.json").read_text())
    assert summary["own_placements"] == [scores_of_own(ranked, own) for own in study.own]


@pytest.mark.slow
def test_those_added_later_are_all_that_is_baked(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body, sensors = make_study(library), []

    def counted(*given: object) -> ImuRecording:
        sensors.append(len(given[2]))
        return record_baked(*given)

    monkeypatch.setattr(baking, "record_baked", counted)
    clips = body.w2w.clips
    before = signal_cache.recording(clips[0])
    click(body, 1234)
    bpy.ops.w2w.add_placement(name="Strap pod")
    bpy.ops.w2w.place_patches()
    assert bpy.ops.w2w.bake_signals() == {"FINISHED"}
    assert sensors == [1] * len(clips)
    added = [signal_cache.recording(clip) for clip in clips]
    np.testing.assert_array_equal(added[0].acc[:, :N_PATCHES], before.acc)
    assert added[0].sites == patches_of(body).names
    for clip in clips:
        clip.selected = True
    assert bpy.ops.w2w.bake_signals(which="TICKED") == {"FINISHED"}
    assert sensors[len(clips) :] == [N_PATCHES + 1] * len(clips)
    for clip, had in zip(clips, added, strict=True):
        assert_same_to_one_step(had, signal_cache.recording(clip), config_of(body.w2w).sensor_model())


@pytest.mark.slow
def test_they_go_through_a_results_folder_and_back(ranked: bpy.types.Object, tmp_path: Path) -> None:
    shown = [scores_of_own(ranked, own) for own in ranked.w2w.own]
    saved = tmp_path / "saved"
    bpy.ops.w2w.save_results(directory=str(saved))
    assert StudyResults.load(saved).config().patches == N_PATCHES
    choice = tmp_path / "choice.json"
    done = CliRunner().invoke(
        APP, ["place", str(saved), "--must", "strap pod", "--max", "1", "--out", str(choice)]
    )
    assert done.exit_code == 0, done.output
    assert json.loads(choice.read_text())["worn_together"]["places"][0]["name"] == "Strap pod"
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    assert bpy.ops.w2w.open_results(filepath=str(saved)) == {"FINISHED"}
    again = bpy.context.scene.w2w.body
    assert by_name(again.w2w) == {"Strap pod": 1234, "ring": patches_of(again).vertices[5]}
    assert not is_pending(again.w2w)
    assert [scores_of_own(again, own) for own in again.w2w.own] == shown
    bpy.ops.w2w.save_results(directory=str(tmp_path / "again"))
    assert StudyResults.load(tmp_path / "again").config().placements == config_of(again.w2w).placements


@pytest.mark.slow
def test_wishes_may_name_them(ranked: bpy.types.Object) -> None:
    bpy.ops.w2w.select_patch(patch=N_PATCHES)
    assert bpy.ops.w2w.wish_picked(kind="MUST") == {"FINISHED"}
    assert ranked.w2w.wishes[-1].place == "Strap pod"
    ranked.w2w.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert N_PATCHES in [row.patch for row in ranked.w2w.worn]


@pytest.mark.slow
def test_another_name_keeps_signals_and_ranking_and_wishes_follow(ranked: bpy.types.Object) -> None:
    study = ranked.w2w
    bpy.ops.w2w.add_wish(kind="ONLY", place="Strap pod")
    shown = scores_of_own(ranked, study.own[0])
    study.own[0].title = " Wrist   pod "
    assert (study.own[0].name, study.own[0].title) == ("Wrist pod", "Wrist pod")
    assert {state_of(clip, bake_settings(study)) for clip in study.clips} == {BAKED}
    assert study.ranked_as == rank_settings(study)
    assert scores_of_own(ranked, study.own[0]) == shown | {"name": "Wrist pod"}
    assert study.wishes[-1].place == "Wrist pod"
    assert "Wrist pod" in [row.label for row in study.chosen]
    assert not is_pending(study)
    for taken in ("RING", "", patches_of(ranked).names[0].upper()):
        study.own[0].title = taken
        assert study.own[0].title == "Wrist pod"
        assert jobs.message.is_error


def test_a_name_or_a_vertex_that_is_taken_is_refused(ranked: bpy.types.Object) -> None:
    before = by_name(ranked.w2w)
    for name, vertex, why in (
        ("strap POD", 20, "called 'strap POD'"),
        ("cuff", 1234, "both at vertex 1234"),
        (patches_of(ranked).names[0], 20, "name your placement otherwise"),
        (" ", 20, "empty name"),
        ("cuff", 6890, "no vertex 6890"),
    ):
        bpy.ops.w2w.select_patch(patch=0)
        with pytest.raises(RuntimeError, match=why):
            bpy.ops.w2w.add_placement(name=name, vertex=vertex)
    assert by_name(ranked.w2w) == before


def test_a_removed_one_goes_when_the_patches_are_placed_again(ranked: bpy.types.Object) -> None:
    ranked.w2w.own_index = 0
    assert ranked.w2w.picked == N_PATCHES
    assert bpy.ops.w2w.remove_placement() == {"FINISHED"}
    assert list(by_name(ranked.w2w)) == ["ring"]
    assert is_pending(ranked.w2w)
    bpy.ops.w2w.select_patch(patch=0)
    assert bpy.ops.w2w.add_placement(name="Strap pod", vertex=77) == {"FINISHED"}  # its name is free again
    bpy.ops.w2w.remove_placement()
    bpy.ops.w2w.place_patches()
    assert len(patches_of(ranked)) == N_PATCHES
    assert not is_pending(ranked.w2w)
    bpy.ops.w2w.remove_patches()
    assert is_pending(ranked.w2w)


@pytest.mark.slow
def test_they_survive_another_shape_and_a_saved_file(ranked: bpy.types.Object, tmp_path: Path) -> None:
    before = by_name(ranked.w2w)
    ranked.w2w.shape.gender = 1.0
    assert by_name(ranked.w2w) == before
    bpy.ops.w2w.place_patches()
    assert patches_of(ranked).vertices[patch_of_own(ranked, ranked.w2w.own[0])] == 1234
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "study.blend"))
    again = open_file(tmp_path / "study.blend")
    assert by_name(again.w2w) == before
    assert not is_pending(again.w2w)


def test_a_table_is_read_as_the_command_line_reads_it(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "")
    assert bpy.ops.w2w.load_placements(filepath=table(tmp_path)) == {"FINISHED"}
    assert jobs.message.text.startswith("Read 2 placements from own.csv")
    vertex = by_name(body.w2w)["clip"]
    where = body_of(body).vertices[vertex]
    away = np.linalg.norm(body_of(body).vertices - read_placements(tmp_path / "own.csv")["clip"], axis=1)
    assert np.linalg.norm(where - body_of(body).vertices[away.argmin()]) == 0
    bpy.ops.w2w.load_placements(filepath=table(tmp_path, "name,vertex\nstrap POD,99\nring,5\n"))
    assert by_name(body.w2w) == {"Strap pod": 99, "clip": vertex, "ring": 5}
    for text, why in (("name,x,y,z\nkite,0,0,9\n", "'kite' lies"), ("name,vertex\n", "names no placement")):
        with pytest.raises(RuntimeError, match=why):
            bpy.ops.w2w.load_placements(filepath=table(tmp_path, text))
    assert list(by_name(body.w2w)) == ["Strap pod", "clip", "ring"]


@pytest.mark.slow
def test_both_doors_tell_the_same_of_them(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "motions")
    bpy.ops.w2w.load_placements(filepath=table(tmp_path))
    all_steps()
    options = ["--patches", str(N_PATCHES), "--workers", "1", "--no-pictures"]
    options += ["--no-report", "--placements", str(tmp_path / "own.csv"), "--out", str(tmp_path / "out")]
    done = CliRunner().invoke(APP, ["run", str(library), *options])
    assert done.exit_code == 0, done.output
    told = json.loads((tmp_path / "out" / "summary.json").read_text())["own_placements"]
    shown = [scores_of_own(body, own) for own in body.w2w.own]
    exact = ("patch", "name", "region", "vertex", "of")
    assert [{key: one[key] for key in exact} for one in told] == [
        {key: one[key] for key in exact} for one in shown
    ]
    for key in ("expected_f1", "mean_f1", "costs"):  # actions are in single precision: a window may flip
        np.testing.assert_allclose([one[key] for one in told], [one[key] for one in shown], atol=0.02)
