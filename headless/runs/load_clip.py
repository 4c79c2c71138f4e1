# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender does for a clip, silently: read its file for the body, and follow the garments worn in it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from w2w.core.body.body import Body
from w2w.core.garments.cover import FITTED, Cover, load_covers
from w2w.core.garments.findings import caught_content
from w2w.core.garments.on_cloth import Worn
from w2w.core.keypoints.facts import PoseFacts
from w2w.core.keypoints.pose_files import NO_FACTS, JointPositions
from w2w.core.motion.bone_maps import BoneMap
from w2w.core.motion.library import Clip
from w2w.core.motion.motion import Motion
from w2w.core.motion.source import SourceMotion
from w2w.core.patches.patches import PatchSet
from w2w.core.study import measured
from w2w.scene.output import quiet_output

from ..blender import forget_scripts_path, needs_blender
from .clip_task import ClipTask


def load_clip(
    clip: Clip, body: Body, bone_maps: Sequence[BoneMap] = (), pose: PoseFacts = NO_FACTS
) -> tuple[SourceMotion | Motion | JointPositions, Motion, dict[str, Any]]:
    """Read a clip's file and retarget it to the body, under the clip's labels.

    Returns what the file holds, the motion, and facts: take, skeleton, scale, frames, rate, duration. Raises
    UnusableMotion and NoBlenderError.
    """
    forget_scripts_path()
    from w2w.scene.load import carry, read_motion

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


def worn_in(task: ClipTask, body: Body, patches: PatchSet, motion: Motion) -> Worn | None:
    """Where the sensors on garments are in a clip, followed by Blender; None where nothing is worn.

    A ValueError says that a garment's file is gone, or its cloth flies apart.
    """
    if not task.config.garments:
        return None
    covers = _covers(task.out, task.inputs)
    forget_scripts_path()
    with needs_blender(), quiet_output():
        from w2w.scene.garments.wear import worn_through

        return worn_through(body, patches, covers, measured(motion, task.config))


def caught_in(task: ClipTask, worn: Worn | None) -> dict[str, Any]:
    """What the clip's record says of cloth that caught on the body."""
    if worn is None:
        return {}
    frames = dict(zip(_covers(task.out, task.inputs), worn.caught, strict=True))
    return caught_content(frames, len(worn.matrices))


@cache  # read once a worker and study
def _covers(out: Path, inputs: str) -> Mapping[str, Cover]:  # noqa: ARG001 - a key of the cache
    return load_covers(out / FITTED)
