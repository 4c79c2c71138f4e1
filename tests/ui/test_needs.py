# SPDX-License-Identifier: GPL-3.0-or-later
"""A button says on the cards of the panel how cheap the recommended sensors may be."""

from pathlib import Path

import bpy
import pytest

from w2w.core.findings.advice_content import need_content
from w2w.core.study.choosing import find_needs
from w2w.core.study.results import StudyResults
from w2w.ui.panels.placement import W2W_PT_placement
from w2w.ui.study.lists import advice_of

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
