# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished runs in the panel: results folders, .blend files that runs have saved, folders that moved."""

import os
from collections.abc import Generator
from functools import partial
from pathlib import Path

import bpy
from bpy.props import StringProperty

from ...core.body.body import Body
from ...core.body.regions import regions_of
from ...core.findings.listed import clips_of
from ...core.given import ForeignFileError
from ...core.study.clip_files import STORED
from ...core.study.results import StudyResults
from ...scene.base.actions import show_action, write_action
from ...scene.base.patches import place_patches
from ...scene.files.study_file import has_record, keys_of, pack
from ...scene.motion.takes import existing_data, new_data
from ..jobs import jobs
from ..results.restore import SUMMARY, fill, find_folder, opened_text, restore
from ..results.results import hide_patches
from ..steps.body import add_study, make_study
from ..study import operators, signal_cache, state
from ..study.pages import ANSWER, turn_to
from ..viewport.framing import fold_soon, frame_answer
from ..viewport.legend import show_colours

Context = bpy.types.Context


class ChoosesResults(operators.AsksForFile):
    """Asks for a results folder, or takes a dropped one at once."""

    filter_glob: StringProperty(default=SUMMARY, options={"HIDDEN"})

    def invoke(self, context: Context, event: bpy.types.Event) -> set[str]:
        if self.filepath:
            return self.execute(context)
        return super().invoke(context, event)

    @property
    def folder(self) -> Path:
        """The chosen folder."""
        chosen = self.path()
        return chosen if chosen.is_dir() else chosen.parent


class W2W_OT_open_results(ChoosesResults, operators.StartsJob, bpy.types.Operator):
    """Open the results folder of a finished run: its body, spots, clips, ranking and chosen sensors"""

    poll = classmethod(jobs.can_start)

    def steps(self, _body: bpy.types.Object | None) -> jobs.Steps:
        return open_steps(self.folder)


class W2W_OT_locate_results(ChoosesResults, operators.WorkOperator, bpy.types.Operator):
    """Choose the results folder that holds the signals of this study, after it was moved"""

    @classmethod
    def poll(cls, context: Context) -> bool:
        body = state.current_body(context)
        cls.poll_message_set("Only for signals in a results folder that is no longer where it was")
        return jobs.running is None and body is not None and misses_folder(body.w2w)

    def work(self, context: Context, body: bpy.types.Object) -> str:
        study, folder = body.w2w, self.folder
        before, study.results_folder = study.results_folder, str(folder.resolve())
        stored = [clip for clip in study.clips if clip.signals.startswith(STORED)]
        found = sum(signal_cache.has(clip) for clip in stored)
        if not found:
            study.results_folder = before
            raise ValueError(
                f"{folder} does not hold the signals of this study: choose the results folder that it was "
                "opened from or saved in"
            )
        text = f"Found the signals of {found} clips in {folder}"
        if found < len(stored):
            text += f"; those of {len(stored) - found} are not there: bake them again (page Details)"
        return text


class W2W_FH_results(operators.OnDrop, bpy.types.FileHandler):
    """The summary.json of a results folder, dropped on the 3D view, opens the folder."""

    bl_label = "Results of W2W"
    bl_import_operator = "w2w.open_results"
    bl_file_extensions = ".json"


def misses_folder(study: bpy.types.PropertyGroup) -> bool:
    """Whether a study has signals in a results folder that is missing; one look at the disk."""
    if not any(clip.signals.startswith(STORED) for clip in study.clips):
        return False
    return not study.results_folder or not (Path(study.results_folder) / SUMMARY).is_file()


def open_steps(folder: Path) -> jobs.Steps:
    """Read a results folder in a thread, then build its body, patches and actions in the scene."""

    def read(_: object) -> tuple[StudyResults, Body, dict[str, str]]:
        run = StudyResults.load(folder)
        body = run.body()
        pack(run.patches)  # kept, as the regions are: here they stop no window
        pack(run.utility)
        regions_of(body)
        return run, body, keys_of(run)

    run, body, signals = yield from jobs.in_thread(read, "reading the results", 0.0, 0.2)
    yield jobs.Step(0.2, "building the body")
    before, shown = existing_data(), bpy.context.scene.w2w.body
    try:
        mesh = add_study(bpy.context, body, folder.resolve().name)
        mesh.w2w.results_folder = str(folder.resolve())
        run.check_fits(mesh.name, len(mesh.data.vertices))
        yield jobs.Step(0.25, "placing spots")
        study, name = mesh.w2w, f"Patches: {mesh.name}"
        study.show_patches = False  # hundreds of axes need not follow while motions come in
        home = mesh.users_collection[0]
        study.patch_collection = place_patches(mesh, run.patches, name, study.patch_size, home)
        hide_patches(study)
        actions = yield from _act(mesh.parent, run, 0.3, 0.9)
        yield jobs.Step(0.9, "painting heatmaps")
        fill(mesh, run, clips_of(run, signals, actions))
        yield jobs.Step(0.95, "painting heatmaps")
        frame_answer(mesh)
        turn_to(ANSWER)
        fold_soon()
    except BaseException:
        bpy.data.batch_remove(new_data(before))
        bpy.context.scene.w2w.body = shown
        raise
    return opened_text(mesh, seen=True)


def _act(
    armature: bpy.types.Object, run: StudyResults, low: float, high: float
) -> Generator[jobs.Step, None, dict[str, bpy.types.Action | None]]:
    """Write the run's motions as actions, None for a missing one, and play the first."""
    actions: dict[str, bpy.types.Action | None] = {}
    for number, clip in enumerate(run.clips):
        begin, end = (low + (high - low) * done / len(run.clips) for done in (number, number + 1))
        try:
            work = partial(lambda name, _: run.motion(name), clip.name)
            motion = yield from jobs.in_thread(work, clip.name, begin, end)
        except ForeignFileError:
            raise
        except jobs.EXPECTED:
            actions[clip.name] = None
            continue
        actions[clip.name] = write_action(armature, motion, clip.name)
    for action in [action for action in actions.values() if action is not None][:1]:
        show_action(armature, action)
    return actions


@bpy.app.handlers.persistent
def loaded(*_: object) -> None:
    """A file was opened: make studies of the runs in it, and find the signals of its studies."""
    jobs.dismiss()  # it was of the file before
    for mesh in [item for item in bpy.data.objects if item.type == "MESH" and item.library is None]:
        if mesh.w2w.is_body:
            find_folder(mesh.w2w)
            if mesh.w2w.utility_key:  # the 3D views may be those of the file before
                show_colours()
        elif has_record(mesh):
            try:
                jobs.message = jobs.Message(restore(mesh), False)
            except ValueError as error:
                jobs.message = jobs.Message(f"The run in this file cannot be opened: {error}", True)
                continue
            context = bpy.context
            if state.current_body(context) is None and context.scene.objects.get(mesh.name) is mesh:
                make_study(context, mesh)


@bpy.app.handlers.persistent
def saving(path: str, *_: object) -> None:
    """A file is being saved: note where, seen from it, the results folders of its studies are."""
    for scene in bpy.data.scenes if path else ():
        for body in state.bodies(scene):
            if body.library is None and body.w2w.results_folder:
                try:
                    near = os.path.relpath(body.w2w.results_folder, Path(path).parent)
                except ValueError:  # on another drive of Windows
                    near = ""
                body.w2w.results_near = near
