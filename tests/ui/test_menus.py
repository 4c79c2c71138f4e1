# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's search (F3) looks through menus: all that people can start is in one."""

from __future__ import annotations

from pathlib import Path

import bpy
import pytest

from w2w.ui.files.open_results import loaded
from w2w.ui.panels.menus import W2W_MT_study
from w2w.ui.viewport.overlay import is_coloured

from .made_study import make_study

pytestmark = pytest.mark.usefixtures("blender", "few_orders")

WITHOUT_A_MENU = {
    "run_job", "dismiss_message", "pick_patch", "click_body", "select_patch",  # the panel's or mouse's
    "add_wish", "remove_wish",  # of a row of the panel
    "import_labelled",  # follows when files have been chosen
    "tick_clips", "add_study_preset", "clear_cache",  # in menus of their own, and the preferences
}  # fmt: skip


class Seen:
    """A layout that notes what is drawn on it."""

    def __init__(self) -> None:
        self.operators: list[str] = []
        self.menus: list[str] = []
        self.operator_context = ""

    def operator(self, name: str, **_: object) -> None:
        """Note it."""
        self.operators.append(name.removeprefix("w2w."))

    def menu(self, name: str, **_: object) -> None:
        """Note it and look into it."""
        self.menus.append(name)

    def separator(self) -> None:
        """Pass."""


def drawn(menu: type) -> Seen:
    """What a menu draws."""
    seen = Seen()
    menu.draw(type("Drawn", (), {"layout": seen})(), bpy.context)
    return seen


def test_everything_that_can_be_started_is_in_the_menu() -> None:
    assert set(drawn(W2W_MT_study).operators) == set(dir(bpy.ops.w2w)) - WITHOUT_A_MENU


def test_files_are_asked_for_when_started_from_the_menu() -> None:
    assert drawn(W2W_MT_study).operator_context == "INVOKE_DEFAULT"


def test_the_menu_is_in_blenders_own() -> None:
    seen = Seen()
    for draw in bpy.types.VIEW3D_MT_object._dyn_ui_initialize()[1:]:
        draw(type("Drawn", (), {"layout": seen})(), bpy.context)
    assert "W2W_MT_study" in seen.menus


def test_names_stay_english_in_every_language() -> None:
    kinds = [getattr(bpy.types, name) for name in dir(bpy.types) if name.startswith("W2W_")]
    labelled = (bpy.types.Operator, bpy.types.Panel, bpy.types.Menu)
    assert {kind.bl_translation_context for kind in kinds if issubclass(kind, labelled)} == {"W2W"}
    study = bpy.types.PropertyGroup.bl_rna_get_subclass_py("W2W_PG_study").bl_rna.properties
    assert {study[name].translation_context for name in ("window_s", "seed", "sensor", "band")} == {"W2W"}


def test_colours_are_shown_in_all_workspaces_when_a_ranked_body_is_opened(library: Path) -> None:
    make_study(library)
    spaces = [area.spaces.active for screen in bpy.data.screens for area in screen.areas]
    solid = [space.shading for space in spaces if space.type == "VIEW_3D" and space.shading.type == "SOLID"]
    assert len(solid) > 1
    for shading in solid:
        shading.color_type = "MATERIAL"
        assert not is_coloured(shading)
    loaded()
    assert all(map(is_coloured, solid))
