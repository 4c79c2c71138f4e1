# SPDX-License-Identifier: GPL-3.0-or-later
"""The dialog between choosing files and importing them: what labels the clips, seen before it is done."""

from __future__ import annotations

from pathlib import Path

import bpy
from bpy.props import BoolProperty, CollectionProperty, EnumProperty, StringProperty

from ..core.findings.label_notes import label_notes
from ..core.motion.import_plan import (
    AUTOMATIC,
    BY_CSV,
    BY_FILE,
    BY_FOLDER,
    ImportPlan,
    plan_files,
    plan_folder,
    without_known,
)
from ..core.motion.library import LibraryError
from . import jobs
from .label_options import WIDTH, draw_preview
from .motion_import import import_steps, listed_files, wanted
from .operators import OnBody
from .state import current_body

LABELLED_BY = (
    (AUTOMATIC, "Automatic", "By labels.csv in the folder, else the folders in it, else file names"),
    (BY_FOLDER, "Folder", "By the folder that each file lies in"),
    (
        BY_FILE,
        "File Name",
        "By the name of each file, without what stands before an @ and a number in brackets",
    ),
    (BY_CSV, "CSV", "By a csv file with the columns file and activity"),
)


class W2W_OT_import_labelled(OnBody, bpy.types.Operator):
    """Import motion files with labels by folder, file name or csv, after a look at what they would be"""

    bl_idname = "w2w.import_labelled"
    bl_label = "Import Motions"
    bl_options = {"REGISTER"}

    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    labelled_by: EnumProperty(name="Label By", description="What labels the clips", items=LABELLED_BY)
    csv: StringProperty(
        name="CSV File",
        description="File with the columns file and activity, and if wanted subject; labels.csv in the "
        "folder by default",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    again: BoolProperty(
        name="Take Files Again",
        description="Import files, too, that are in the list already. One motion twice flatters a ranking: "
        "it is tested on what it was trained on",
        options={"SKIP_SAVE"},
    )
    planned: tuple[object, ImportPlan | LibraryError] | None = None
    """The plan made last, and for which settings; another opening of the dialog reads the folder anew."""

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        return context.window_manager.invoke_props_dialog(self, width=WIDTH)

    def draw(self, context: bpy.types.Context) -> None:
        layout = self.layout
        layout.row().prop(self, "labelled_by", expand=True)
        if self.labelled_by == BY_CSV:
            layout.prop(self, "csv")
        try:
            plan = self.plan(context)
        except LibraryError as error:
            layout.label(text=str(error), icon="ERROR", translate=False)
            return
        if plan.known or self.again:
            layout.prop(self, "again")
        known = [(name, "it is in the list already") for name in plan.known]
        draw_preview(layout, plan.activities, [*known, *plan.left_out], label_notes(plan.check))

    def execute(self, context: bpy.types.Context) -> set[str]:
        try:
            plan = self.plan(context)
        except LibraryError as error:
            return jobs.show_error(self, str(error))
        if not plan.clips and plan.known:
            return jobs.show_error(self, "All of these files are in the list already")
        steps = import_steps(current_body(context), wanted(plan), plan.left_out)
        return jobs.start(self, context, "Import Motions", steps)

    def plan(self, context: bpy.types.Context) -> ImportPlan:
        """What the import would do as it is set; made anew only when that changes, for it is drawn often."""
        names = tuple(file.name for file in self.files if file.name)
        listed = tuple(listed_files(current_body(context)))
        settings = (self.directory, names, self.labelled_by, self.csv, self.again, listed)
        if self.planned is None or self.planned[0] != settings:
            self.planned = settings, _plan(*settings)
        if isinstance(self.planned[1], LibraryError):
            raise self.planned[1]
        return self.planned[1]


def _plan(
    directory: str, names: tuple[str, ...], by: str, csv: str, again: bool, listed: tuple[Path, ...]
) -> ImportPlan | LibraryError:
    folder, table = Path(directory), Path(bpy.path.abspath(csv)) if csv else None
    try:
        plan = (
            plan_files([folder / name for name in names], by, table)
            if names
            else plan_folder(folder, by, table)
        )
    except LibraryError as error:
        return error
    return plan if again else without_known(plan, listed)


CLASSES = (W2W_OT_import_labelled,)
