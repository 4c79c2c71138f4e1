# SPDX-License-Identifier: GPL-3.0-or-later
"""Fill the list of motions, label them, play them on the body."""

from pathlib import Path

import bpy
from bpy.props import CollectionProperty, EnumProperty, IntProperty, StringProperty

from ...core.keypoints.facts import PoseFacts
from ...core.library.import_plan import ImportPlan, plan_files, plan_folder
from ...core.library.labels import LibraryError
from ...core.motion.source import UnusableMotion
from ...core.reading.formats import MOTION_SUFFIXES
from ...core.wording import restated
from ...scene.base.actions import FIRST_FRAME, keep_pace, key_rate, show_action
from ...scene.base.body import armature_of
from ...scene.motion import source_beside
from ..jobs import jobs
from ..study import lists, operators, state
from ..viewport.framing import go_with
from .body import body_to_fill
from .motion_import import import_items, import_steps, remove_clips


class _Import(operators.AsksForFile, operators.OnBody):
    """Import motions from a script at once; else show first how several would be labelled."""

    bl_options = {"REGISTER"}
    adds_body = True
    asked = False
    """Whether their labels are shown first."""

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        self.asked = len(self.names()) != 1
        if self.names():  # dropped on the view: a single file says what it is
            return self.execute(context)
        return super().invoke(context, event)

    def execute(self, context: bpy.types.Context) -> set[str]:
        if self.asked:
            files = [{"name": name} for name in self.names()]
            bpy.ops.w2w.import_labelled("INVOKE_DEFAULT", directory=self.directory, files=files)
            return {"FINISHED"}
        try:
            plan = self.plan(Path(self.directory))
        except LibraryError as error:
            return jobs.show_error(self, str(error))
        steps = import_steps(body_to_fill(context), import_items(plan), plan.left_out)
        return jobs.start(self, context, "Import Motions", steps)

    def names(self) -> list[str]:
        """Names of the chosen files; [] if a folder is imported."""
        return []


class W2W_OT_import_motions(_Import, bpy.types.Operator):
    """Import motion files (FBX, BVH, AMASS npz, smpl) onto the body; the files' own armatures are left out"""

    bl_label = "Import Motions onto Body"

    directory: StringProperty(subtype="DIR_PATH", options={"HIDDEN", "SKIP_SAVE"})
    files: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    filter_glob: StringProperty(
        default=";".join(f"*{suffix}" for suffix in MOTION_SUFFIXES), options={"HIDDEN"}
    )

    def names(self) -> list[str]:
        return [file.name for file in self.files if file.name]

    def plan(self, folder: Path) -> ImportPlan:
        return plan_files(folder / name for name in self.names())


class W2W_OT_import_folder(_Import, operators.AsksForFolder, bpy.types.Operator):
    """Import all motion files of a folder; a labels.csv, the folders in it or file names label them"""

    dirs: CollectionProperty(type=bpy.types.OperatorFileListElement, options={"HIDDEN", "SKIP_SAVE"})
    plan = staticmethod(plan_folder)

    def execute(self, context: bpy.types.Context) -> set[str]:
        clicked = [folder.name for folder in self.dirs]
        if len(clicked) == 1:  # once: the file browser shows what it lies in
            self.directory = str(Path(self.directory, clicked[0]))
        return super().execute(context)


class W2W_OT_preview_clip(operators.WorkOperator, bpy.types.Operator):
    """Play this clip on the body; press again, or Esc, to stop"""

    index: IntProperty(name="Clip", description="Number of the clip in the list", default=-1)

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        cls.poll_message_set("Import motions first")
        body = state.current_body(context)
        return body is not None and len(body.w2w.clips) > 0

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        """Play or stop it; a script's call only shows it."""
        body = state.polled_body(context)
        if self.index in (-1, body.w2w.clip_index) and is_playing(context, body):
            bpy.ops.screen.animation_cancel(restore_frame=False)
            return {"FINISHED"}
        shown = self.execute(context)
        if shown == {"FINISHED"} and not context.screen.is_animation_playing:
            bpy.ops.screen.animation_play()
        return shown

    def work(self, context: bpy.types.Context, mesh: bpy.types.Object) -> None:
        if self.index >= 0:
            mesh.w2w.clip_index = min(self.index, len(mesh.w2w.clips) - 1)
        show_clip(context.scene, mesh)


def is_playing(context: bpy.types.Context, mesh: bpy.types.Object) -> bool:
    """Whether the body plays its active clip now."""
    study = mesh.w2w
    is_shown = state.playing_clip(mesh) == study.clips[study.clip_index]
    return is_shown and context.screen is not None and context.screen.is_animation_playing


