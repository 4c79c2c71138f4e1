# SPDX-License-Identifier: GPL-3.0-or-later
"""The W2W tab of the 3D view's sidebar: the steps, each saying what it still needs."""

from pathlib import Path

import bpy

from ...core.ranking.utility import CLASSIFIERS
from ...core.wording import capital, count, shortened
from ...scene.motion.source_beside import source_collections
from ..files.open_results import misses_folder
from ..jobs import jobs
from ..jobs.text import draw_text, in_panel, styled
from ..steps.baking import UNBAKED
from ..steps.body import draw_sliders
from ..steps.motions import has_source, is_playing
from ..study import signal_cache, state
from ..study.counting import Group
from .base import Body, Layout, PartPanel, StepPanel, draw_info, draw_note, draw_parameters

ICONS = {state.BAKED: "CHECKMARK", state.STALE: "FILE_REFRESH", state.FAILED: "ERROR"}
"""Icons of the clip states."""

ROW_TAKEN, NAME_MARGINS, FIELD_MARGINS = 126, 14, 18
"""Pixels that a row of the list of clips, a name and a field in it have for no text, at a scale of 1."""


class W2W_PT_body(StepPanel, bpy.types.Panel):
    """The body."""

    def missing(self, body: Body) -> str:
        return ""

    def is_done(self, body: bpy.types.Object) -> bool:
        return True

    def draw_step(self, context: bpy.types.Context, layout: Layout, body: Body) -> None:
        if body is None:
            layout.operator("w2w.add_body", icon="OUTLINER_OB_ARMATURE")
            layout.operator("w2w.load_body", icon="FILE_FOLDER")
            layout.operator("w2w.use_mesh", icon="MESH_DATA")
            layout.operator("w2w.open_results", icon="IMPORT")
            return
        row = layout.row(align=True)
        row.label(text=body.name, icon="OUTLINER_OB_MESH", translate=False)
        row.prop(body.w2w, "show_armature", text="", icon="ARMATURE_DATA")
        row.operator("w2w.select_body", text="", icon="RESTRICT_SELECT_OFF")
        row.operator("w2w.add_body", text="", icon="ADD")
        row.operator("w2w.open_results", text="", icon="IMPORT")
        other = state.body_of_object(context.object)
        if context.object is not None and context.object.type == "MESH" and other is not body:
            layout.operator("w2w.use_mesh", icon="MESH_DATA")


class W2W_PT_shape(PartPanel, bpy.types.Panel):
    """The shape of W2W's own body."""

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None and body.w2w.has_shape

    def draw_header_preset(self, context: bpy.types.Context) -> None:
        self.layout.operator("w2w.reset_shape", text="", icon="LOOP_BACK", emboss=False)

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout, enabled=jobs.running is None and context.mode == "OBJECT")
        draw_sliders(layout, state.polled_body(context).w2w.shape)


class W2W_UL_clips(bpy.types.UIList):
    """Clips, a line each: tick, name, activity, to be edited in place, and state."""

    def draw_item(
        self, context: bpy.types.Context, layout: Layout, data: Group, item: Group, icon: int,
        active_data: Group, active_propname: str,
    ) -> None:  # fmt: skip
        found = state.state_of(item, state.bake_settings(data))
        row = styled(layout.row(align=True), alert=found == state.FAILED)
        tick = "CHECKBOX_HLT" if item.selected else "CHECKBOX_DEHLT"
        row.prop(item, "selected", text="", emboss=False, icon=tick)
        scale = context.preferences.system.ui_scale
        room = context.region.width - ROW_TAKEN * scale
        share = 1.0 if found == state.FAILED else 1 - activity_share(data, room, scale)
        split = row.split(factor=share)
        shown = shortened(Path(item.file).stem or item.name, share * room - NAME_MARGINS * scale, in_panel)
        split.label(text=shown, translate=False)
        if found != state.FAILED:
            split.prop(item, "activity", text="", emboss=False, placeholder="activity")
        playing = state.playing_clip(data.id_data) == item
        mark = "ERROR" if item.bake_path.startswith(UNBAKED) else ICONS.get(found, "BLANK1")
        if found == state.BAKED and signal_cache.is_lost(item):
            mark = ICONS[state.STALE]
        row.label(text="", icon="PLAY" if playing else mark)

    def filter_items(
        self, context: bpy.types.Context, data: Group, propname: str
    ) -> tuple[list[int], list[int]]:
        """Those of a name that is looked for; files that cannot be used come last."""
        clips, shown = data.clips, self.bitflag_filter_item
        by_name = bpy.types.UI_UL_list.filter_items_by_name
        flags = by_name(self.filter_name, shown, clips, "name") if self.filter_name else []
        last = sorted(range(len(clips)), key=lambda index: bool(clips[index].problem))
        places = sorted(range(len(clips)), key=last.__getitem__)
        return flags, places


