# SPDX-License-Identifier: GPL-3.0-or-later
"""Base classes of panels: each is on a page; those of steps say what they wait for."""

from typing import TypeAlias

import bpy

from ..jobs import jobs
from ..jobs.text import draw_text, styled
from ..study.declared import SHOWN, property_of
from ..study.pages import ANSWER, CLIPS, DETAILS, shown_page
from ..study.state import current_body, is_ranked, missing_for_patches, outdated_at_a_glance, polled_body

Body = bpy.types.Object | None
Layout: TypeAlias = bpy.types.UILayout

PANELS = {
    "main": ("Where to Wear", "", "", False),
    "body": ("Body", "main", CLIPS, False),
    "motions": ("Motions", "main", CLIPS, False),
    "findings": ("One Sensor", "main", ANSWER, False),
    "placement": ("Sensors Together", "main", ANSWER, True),
    "heatmap": ("Heatmap", "main", ANSWER, True),
    "patches": ("Spots", "main", DETAILS, True),
    "own_placements": ("Your Placements", "patches", DETAILS, False),
    "garments": ("Garments (Experimental)", "patches", DETAILS, True),
    "signals": ("Signals", "main", DETAILS, False),
    "sensor": ("Sensor and Bands", "signals", DETAILS, True),
    "utility": ("Score", "main", DETAILS, False),
    "activities": ("Activities", "utility", DETAILS, True),
    "sure": ("How Sure", "main", DETAILS, True),
    "regions": ("Top Regions", "main", DETAILS, True),
    "shape": ("Shape", "main", DETAILS, True),
    "character": ("Own Character", "main", DETAILS, True),
}
"""Label of each panel, the panel that it is part of, its page ("" is every page), whether it is closed at
first; in the order in which they stand."""


class W2WPanel:
    """A panel in the tab W2W, as `PANELS` says of it."""

    layout: Layout
    page: str
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "W2W"

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        _, is_panel, name = cls.__name__.partition("W2W_PT_")
        if is_panel:
            label, home, cls.page, is_closed = PANELS[name]
            about = {"bl_label": label, "bl_order": [*PANELS].index(name)}
            about |= {"bl_parent_id": f"W2W_PT_{home}"} if home else {}
            about |= {"bl_options": {"DEFAULT_CLOSED"}} if is_closed else {}
            for key, value in about.items():
                setattr(cls, key, value)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        return cls.page in ("", shown_page()) and cls.is_wanted(current_body(context))

    @staticmethod
    def is_wanted(_body: Body) -> bool:
        """Whether there is anything to show of a body, or without one."""
        return True


class PartPanel(W2WPanel):
    """A part of a step, which needs a body."""

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None


def draw_parameters(layout: Layout, study: bpy.types.PropertyGroup, panel: str, *besides: str) -> None:
    """Draw the parameters that are declared for a part of the panel, but those that it draws itself."""
    for name, each in SHOWN.items():
        if each.panel == panel and name not in besides:
            layout.prop(study, property_of(name), slider=each.most == 1)


class ResultPanel(W2WPanel):
    """A part of the results."""

    def column(self, context: bpy.types.Context) -> Layout:
        """A column that is grey where the ranking is not of the study as it is now."""
        return styled(self.layout.column(), active=not outdated_at_a_glance(polled_body(context)))

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None and is_ranked(body)


class StepPanel(W2WPanel):
    """A step: its header shows whether it is done, its body what it needs."""

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        body = current_body(context)
        if body is not None and not self.missing(body) and self.is_done(body):
            self.layout.label(text="", icon="CHECKMARK")

    def draw(self, context: bpy.types.Context) -> None:
        body = current_body(context)
        content = styled(form(self.layout), enabled=jobs.running is None)
        missing = self.missing(body)
        if missing:
            draw_info(content, context, missing)
        else:
            self.draw_step(context, content, body)

    def missing(self, body: Body) -> str:
        """What this step still needs, as a sentence, or ""; at least a body."""
        return missing_for_patches(body)

    def is_done(self, body: bpy.types.Object) -> bool:
        """Whether the step is done on a body."""
        return False

    def draw_step(self, context: bpy.types.Context, layout: bpy.types.UILayout, body: Body) -> None:
        """Draw the step itself."""


def form(layout: bpy.types.UILayout) -> bpy.types.UILayout:
    """A column with names at the left of their values, and nothing to animate them."""
    return styled(layout.column(), use_property_split=True, use_property_decorate=False)


def draw_info(layout: bpy.types.UILayout, context: bpy.types.Context, text: str) -> None:
    """Draw a text that says what to do."""
    draw_text(layout, context, text, icon="INFO")


def draw_warning(layout: bpy.types.UILayout, context: bpy.types.Context, text: str) -> None:
    """Draw a text in a red box, or nothing for ""."""
    if text:
        draw_text(styled(layout.box(), alert=True), context, text, icon="ERROR", indent=20)


def draw_outdated(layout: bpy.types.UILayout, context: bpy.types.Context, body: bpy.types.Object) -> None:
    """Draw why a body's ranking is out of date, and the button that mends it."""
    if why := outdated_at_a_glance(body):
        draw_warning(layout, context, f"Out of date. {why}.")
        if why != missing_for_patches(body):
            layout.operator("w2w.run_all", text="Run All Again", translate=False, icon="FILE_REFRESH")


def draw_note(layout: bpy.types.UILayout, context: bpy.types.Context, text: str) -> None:
    """Draw a text in grey."""
    draw_text(styled(layout.column(), active=False), context, text)
