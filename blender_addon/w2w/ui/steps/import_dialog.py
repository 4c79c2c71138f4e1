# SPDX-License-Identifier: GPL-3.0-or-later
"""The dialogs before an import, of files or of takes in the scene: which clips would get which label."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import bpy
from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    StringProperty,
)

from ...core.findings.notes import label_notes
from ...core.keypoints.facts import PoseFacts
from ...core.library import import_plan
from ...core.library.labels import LibraryError
from ...core.motion.sight import UPS, Up
from ...core.motion.source import HIGHEST_RATE
from ...core.motion.up import BY_ITSELF, Ups
from ...core.reading.look import look_up
from ...core.reading.reader import Reader
from ...core.wording import cut
from ...scene.motion.scene_takes import SceneTake, SkippedTake, scene_takes, stands_beside
from ..jobs import jobs
from ..jobs.text import styled
from ..study import operators, state
from .body import body_to_fill
from .motion_import import ImportItem, import_items, import_steps, listed_files

ROWS = 10
"""Activities and files left out on a page of the dialog: as many as fit into 800 pixels at a scale of 2."""

LONGEST = 64
"""Characters of a row, or it would widen the dialog beyond the window."""

WIDTH = 460
"""Pixels of a dialog at a scale of 1."""

FILES_LABELLED_BY = (
    (import_plan.AUTOMATIC, "Automatic", "By labels.csv in the folder, else its folders, else file names"),
    (import_plan.BY_FOLDER, "Folder", "By the folder that each file lies in"),
    (import_plan.BY_FILE, "File Name", "By file names, without a prefix up to @ or a number in brackets"),
    (import_plan.BY_CSV, "CSV", "By a csv file with the columns file and activity"),
)

UP_AXES = (
    (
        import_plan.AUTOMATIC,
        "Automatic",
        "By the format, the rest pose, or how people stand in all of the files",
    ),
    *((up, up.upper(), f"The files' own {up} axis points up") for up in UPS),
)

ALL = "*"
"""Every armature."""

BY_ACTION, ONE = "ACTION", "ONE"

TAKES_LABELLED_BY = (
    (BY_ACTION, "Action Name", "By the name of each action or strip, where that says anything"),
    (ONE, "One for All", "The same activity for all of them"),
)


_items: list[tuple[str, str, str]] = []
"""Blender keeps no reference to the strings of a dynamic enum: this does."""


class ImportList(NamedTuple):
    """Motions that can be imported, those in the list already, and those left out."""

    items: Sequence[ImportItem] = ()
    activities: Mapping[str, Sequence[str]] = {}
    known: Sequence[str] = ()
    left_out: Sequence[tuple[str, str]] = ()
    notes: Sequence[str] = ()
    error: str = ""
    ups: Ups = BY_ITSELF


class ImportDialog(operators.OnBody):
    """A dialog that shows which clips would get which label, then imports them."""

    bl_options = {"REGISTER"}
    adds_body = True
    kind = "files"
    nothing = ""
    """Error if there is nothing at all to import."""

    again: BoolProperty(
        name="Take Again",
        description="Import motions, too, that are in the list already. One motion twice flatters a ranking: "
        "it is tested on what it was trained on",
        options={"SKIP_SAVE"},
    )

    page: IntProperty(name="Page", description="Page of the list below", min=1, options={"SKIP_SAVE"})

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self, width=WIDTH)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        self.draw_settings(layout)
        found = self.found(context)
        if found.error:
            layout.label(text=found.error, icon="ERROR", translate=False)
            return
        if found.known or self.again:
            layout.prop(self, "again")
        known = [(name, "it is in the list already") for name in found.known]
        left_out = [*known, *found.left_out]
        pages = -(-(len(found.activities) + len(left_out)) // ROWS)
        if pages > 1:
            layout.prop(self, "page", text=f"Page of {pages}")
        draw_preview(layout, found.activities, left_out, found.notes, min(self.page, pages))

    def execute(self, context: bpy.types.Context) -> set[str]:
        found = self.found(context)
        known = f"All of these {self.kind} are in the list already" if found.known else ""
        error = known or found.error or self.nothing
        if error and not found.items:
            return jobs.show_error(self, error)
        steps = import_steps(body_to_fill(context), found.items, found.left_out, found.ups)
        return jobs.start(self, context, "Import Motions", steps)


class W2W_OT_import_labelled(ImportDialog, bpy.types.Operator):
    """Import motion files with labels by folder, file name or csv, after a look at what they would be"""

    bl_label = "Import Motions"

    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    labelled_by: EnumProperty(name="Label By", description="What labels the clips", items=FILES_LABELLED_BY)
    csv: StringProperty(
        name="CSV File",
        description="File with the columns file and activity, and if wanted subject and rate; labels.csv "
        "in the folder by default",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    frame_rate: FloatProperty(
        name="Frame Rate",
        description="Frames per second of these files, whatever they say themselves; 0 leaves each its own",
        min=0.0,
        max=HIGHEST_RATE,
        precision=2,
        options={"SKIP_SAVE"},
    )
    up: EnumProperty(
        name="Up", description="Axis of the files that points up", items=UP_AXES, options={"SKIP_SAVE"}
    )
    planned: tuple[object, ImportList] | None = None
    """The settings looked at last and what was found; a dialog opened again reads the folder anew."""

    def draw_settings(self, layout: bpy.types.UILayout) -> None:
        layout.row().prop(self, "labelled_by", expand=True)
        if self.labelled_by == import_plan.BY_CSV:
            layout.prop(self, "csv")
        layout.prop(self, "frame_rate")
        layout.prop(self, "up")

    @property
    def given_up(self) -> Up | None:
        """The axis that the user says is up in the files."""
        return None if self.up == import_plan.AUTOMATIC else self.up

    def found(self, context: bpy.types.Context) -> ImportList:
        """The files to import as it is set; looked at anew only when that changes, for it is drawn often."""
        names = tuple(file.name for file in self.files if file.name)
        body = state.current_body(context)
        listed = () if body is None else tuple(listed_files(body))
        files = (self.directory, names, listed)
        settings = (*files, self.labelled_by, self.csv, self.frame_rate, self.up, self.again)
        if self.planned is None or self.planned[0] != settings:
            self.planned = settings, self.look(names, listed)
        return self.planned[1]

    def look(self, names: tuple[str, ...], listed: tuple[Path, ...]) -> ImportList:
        """Read the files' names and labels; `listed` are the files that the list has already."""
        folder, by = Path(self.directory), self.labelled_by
        table = Path(bpy.path.abspath(self.csv)) if self.csv else None
        try:
            if names:
                plan = import_plan.plan_files([folder / name for name in names], by, table)
            else:
                plan = import_plan.plan_folder(folder, by, table)
        except LibraryError as error:
            return ImportList(error=str(error))
        if not self.again:
            plan = import_plan.without_known(plan, listed)
        files = ((clip.file, clip.path) for clip in plan.clips)
        with Reader() as reader:
            seen = look_up(reader, files, PoseFacts(self.frame_rate or None, up=self.given_up))
        if seen.question:
            return ImportList(error=seen.question)
        notes = list(label_notes(plan.check))
        notes += [f"Up: {up}"] if (up := seen.sentence()) else []
        notes += [plan.unread] if plan.unread else []
        items = import_items(plan, self.frame_rate, self.given_up)
        return ImportList(items, plan.activities, plan.known, plan.left_out, notes, ups=seen.ups)


