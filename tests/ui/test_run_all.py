# SPDX-License-Identifier: GPL-3.0-or-later
"""Run All does what is missing, keeps what was done when it is ended, and stops at no bad clip."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import bpy
import numpy as np
import pytest

from w2w.core.motion.motion import Motion
from w2w.core.patches import strip_graph
from w2w.ui.jobs import jobs
from w2w.ui.steps import baking
from w2w.ui.steps.run_all import TITLE, kept_of, run_all_steps
from w2w.ui.study import state
from w2w.ui.study.lists import advice_of, answer_of
from w2w.ui.study.state import BAKED, bake_settings, patches_of, rank_settings, state_of, utility_of

from .made_study import N_PATCHES, make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")


def baked(body: bpy.types.Object) -> int:
    """How many clips have signals that are up to date."""
    return sum(state_of(clip, bake_settings(body.w2w)) == BAKED for clip in body.w2w.clips)


@pytest.mark.later
def test_one_press_leads_from_motions_to_sensors(library: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    measured, measure = [], strip_graph._measured.__wrapped__
    once = lru_cache(2)(lambda *given: measured.append(len(given[1])) or measure(*given))
    monkeypatch.setattr(strip_graph, "_measured", once)
    body = make_study(library, "motions")
    body.w2w.max_places, body.w2w.patch_count = 1, N_PATCHES - 1  # as in no other test
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert measured.count(N_PATCHES - 1) == 1  # for the ranking, and for the choice
    assert len(patches_of(body)) == N_PATCHES - 1
    assert baked(body) == 9
    assert body.w2w.ranked_as == rank_settings(body.w2w)
    assert advice_of(body.w2w)["worn_together"] is not None
    assert (jobs.message.job, jobs.message.is_error) == (TITLE, False)
    assert jobs.message.text == f"Done: {answer_of(body.w2w)['sentence']}"
    keys = [clip.signals for clip in body.w2w.clips]
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert jobs.message.text == "Everything is up to date"
    body.w2w.target = 0.99
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert advice_of(body.w2w)["worn_together"]["target"] == pytest.approx(0.99)
    assert [clip.signals for clip in body.w2w.clips] == keys


@pytest.mark.slow
def test_patches_are_placed_again_if_their_number_has_changed(library: Path) -> None:
    body = make_study(library)
    assert state.outdated(body) == ""
    body.w2w.patch_count = N_PATCHES - 4
    assert "number of spots" in state.outdated(body)
    body.w2w.max_places = 1
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert len(patches_of(body)) == N_PATCHES - 4
    assert state.outdated(body) == ""


@pytest.mark.slow
def test_what_was_baked_when_it_is_ended_is_not_baked_again(
    library: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    body = make_study(library, "motions patches")
    body.w2w.max_places = 1
    kept = kept_of(body)
    assert kept() == ""
    steps = run_all_steps(body)
    fractions = []
    while baked(body) < 4:
        fractions.append(next(steps).fraction)
    steps.close()
    assert fractions == sorted(fractions)
    assert baked(body) == 4
    assert kept() == "4 of 9 clips are baked, and Run All goes on from there"
    keys = [clip.signals for clip in body.w2w.clips]
    asked = []
    bake = baking._bake_clip
    monkeypatch.setattr(
        baking,
        "_bake_clip",
        lambda mesh, baker, first, index, *ends: (
            asked.append(index) or bake(mesh, baker, first, index, *ends)
        ),
    )
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert asked == [4, 5, 6, 7, 8]
    assert [clip.signals for clip in body.w2w.clips][:4] == keys[:4]
    assert utility_of(body.w2w) is not None


@pytest.mark.slow
def test_a_clip_that_cannot_be_baked_stops_no_other(library: Path, tmp_path: Path) -> None:
    body = make_study(library, "motions patches")
    body.w2w.max_places = 1
    motion = Motion.load(next(library.rglob("*.npz")))
    short = Motion(motion.rotations[:9], motion.pelvis[:9], motion.rate)
    (tmp_path / "waving").mkdir()
    short.save(tmp_path / "waving" / "blink.npz")
    assert bpy.ops.w2w.import_folder(directory=str(tmp_path)) == {"FINISHED"}
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert jobs.message.text.endswith(" Not baked: waving_blink; the list of motions says why.")
    assert baked(body) == 9
    assert body.w2w.clips[9].bake_path.startswith(baking.UNBAKED)
    assert np.isfinite(utility_of(body.w2w).expected_mean).all()
    with pytest.raises(RuntimeError, match=r"No clip could be baked: .*blink"):
        bpy.ops.w2w.bake_signals()


def test_what_it_waits_for_is_said(library: Path) -> None:
    body = make_study(library, "")
    assert not bpy.ops.w2w.run_all.poll()
    bpy.ops.w2w.import_folder(directory=str(library))
    assert bpy.ops.w2w.run_all.poll()
    for clip in body.w2w.clips[3:]:
        clip.activity = " "
    assert not bpy.ops.w2w.run_all.poll()


@pytest.mark.slow
def test_placements_of_ones_own_are_taken_over(library: Path) -> None:
    body = make_study(library)
    body.w2w.max_places = 1
    bpy.ops.w2w.select_patch(patch=3)
    bpy.ops.w2w.add_placement(name="pod", vertex=1234)
    assert bpy.ops.w2w.run_all() == {"FINISHED"}
    assert patches_of(body).names[-1] == "pod"
    assert len(utility_of(body.w2w).expected_mean) == N_PATCHES + 1
    assert baked(body) == 9


def test_a_removed_body_leaves_nothing_to_go_on_from(library: Path) -> None:
    body = make_study(library, "motions patches")
    kept = kept_of(body)
    bpy.data.objects.remove(body)
    assert kept() == ""


def test_signals_that_cannot_be_kept_are_said_with_the_reason(
    library: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    make_study(library, "motions patches")
    (tmp_path / "no_folder").touch()
    monkeypatch.setattr(baking, "cache_folder", lambda: tmp_path / "no_folder" / "signals")
    with pytest.raises(RuntimeError, match=r"cannot be baked: .*no_folder"):
        bpy.ops.w2w.run_all()
