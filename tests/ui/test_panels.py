# SPDX-License-Identifier: GPL-3.0-or-later
"""Every panel draws itself, at each stage of a study."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

import bpy
import pytest

from w2w import ui
from w2w.ui.jobs import jobs
from w2w.ui.panels import steps
from w2w.ui.panels.steps import FIELD_MARGINS
from w2w.ui.panels.top import W2W_PT_main
from w2w.ui.study import lists
from w2w.ui.study.pages import PAGES, shown_page, turn_to
from w2w.ui.study.state import patches_of

from .made_study import ALL_STEPS, make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

PANELS = [
    cls
    for module in ui.MODULES
    for cls in vars(module).values()
    if isinstance(cls, type) and issubclass(cls, bpy.types.Panel) and cls.__module__ == module.__name__
]


def draw(panel: type, context: SimpleNamespace) -> MagicMock | None:
    """A layout that takes everything, with a panel drawn on it, on its page; None if it is not shown."""
    turn_to(panel.page or shown_page())
    if not getattr(panel, "poll", lambda _: True)(context):
        return None
    drawn = SimpleNamespace(layout=MagicMock())
    for name in ("missing", "is_done", "draw_step", "draw_active", "column"):
        if hasattr(panel, name):
            setattr(drawn, name, getattr(panel, name).__get__(drawn))
    if hasattr(panel, "draw_header_preset"):
        panel.draw_header_preset(drawn, context)
    panel.draw(drawn, context)
    return drawn.layout


def view_of_panels() -> SimpleNamespace:
    """What panels see."""
    names = (
        "scene",
        "window_manager",
        "object",
        "mode",
        "view_layer",
        "selected_objects",
        "preferences",
        "screen",
    )
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


def test_a_panel_is_on_one_page_alone_and_each_page_has_its_own(library: Path) -> None:
    make_study(library)
    context = view_of_panels()
    shown = {}
    for page, *_ in PAGES:
        turn_to(page)
        shown[page] = {panel.__name__ for panel in PANELS if panel.poll(context)}
    assert {"W2W_PT_body", "W2W_PT_motions"} <= shown["CLIPS"]
    assert {"W2W_PT_findings", "W2W_PT_placement", "W2W_PT_heatmap"} <= shown["ANSWER"]
    assert {"W2W_PT_patches", "W2W_PT_signals", "W2W_PT_utility", "W2W_PT_sure"} <= shown["DETAILS"]
    everywhere = set.intersection(*shown.values())
    assert everywhere == {"W2W_PT_main"}
    assert sum(len(names - everywhere) for names in shown.values()) == len(
        set().union(*shown.values()) - everywhere
    )


def test_an_empty_tab_says_what_w2w_does_and_how_to_begin() -> None:
    drawn = draw(W2W_PT_main, view_of_panels())
    started = [call.args[0] for call in drawn.mock_calls if call[0].endswith("operator")]
    assert started == ["w2w.try_examples", "w2w.import_folder"]


def test_clips_that_come_first_bring_a_body(library: Path) -> None:
    assert bpy.ops.w2w.import_folder(directory=str(library)) == {"FINISHED"}
    assert len(bpy.context.scene.w2w.body.w2w.clips) > 0


@pytest.mark.slow
def test_the_example_motions_give_an_answer_at_once() -> None:
    assert bpy.ops.w2w.try_examples() == {"FINISHED"}
    study = bpy.context.scene.w2w.body.w2w
    assert len(study.clips) == 40
    assert lists.answer_of(study)["patch"] is not None
    assert shown_page() == "ANSWER"
    assert not bpy.ops.w2w.try_examples.poll()


@pytest.mark.parametrize(
    ("longest", "wide"),
    [("bow", 3 + FIELD_MARGINS), ("load_carrying", 13 + FIELD_MARGINS), ("a" * 60, 42)],
)
def test_a_row_of_clips_leaves_the_longest_activity_room(
    monkeypatch: pytest.MonkeyPatch, longest: str, wide: float
) -> None:
    monkeypatch.setattr(steps, "in_panel", len)
    study = SimpleNamespace(activities=[SimpleNamespace(name="run"), SimpleNamespace(name=longest)])
    assert steps.activity_share(study, 70, 1.0) == pytest.approx(wide / 70)


def test_files_that_cannot_be_used_stand_below_the_others() -> None:
    rows = SimpleNamespace(filter_name="", bitflag_filter_item=1 << 30)
    data = SimpleNamespace(clips=[SimpleNamespace(problem=why) for why in ("damaged", "", "empty", "")])
    assert steps.W2W_UL_clips.filter_items(rows, bpy.context, data, "clips") == ([], [2, 0, 3, 1])


def test_what_is_baked_is_named_by_what_is_ticked(library: Path) -> None:
    body = make_study(library, "motions patches")
    for ticked, button in ((0, "Bake This Clip"), (2, "Bake Ticked (2)")):
        for clip in body.w2w.clips[:ticked]:
            clip.selected = True
        layout = draw(steps.W2W_PT_signals, view_of_panels())
        assert button in str(layout.mock_calls)


def test_what_was_done_is_said_in_its_own_scene(library: Path) -> None:
    make_study(library, "motions")
    jobs.show_done(SimpleNamespace(report=lambda *_: None), "Done: all of it")
    assert "Done" in str(draw(W2W_PT_main, view_of_panels()).mock_calls)
    bpy.context.window.scene = bpy.data.scenes.new("Other")
    assert "Done" not in str(draw(W2W_PT_main, view_of_panels()).mock_calls)