def activity_share(study: Group, room: float, scale: float) -> float:
    """The part of a row of clips that the longest name of an activity needs, from .2 to .6."""
    longest = max((in_panel(row.name) for row in study.activities), default=0.0)
    return min(max((longest + FIELD_MARGINS * scale) / max(room, 1.0), 0.2), 0.6)


class W2W_PT_motions(StepPanel, bpy.types.Panel):
    """The clips and their labels."""

    @staticmethod
    def is_wanted(body: Body) -> bool:
        return body is not None

    def is_done(self, body: bpy.types.Object) -> bool:
        return bool(state.usable(body.w2w))

    def draw_step(self, context: bpy.types.Context, layout: Layout, body: Body) -> None:
        study = body.w2w
        row = layout.row(align=True)
        row.operator("w2w.import_motions", text="Files", translate=False, icon="FILE")
        row.operator("w2w.import_folder", text="Folder", translate=False, icon="FILE_FOLDER")
        row.operator("w2w.use_scene_animation", text="Scene", translate=False, icon="OUTLINER_OB_ARMATURE")
        if not len(study.clips):
            layout.label(text="FBX, BVH, AMASS npz or smpl files", translate=False, icon="INFO")
            return
        layout.template_list("W2W_UL_clips", "", study, "clips", study, "clip_index", rows=6, maxrows=6)
        row = layout.row(align=True)
        row.operator_menu_enum("w2w.tick_clips", "which", text="Tick", translate=False, icon="CHECKBOX_HLT")
        row.operator("w2w.relabel_clips", text="Relabel", translate=False, icon="GREASEPENCIL")
        row.operator("w2w.remove_clips", text="", icon="TRASH")
        self.draw_active(context, layout, study)

    def draw_active(self, context: bpy.types.Context, layout: Layout, study: bpy.types.PropertyGroup) -> None:
        """Draw what there is to know about the active clip."""
        activities = [clip.activity.strip() for clip in state.usable(study)]
        failed = sum(bool(clip.problem) for clip in study.clips)
        text = f"{count('clip', len(activities))}, {count('activity', len(set(activities) - {''}))}"
        if "" in activities:
            text = f"{text}, {activities.count('')} without one"
        layout.label(text=f"{text}, {failed} unusable" if failed else text, translate=False)
        if not 0 <= study.clip_index < len(study.clips):
            return
        clip = study.clips[study.clip_index]
        if clip.problem:
            draw_text(layout, context, capital(clip.problem), icon="ERROR")
            if clip.file:
                draw_bone_map(layout.row(align=True))
            return
        layout.prop(clip, "subject")
        skeleton, activity = clip.skeleton or "own", clip.activity or "no activity"
        about = f"{activity}, {clip.n_frames} frames at {clip.rate:g} fps, {skeleton} skeleton"
        draw_note(layout, context, f"{Path(clip.file).stem or clip.name}: {about}")
        row = layout.row(align=True)
        text, icon = ("Stop", "PAUSE") if is_playing(context, study.id_data) else ("Preview", "PLAY")
        row.operator("w2w.preview_clip", text=text, translate=False, icon=icon).index = study.clip_index
        if has_source(clip):
            shown = bool(source_collections(clip.name))
            row.operator(
                "w2w.show_source", text="Source Beside", translate=False, icon="ARMATURE_DATA", depress=shown
            )
            draw_bone_map(layout.row(align=True))


def draw_bone_map(row: Layout) -> None:
    """Draw the buttons for files whose bones were matched wrongly."""
    row.operator("w2w.map_bones", icon="BONE_DATA")
    row.operator("w2w.load_bone_map", text="", icon="FILE_FOLDER")