def show_clip(scene: bpy.types.Scene, mesh: bpy.types.Object) -> None:
    """Give the body its active clip, at its speed over the preview range; the scene's own is left alone."""
    clip = mesh.w2w.clips[mesh.w2w.clip_index]
    if clip.action is None:
        raise ValueError(f"{clip.name}: {clip.problem}")
    keep_pace(clip.action)
    source_beside.keep_pace_beside(clip.name)
    go_with(mesh, move=False)
    show_action(armature_of(mesh), clip.action)
    scene.use_preview_range = True
    scene.frame_preview_start = int(FIRST_FRAME)
    scene.frame_preview_end = round(FIRST_FRAME + (clip.n_frames - 1) * key_rate(clip.action) / clip.rate)
    scene.frame_set(int(FIRST_FRAME))


class W2W_OT_show_source(operators.OnBody, bpy.types.Operator):
    """Show the active clip's own armature next to the body, or take it away again"""

    bl_label = "Show Source Beside"

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        clips = body.w2w.clips
        has_one = len(clips) > 0 and has_source(clips[body.w2w.clip_index])
        return "" if has_one else "The active clip has no armature of its own"

    def work(self, context: bpy.types.Context, mesh: bpy.types.Object) -> None:
        clip = mesh.w2w.clips[mesh.w2w.clip_index]
        if source_beside.source_collections(clip.name):
            source_beside.remove_source(clip.name)
            return
        source_beside.remove_source()
        with restated(f"{clip.name}:", UnusableMotion):
            known = PoseFacts(clip.given_rate or None, up=clip.given_up or None)
            source_beside.show_source(mesh, clip.name, Path(clip.file), clip.scale, known)
        show_clip(context.scene, mesh)


class W2W_OT_relabel_clips(operators.OnClips, bpy.types.Operator):
    """Give all ticked clips the same activity"""

    bl_label = "Relabel Ticked"

    activity: StringProperty(name="Activity", description="Label for all ticked clips")

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        clips = state.selected(state.polled_body(context).w2w)
        self.activity = clips[0].activity if clips else ""
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        if not self.activity.strip():
            raise ValueError("Type an activity: clips without one cannot be ranked")
        clips = state.selected(body.w2w)
        label = lists.listed_spelling(body.w2w, self.activity, "activity", {clip.name for clip in clips})
        with state.without_updates():
            for clip in clips:
                clip.activity = label
        lists.list_labels(body.w2w)
        self.report({"INFO"}, f"{len(clips)} clips are now '{label}'")


class W2W_OT_remove_clips(operators.OnClips, bpy.types.Operator):
    """Remove the ticked clips, or the active one if none is ticked, with their actions"""

    def work(self, context: bpy.types.Context, mesh: bpy.types.Object) -> None:
        clips = mesh.w2w.clips
        ticked = [index for index, clip in enumerate(clips) if clip.selected] or [mesh.w2w.clip_index]
        for index in ticked:
            source_beside.remove_source(clips[index].name)
        remove_clips(mesh, ticked)


class W2W_OT_tick_clips(operators.OnClips, bpy.types.Operator):
    """Tick clips for Relabel, Remove and Bake"""

    which: EnumProperty(
        name="Which",
        items=(
            ("ALL", "All", "Tick all clips"),
            ("NONE", "None", "Tick no clip"),
            ("INVERT", "Invert", "Tick the clips that are not ticked, and only those"),
            ("ACTIVITY", "Same Activity", "Tick the clips of the active clip's activity"),
            ("PROBLEM", "Unusable", "Tick the files that cannot be used"),
        ),
    )

    def work(self, context: bpy.types.Context, body: bpy.types.Object) -> None:
        study = body.w2w
        active = study.clips[study.clip_index].activity
        for clip in study.clips:
            clip.selected = {
                "ALL": True,
                "NONE": False,
                "INVERT": not clip.selected,
                "ACTIVITY": clip.activity == active,
                "PROBLEM": bool(clip.problem),
            }[self.which]


def has_source(clip: bpy.types.PropertyGroup) -> bool:
    """Whether a clip's own armature can be shown: of a run's clips only the name of the file is known.

    With one of several animations the importer brings the others, too.
    """
    file, is_alone = Path(clip.file), clip.action is not None and not clip.animation
    return is_alone and file.is_absolute() and file.suffix.lower() in (".fbx", ".bvh")
