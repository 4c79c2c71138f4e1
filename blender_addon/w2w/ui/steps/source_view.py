# SPDX-License-Identifier: GPL-3.0-or-later
"""The button that shows a clip's own armature beside the body."""

from __future__ import annotations

from pathlib import Path

import bpy

from ...core.motion.source import UnusableMotion
from ...scene.motion.source_beside import remove_source, show_source, source_collections
from ..jobs import jobs
from ..study.state import current_body


class W2W_OT_show_source(bpy.types.Operator):
    """Show the active clip's own armature beside the body, or take it away again"""

    bl_idname = "w2w.show_source"
    bl_label = "Show Source Beside"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        mesh = current_body(context)
        cls.poll_message_set("The active clip has no armature of its own")
        if mesh is None or context.mode != "OBJECT" or jobs.running is not None or not len(mesh.w2w.clips):
            return False
        return has_source(mesh.w2w.clips[mesh.w2w.clip_index])

    def execute(self, context: bpy.types.Context) -> set[str]:
        mesh = current_body(context)
        clip = mesh.w2w.clips[mesh.w2w.clip_index]
        if source_collections(clip.name):
            remove_source(clip.name)
            return {"FINISHED"}
        remove_source()
        try:
            show_source(mesh, clip.name, Path(clip.file), clip.scale)
        except UnusableMotion as error:
            return jobs.show_error(self, f"{clip.name}: {error}")
        bpy.ops.w2w.preview_clip(index=mesh.w2w.clip_index)
        return {"FINISHED"}


def has_source(clip: bpy.types.PropertyGroup) -> bool:
    """Whether a clip's own armature can be shown; of a run's clips only the name of the file is known."""
    file = Path(clip.file)
    return clip.action is not None and file.suffix.lower() in (".fbx", ".bvh") and file.is_absolute()
