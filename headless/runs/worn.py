# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the sensors on garments are in a clip, followed by Blender."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

from w2w.core.body.body import Body
from w2w.core.garments.cover import FITTED, Cover, load_covers
from w2w.core.garments.findings import caught_content
from w2w.core.garments.on_cloth import Worn
from w2w.core.motion.motion import Motion
from w2w.core.patches.patches import PatchSet
from w2w.core.study import measured
from w2w.scene.output import quiet_output

from ..blender import forget_scripts_path
from ..needs_blender import needs_blender
from .clip_task import ClipTask


def worn_in(task: ClipTask, body: Body, patches: PatchSet, motion: Motion) -> Worn | None:
    """Where the sensors on garments are in a clip; None where nothing is worn.

    Raises
    ------
    ValueError
        If a garment's file is gone, or its cloth flies apart.
    NoBlenderError
        If Blender's module cannot be imported.
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


@cache
def _covers(out: Path, inputs: str) -> Mapping[str, Cover]:  # noqa: ARG001 - a key of the cache
    """What the study's garments cover, read once a worker and study."""
    return load_covers(out / FITTED)
