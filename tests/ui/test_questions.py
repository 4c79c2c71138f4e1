# SPDX-License-Identifier: GPL-3.0-or-later
"""Buttons answer on the cards of the panel what the commands need and pilot answer."""

from pathlib import Path

import bpy
import pytest

from w2w.core.findings.advice_content import need_content
from w2w.core.findings.pilot import of_folder
from w2w.core.study.choosing import find_needs
from w2w.core.study.results import StudyResults
from w2w.ui.panels.placement import W2W_PT_placement
from w2w.ui.study.lists import advice_of

from ..phone_exports import worn_like_clips
from .made_study import make_study
from .test_outdated import buttons, words
from .test_panels import draw, view_of_panels

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("blender", "few_orders")]


def test_the_card_says_what_the_command_says(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    assert not bpy.ops.w2w.find_needs.poll()
    body.w2w.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert "w2w.find_needs" in buttons(draw(W2W_PT_placement, view_of_panels()))
    before = advice_of(body.w2w)
    assert bpy.ops.w2w.find_needs() == {"FINISHED"}
    cards = advice_of(body.w2w)["cards"]
    assert [{**card, "needs": None} for card in cards] == [
        {**card, "needs": None} for card in before["cards"]
    ]
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    found = [need_content(one) for one in find_needs(StudyResults.load(tmp_path / "saved"))]
    assert [card["needs"] for card in cards] == found
    assert StudyResults.load(tmp_path / "saved").cards == cards
    body.w2w.worn[0].is_open = True
    (need,) = (card["needs"] for card in cards if card["patch"] == body.w2w.worn[0].patch)
    assert need["sentence"] in words(draw(W2W_PT_placement, view_of_panels()))


def test_the_panel_says_of_a_pilot_what_the_command_says(library: Path, tmp_path: Path) -> None:
    body = make_study(library)
    assert not bpy.ops.w2w.add_pilot.poll()
    body.w2w.max_places = 1
    assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "saved")) == {"FINISHED"}
    study = StudyResults.load(tmp_path / "saved")
    worn_like_clips(study, tmp_path / "worn", 0)
    (tmp_path / "worn" / "Ada" / "notes.txt").write_text("nothing")
    place = study.patches.names[0]
    with pytest.raises(RuntimeError, match="two people"):
        bpy.ops.w2w.add_pilot(directory=str(tmp_path / "worn" / "Ada"), at=place)
    assert bpy.ops.w2w.add_pilot(directory=str(tmp_path / "worn"), at=place) == {"FINISHED"}
    found = (advice_of(body.w2w) or {})["pilot"]
    assert found == of_folder(study, tmp_path / "worn", place).content()
    drawn = draw(W2W_PT_placement, view_of_panels())
    assert "w2w.add_pilot" in buttons(drawn)
    assert found["sentence"] in words(drawn)
    assert f"Left out: {': '.join(found['skipped'][0])}" in words(drawn)

    assert bpy.ops.w2w.save_results(directory=str(tmp_path / "both")) == {"FINISHED"}
    saved = StudyResults.load(tmp_path / "both")
    assert saved.summary["pilot"] == found
    again = of_folder(saved, tmp_path / "worn", place).content()
    assert {name: again[name] for name in ("without", "worn")} == {
        name: found[name] for name in ("without", "worn")
    }
    bpy.ops.wm.read_homefile(use_empty=True)
    assert bpy.ops.w2w.open_results(filepath=str(tmp_path / "both")) == {"FINISHED"}
    assert (advice_of(bpy.context.scene.w2w.body.w2w) or {})["pilot"] == found
    assert found["sentence"] in words(draw(W2W_PT_placement, view_of_panels()))
