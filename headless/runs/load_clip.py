# SPDX-License-Identifier: GPL-3.0-or-later
"""Read a clip's file for the body, with Blender where it must, silently."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from w2w.core.body.body import Body
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.pose_files import NO_FACTS, JointPositions
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.library import Clip
from w2w.core.motion.motion import Motion
from w2w.core.motion.source import SourceMotion
from w2w.scene.base.output import quiet_output

from ..blender import forget_scripts_path, needs_blender


def load_clip(
    clip: Clip, body: Body, bone_maps: Sequence[BoneMap] = (), pose: PoseFacts = NO_FACTS
) -> tuple[SourceMotion | Motion | JointPositions, Motion, dict[str, Any]]:
    """Read a clip's file and retarget it to the body, under the clip's labels.

    Returns what the file holds, the motion, and facts: take, skeleton, scale, frames, rate, duration. Raises
    UnusableMotion and NoBlenderError.
    """
    forget_scripts_path()
    from w2w.scene.motion.load import carry, read_motion

    with needs_blender(), quiet_output():
        source = read_motion(clip.path, pose)
    carried = carry(source, body, bone_maps)
    motion = carried.motion.labelled(clip.activity, clip.subject, clip.name)
    details = {
        "take": carried.take,
        "skeleton": carried.skeleton,
        "frames": motion.n_frames,
        "frame_rate": motion.rate,
        "duration_s": round(motion.duration, 4),
        "scale": carried.scale,
    }
    if isinstance(source, SourceMotion) and source.people > 1:
        details["people"] = source.people
    return source, motion, details