class W2W_PT_patches(StepPanel, bpy.types.Panel):
    """The spots that are tried."""

    def is_done(self, body: bpy.types.Object) -> bool:
        return state.patches_of(body) is not None

    def draw_step(self, context: bpy.types.Context, layout: Layout, body: Body) -> None:
        study, placed = body.w2w, state.patches_of(body)
        layout.prop(study, "patch_count", text="Spots", translate=False)
        layout.prop(study, "patch_seed")
        row = styled(layout.row(align=True), scale_y=1.2)
        text = "Place Again" if placed else "Place Spots"
        row.operator("w2w.place_patches", text=text, translate=False, icon="STICKY_UVS_DISABLE")
        if placed is not None:
            row.operator("w2w.remove_patches", text="", icon="TRASH")
            layout.prop(study, "patch_size")
            layout.prop(study, "show_patches")
            layout.operator_menu_enum("w2w.bake_patches", "which", icon="KEYFRAME")


class W2W_PT_signals(StepPanel, bpy.types.Panel):
    """The sensor and its signals."""

    def missing(self, body: Body) -> str:
        return state.missing_for_bake(body)

    def is_done(self, body: bpy.types.Object) -> bool:
        if state.missing_for_bake(body) or misses_folder(body.w2w):
            return False
        baked = [clip for clip in state.baked(body.w2w) if not signal_cache.is_lost(clip)]
        return len(baked) == len(state.usable(body.w2w))

    def draw_step(self, context: bpy.types.Context, layout: Layout, body: Body) -> None:
        study = body.w2w
        row = layout.row(align=True)
        row.prop(study, "sensor")
        row.menu("W2W_MT_study_presets", text="", icon="PRESET")
        draw_parameters(layout, study, "signals")
        row = styled(layout.row(align=True), scale_y=1.2)
        row.operator("w2w.bake_signals", text="Bake All", translate=False, icon="REC").which = "ALL"
        ticked = sum(clip.selected for clip in study.clips)
        text = f"Bake Ticked ({ticked})" if ticked else "Bake This Clip"
        row.operator("w2w.bake_signals", text=text, translate=False).which = "TICKED"
        if not misses_folder(study):
            baked = state.baked(study)
            lost = sum(map(signal_cache.is_lost, baked))
            text = f"{len(baked) - lost} of {len(state.usable(study))} clips are up to date"
            draw_info(
                layout, context, f"{text}; the signals of {lost} are gone from the cache" if lost else text
            )
        if 0 <= study.clip_index < len(study.clips):
            clip = study.clips[study.clip_index]
            if clip.bake_path.startswith(("general", UNBAKED)):
                draw_info(layout, context, f"{clip.name}: {clip.bake_path}")


class W2W_PT_utility(StepPanel, bpy.types.Panel):
    """How well each spot tells the activities apart."""

    def missing(self, body: Body) -> str:
        return "" if body is not None and state.is_ranked(body) else state.missing_for_any_rank(body)

    def is_done(self, body: bpy.types.Object) -> bool:
        return not state.outdated_at_a_glance(body) and state.is_up_to_date(body.w2w)

    def draw_step(self, context: bpy.types.Context, layout: Layout, body: Body) -> None:
        study = body.w2w
        layout.prop(study, "window_s")
        if len(CLASSIFIERS) > 1:  # the extension has one, Python packages bring others
            layout.prop(study, "classifier")
        layout.prop(study, "by_subject")
        if not study.by_subject:
            layout.prop(study, "folds")
        draw_parameters(layout, study, "ranking", "classifier", "by_subject", "folds")
        row = styled(layout.row(align=True), scale_y=1.2)
        ranked = state.utility_of(study) is not None
        row.operator(
            "w2w.rank_patches",
            text="Score Again" if ranked else "Score Spots",
            translate=False,
            icon="SORT_DESC",
        )
        missing = state.missing_for_rank(body) or state.unreadable_ranking(study)
        if missing:
            draw_info(layout, context, missing)
        elif outdated := state.outdated_at_a_glance(body):
            draw_info(layout, context, f"{outdated}: score again")
        elif ranked and not state.is_up_to_date(study):
            draw_info(layout, context, "Activity weights have changed: score again")
