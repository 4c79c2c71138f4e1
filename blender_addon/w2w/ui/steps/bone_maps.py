# SPDX-License-Identifier: GPL-3.0-or-later
"""The user's bone maps: edited here or loaded, and used for every later file of that rig."""

from contextlib import suppress
from functools import partial
from pathlib import Path

import bpy
from bpy.props import CollectionProperty, StringProperty

from ...core.body.body import JOINT_INDEX, JOINT_NAMES
from ...core.files import file_sha256, write_json, write_text
from ...core.keypoints.facts import PoseFacts
from ...core.library.library import Clip
from ...core.motion.source import SourceMotion, UnusableMotion
from ...core.reading.clips import How, read_clip, to_body
from ...core.reading.reader import Reader
from ...core.retargeting.bone_maps import REQUIRED_JOINTS, BoneMap, best_match
from ...core.retargeting.retarget import matched_joints
from ...core.wording import capital, restated
from ...scene.base.body import body_of
from ...scene.motion.load import read_by_blender
from ..jobs import jobs
from ..jobs.text import styled
from ..study import operators, state
from .motion_import import map_folder, saved_maps, set_motion

WIDTH = 420
"""Pixels of the dialog at a scale of 1."""

ORDER = tuple(dict.fromkeys((*REQUIRED_JOINTS, *JOINT_NAMES)))
"""The joints; the required ones come first."""


class W2W_PG_mapped_joint(bpy.types.PropertyGroup):
    """A joint of the body, its `name`, and the bone that plays it."""

    bone: StringProperty(name="Bone", description="Bone of the file that plays this joint")


class W2W_OT_map_bones(operators.OnClips, bpy.types.Operator):
    """Match bones of the active clip's file with the body's joints; kept for all files of that rig"""

    rig: StringProperty(name="Rig", description="Name of the rig; a map of that name is replaced")
    joints: CollectionProperty(type=W2W_PG_mapped_joint, options={"SKIP_SAVE"})
    bones: CollectionProperty(type=bpy.types.PropertyGroup, options={"SKIP_SAVE", "HIDDEN"})

    @staticmethod
    def missing(context: bpy.types.Context, body: bpy.types.Object) -> str:
        clips = body.w2w.clips
        file = Path(clips[body.w2w.clip_index].file if clips else "")
        has_file = file.is_absolute() and file.is_file()  # of a run's clips only the name is known
        return "" if has_file else "The file of the active clip is not there"

    def invoke(self, context: bpy.types.Context, event: bpy.types.Event) -> set[str]:
        study = state.polled_body(context).w2w
        clip = study.clips[study.clip_index]
        path = Path(clip.file)
        try:
            source, maps = _with_bones(clip), saved_maps()
        except jobs.EXPECTED as error:
            return jobs.show_error(self, f"{path.name}: {error}")
        found, matched = best_match(source.bones, maps)
        self.rig = found.name if found in maps else path.stem
        with suppress(UnusableMotion):  # by the structure of the skeleton, where names say too little
            matched = matched_joints(source, maps)[1]
        for bone in source.bones:
            self.bones.add().name = bone
        for joint in ORDER:
            row, number = self.joints.add(), matched.get(JOINT_INDEX[joint])
            row.name, row.bone = joint, "" if number is None else source.bones[number]
        return context.window_manager.invoke_props_dialog(self, width=WIDTH)

    def draw(self, context: bpy.types.Context) -> None:
        layout = styled(self.layout, use_property_split=True)
        layout.prop(self, "rig")
        column = layout.column(align=True)
        for number, row in enumerate(self.joints):
            if number == len(REQUIRED_JOINTS):
                column.separator()
                column.label(text="If the rig has them", translate=False, icon="INFO")
            line = styled(column.row(), alert=number < len(REQUIRED_JOINTS) and not row.bone)
            line.prop_search(row, "bone", self, "bones", text=capital(row.name.replace("_", " ")))

    def work(self, context: bpy.types.Context, mesh: bpy.types.Object) -> str:
        joints = {row.name: [row.bone] for row in self.joints if row.bone}
        if missing := [joint for joint in REQUIRED_JOINTS if joint not in joints]:
            raise ValueError(f"No bone is given for: {', '.join(missing).replace('_', ' ')}")
        rig = self.rig.strip() or "own rig"
        path = _path_of(rig)
        write_json(path, {"name": rig, "joints": joints})
        clip = mesh.w2w.clips[mesh.w2w.clip_index]
        with restated(f"{clip.name}:", jobs.EXPECTED):
            retargeted = to_body(_with_bones(clip), body_of(mesh), [BoneMap.load(path)])
            clip.source_sha256 = file_sha256(Path(clip.file))
        set_motion(clip, retargeted)
        return f"{clip.name} was read by the bone map '{rig}', kept in {path}"


class W2W_OT_load_bone_map(operators.AsksForFile, operators.WorkOperator, bpy.types.Operator):
    """Keep a bone map from a file, for all motions imported from now on"""

    bl_options = {"REGISTER"}

    filter_glob: StringProperty(default="*.json", options={"HIDDEN"})

    def work(self, context: bpy.types.Context, _body: bpy.types.Object | None) -> str:
        rig = BoneMap.load(self.path()).name
        write_text(_path_of(rig), self.path().read_text(encoding="utf-8"))
        return f"Files of the rig '{rig}' are read by this bone map from now on"


def _path_of(rig: str) -> Path:
    return map_folder() / f"{bpy.path.clean_name(rig)}.json"


def _with_bones(clip: bpy.types.PropertyGroup) -> SourceMotion:
    """The motion of a clip's file, which names its bones."""
    how = How(pose=PoseFacts(up=clip.given_up or None), blender=read_by_blender)
    file = Clip(Path(clip.file), clip.file, "", "", animation=clip.animation, rate=clip.given_rate)
    with Reader() as reader:
        source = reader.read(file.path, partial(read_clip, file, how))
    if not isinstance(source, SourceMotion):
        raise UnusableMotion("it names no bones that could be mapped")
    return source
