# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel draws itself, at each stage of a study."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest

from w2w import ui
from w2w.ui.jobs import text
from w2w.ui.panels import steps
from w2w.ui.panels.steps import FIELD_MARGINS
from w2w.ui.study.state import patches_of

from .made_study import ALL_STEPS, make_study

pytestmark = pytest.mark.usefixtures("blender")

PANELS = [
    cls
    for module in ui.MODULES
    for cls in vars(module).values()
    if isinstance(cls, type) and issubclass(cls, bpy.types.Panel) and cls.__module__ == module.__name__
]


def draw(panel: type, context: SimpleNamespace) -> MagicMock | None:
    """A layout that takes everything, with a panel drawn on it; None if the panel is not shown."""
    if not getattr(panel, "poll", lambda _: True)(context):
        return None
    drawn = SimpleNamespace(layout=MagicMock(), titles=panel.titles)
    for name in ("missing", "is_done", "draw_step", "draw_active", "column"):
        if hasattr(panel, name):
            setattr(drawn, name, getattr(panel, name).__get__(drawn))
    if hasattr(panel, "draw_header_preset"):
        panel.draw_header_preset(drawn, context)
    panel.draw(drawn, context)
    return drawn.layout


def view_of_panels() -> SimpleNamespace:
    """What panels see."""
    names = ("scene", "object", "mode", "view_layer", "selected_objects", "preferences", "screen")
    region = SimpleNamespace(width=300)
    return SimpleNamespace(region=region, **{name: getattr(bpy.context, name) for name in names})


@pytest.mark.parametrize("stage", ["", "motions", "motions patches", ALL_STEPS])
def test_every_panel_draws_itself(library: Path, stage: str) -> None:
    body = make_study(library, stage)
    study = body.w2w
    if stage == ALL_STEPS:
        assert bpy.ops.w2w.side_by_side() == {"FINISHED"}
        study.own.add().name = "pod"
        study.picked = int(patches_of(body).labels[0])
        bpy.ops.w2w.add_wish(kind="COST", place="left wrist")
        study.max_places = 2
        assert bpy.ops.w2w.choose_sensors() == {"FINISHED"}
        study.fix_range, study.limit_places = True, True
        bpy.ops.w2w.add_garment(kind="tshirt")
        bpy.ops.w2w.start_sensor(like="phone")
        study.record = {"magnetometer"}
    context = view_of_panels()
    shown = {panel.__name__ for panel in PANELS if draw(panel, context) is not None}
    assert len(shown) >= (len(PANELS) - 1 if stage == ALL_STEPS else 6)


@pytest.mark.parametrize(
    ("name", "shown"), [("walk_001", "walk_001"), ("dataset-1_bow_active_001", "dat…ve_001"), ("", "")]
)
def test_names_that_are_too_wide_lose_their_middle(
    monkeypatch: pytest.MonkeyPatch, name: str, shown: str
) -> None:
    monkeypatch.setattr(text.blf, "dimensions", lambda _font, words: (len(words), 1))
    assert text.shortened(name, 10) == shown


@pytest.mark.parametrize(
    ("longest", "share"), [("bow", 0.3), ("load_carrying", (13 + FIELD_MARGINS) / 70), ("a" * 60, 0.6)]
)
def test_a_row_of_clips_leaves_the_longest_activity_room(
    monkeypatch: pytest.MonkeyPatch, longest: str, share: float
) -> None:
    monkeypatch.setattr(steps, "width_of", lambda words, _: len(words))
    study = SimpleNamespace(activities=[SimpleNamespace(name="run"), SimpleNamespace(name=longest)])
    assert steps.activity_share(study, 70, 1.0) == pytest.approx(share)
