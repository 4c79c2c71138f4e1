# SPDX-License-Identifier: GPL-3.0-or-later
"""Activities before there is a ranking: the panel lists those of the clips, to say what each shall count."""

from __future__ import annotations

import bpy

from .counting import list_activities
from .state import run_of, usable, without_updates


def list_labels(study: bpy.types.PropertyGroup) -> None:
    """List the activities of a study's clips, unless a ranking lists its own; what they count stays."""
    if study.utility_key:
        return
    labels = sorted({clip.activity for clip in usable(study) if clip.activity.strip()})
    if labels == [activity.name for activity in study.activities]:
        return
    with without_updates():
        list_activities(study, labels, run_of(study))