def source_armatures(scene: bpy.types.Scene) -> list[bpy.types.Object]:
    """The armatures of a scene that are the user's own."""
    ours = {body.find_armature() for body in state.bodies(scene)}
    armatures = [item for item in scene.objects if item.type == "ARMATURE" and item not in ours]
    return [item for item in armatures if not stands_beside(item)]


def _armatures(_self: W2W_OT_use_scene_animation, context: bpy.types.Context) -> list[tuple[str, str, str]]:
    found = source_armatures((context or bpy.context).scene)
    _items[:] = [(item.name, item.name, f"The actions of '{item.name}'") for item in found]
    _items.append((ALL, "All Armatures", "The actions of every armature that is not a body's of W2W"))
    return _items


class W2W_OT_use_scene_animation(ImportDialog, bpy.types.Operator):
    """Take all actions and NLA strips of an armature in the scene as clips; the armature is only read"""

    adds_body = False
    kind, nothing = "actions", "There is no action that moves bones"

    armature: EnumProperty(
        name="Armature", description="Whose actions and NLA strips become clips", items=_armatures
    )
    labelled_by: EnumProperty(name="Label By", description="What labels the clips", items=TAKES_LABELLED_BY)
    activity: StringProperty(name="Activity", description="What all of them show")

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        found = source_armatures(context.scene)
        return "" if found else "There is no armature in the scene but W2W's own"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        found = [item for item in source_armatures(context.scene) if self.takes(item)[0]]
        if not found:
            return jobs.show_error(self, "No armature of the scene has an action or strip that moves bones")
        self.armature = (context.object if context.object in found else found[0]).name
        return super().invoke(context, event)

    def draw_settings(self, layout: bpy.types.UILayout) -> None:
        layout.prop(self, "armature")
        layout.row().prop(self, "labelled_by", expand=True)
        if self.labelled_by == ONE:
            layout.prop(self, "activity")

    def found(self, context: bpy.types.Context) -> ImportList:
        """Takes to import, takes in the list already, and takes left out."""
        listed = {clip.taken_from for clip in state.polled_body(context).w2w.clips}
        items, known, left_out = [], [], []
        for armature in source_armatures(context.scene):
            if self.armature not in (ALL, armature.name):
                continue
            takes, others = self.takes(armature)
            left_out += others if self.armature != ALL else []  # they are another one's, which is there
            for take in takes:
                activity = import_plan.activity_of_action(take.name, armature.name)
                if self.labelled_by == ONE:
                    activity = self.activity.strip()
                item = ImportItem(Path(), "", take.name, activity, take=take)
                if item.taken_from in listed and not self.again:
                    known.append(take.name)
                else:
                    items.append(item)
        activities = import_plan.by_activity((item.activity, item.name) for item in items)
        return ImportList(items, activities, known, left_out)

    def takes(self, armature: bpy.types.Object) -> tuple[list[SceneTake], list[SkippedTake]]:
        """The takes of an armature; looked for once, for the dialog is drawn often."""
        if not hasattr(self, "_takes"):
            self._takes: dict[str, tuple[list[SceneTake], list[SkippedTake]]] = {}
        if armature.name not in self._takes:
            self._takes[armature.name] = scene_takes(armature)
        return self._takes[armature.name]


def draw_preview(
    layout: bpy.types.UILayout,
    activities: Mapping[str, Sequence[str]],
    left_out: Sequence[tuple[str, str]],
    notes: Sequence[str] = (),
    page: int = 1,
) -> None:
    """Draw a page of what would be imported as which activity, and of what is left out and why."""
    title, rows = import_plan.preview(activities, left_out)
    layout.label(text=title, translate=False)
    box = layout.box().column(align=True)
    for name, about, kind in rows[ROWS * max(page - 1, 0) :][:ROWS]:
        if kind == import_plan.LEFT_OUT:
            box.label(text=cut(f"{name}: {about}", LONGEST), icon="X", translate=False)
            continue
        split, icon = box.split(factor=0.35), "ERROR" if kind == import_plan.UNLABELLED else "NONE"
        split.label(text=cut(name, LONGEST), icon=icon, translate=False)
        styled(split.row(), active=False).label(text=cut(about, LONGEST), translate=False)
    for note in notes:
        layout.label(text=cut(note, LONGEST), icon="INFO", translate=False)
