# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's reader of motion files, handed to `core.reading`; it imports Blender once there is a file."""

from pathlib import Path

from ...core.keypoints.facts import PoseFacts
from ...core.motion.sight import stood
from ...core.motion.source import SourceMotion
from ...core.motion.up import Ups


def read_by_blender(path: Path, pose: PoseFacts, _ups: Ups, animation: str) -> SourceMotion:
    """Read FBX, glTF or USD, or one animation in it; see `read_motion`."""
    from .takes import read_clip, written_up

    found = read_clip(path, pose.rate, animation)
    return found if pose.up is None else stood(found, pose.up, written_up(path))
