# SPDX-License-Identifier: GPL-3.0-or-later
"""Open Results: what `w2w run` left in a folder, in the open scene, as if it had been computed here."""

from __future__ import annotations

from collections.abc import Callable, Generator
from pathlib import Path

import bpy
from bpy.props import StringProperty

from ..core.body.body import Body
from ..core.motion.motion import Motion
from ..core.patches.patches import PatchSet
from ..core.results_folder import StudyResults
from ..scene.actions import show_action, write_action
from ..scene.packing import pack
from ..scene.patches import place_patches
from ..scene.study_record import keys_of
from ..scene.takes import existing_data, new_data
from . import jobs
from .jobs import EXPECTED, Step, Steps, in_thread
from .restore import SUMMARY, check_fits, clips_of, fill, opened_text
from .results import hide_patches
from .step1_body import add_study

TITLE = "Open Results"


class W2W_OT_open_results(bpy.types.Operator):
    """Open the results folder of a finished run: its body, patches, clips, ranking and chosen sensors"""

    bl_idname = "w2w.open_results"
    bl_label = TITLE
    bl_options = {"REGISTER"}

    filepath: StringProperty(
        name="Results",
        description="A results folder, or the summary.json in it",
        subtype="FILE_PATH",
        options={"SKIP_SAVE"},
    )
    filter_glob: StringProperty(default=SUMMARY, options={"HIDDEN"})

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """Bones can be made only from object mode, and one job runs at a time."""
        return jobs.can_start(cls, context)

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Take a dropped file at once; ask for one otherwise."""
        if self.filepath:
            return self.execute(context)
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Start the work."""
        chosen = Path(bpy.path.abspath(self.filepath))
        folder = chosen if chosen.is_dir() else chosen.parent
        return jobs.start(self, context, TITLE, open_steps(folder))


class W2W_FH_results(bpy.types.FileHandler):
    """The summary.json of a results folder, dropped on the 3D view, opens the folder."""

    bl_idname = "W2W_FH_results"
    bl_label = "Results of W2W"
    bl_import_operator = "w2w.open_results"
    bl_file_extensions = ".json"

    @classmethod
    def poll_drop(cls, context: bpy.types.Context) -> bool:
        """Only 3D views take them."""
        return context.area is not None and context.area.type == "VIEW_3D"


def open_steps(folder: Path) -> Steps:
    """Read a results folder in a thread, then build its body, patches and actions in the scene."""
    run, body, signals = yield from in_thread(lambda _told: _read(folder), "reading the results", 0.0, 0.2)
    yield Step(0.2, "building the body")
    before, shown = existing_data(), bpy.context.scene.w2w.body
    finished = False
    try:
        mesh = add_study(bpy.context, body, body.name)
        mesh.w2w.results_folder = str(folder.resolve())
        check_fits(mesh, run)
        yield Step(0.25, "placing patches")
        _place(mesh, run.patches)
        actions = yield from _act(mesh.parent, run, 0.3, 0.9)
        yield Step(0.9, "painting heatmaps")
        fill(mesh, run, clips_of(run, signals, actions))
        finished = True
    finally:
        if not finished:
            bpy.data.batch_remove(new_data(before))
            bpy.context.scene.w2w.body = shown
    return opened_text(mesh)


def _read(folder: Path) -> tuple[StudyResults, Body, dict[str, str]]:
    """A run, its body, and the keys of its signals."""
    run = StudyResults.load(folder)
    pack(run.patches)  # here it stops no window
    pack(run.utility)
    return run, run.body(), keys_of(run)


def _place(mesh: bpy.types.Object, patches: PatchSet) -> None:
    study, home = mesh.w2w, mesh.users_collection[0]
    study.show_patches = False  # hundreds of axes need not follow while motions come in
    study.patch_collection = place_patches(mesh, patches, f"Patches: {mesh.name}", study.patch_size, home)
    hide_patches(study)


def _act(
    armature: bpy.types.Object, study: StudyResults, low: float, high: float
) -> Generator[Step, None, dict[str, bpy.types.Action]]:
    """Write the run's motions as actions, and play the first; a motion that is gone has none."""
    actions = {}
    for number, clip in enumerate(study.clips):
        begin, end = (low + (high - low) * done / len(study.clips) for done in (number, number + 1))
        try:
            motion = yield from in_thread(_reader(study, clip.name), clip.name, begin, end)
        except EXPECTED:
            continue
        actions[clip.name] = write_action(armature, motion, clip.name)
    for action in [*actions.values()][:1]:
        show_action(armature, action)
    return actions


def _reader(study: StudyResults, clip: str) -> Callable[[Callable[[float], None]], Motion]:
    return lambda _told: study.motion(clip)


def _import_menu(self: bpy.types.Menu, _context: bpy.types.Context) -> None:
    self.layout.operator("w2w.open_results", text=f"Results of W2W ({SUMMARY})")


CLASSES = (W2W_OT_open_results, W2W_FH_results)


def register() -> None:
    """Register the operator and its places in File > Import and among what can be dropped."""
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.TOPBAR_MT_file_import.append(_import_menu)


def unregister() -> None:
    """Take back what `register` did."""
    bpy.types.TOPBAR_MT_file_import.remove(_import_menu)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
